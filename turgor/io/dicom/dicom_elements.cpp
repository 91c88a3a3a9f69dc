// [DICOM PS3.5, 7 and annex A]
#include "turgor/io/dicom/dicom_elements.hpp"

#include <algorithm>
#include <optional>

#include <fmt/format.h>

namespace turgor::io {

namespace {

constexpr std::uint32_t kUndefined = 0xffffffff;
constexpr std::uint32_t kItem = 0xfffee000, kItemEnd = 0xfffee00d, kSequenceEnd = 0xfffee0dd,
                        kPixels = 0x7fe00010;
constexpr int kDeepest = 12;
constexpr std::size_t kMostElements = 4'000'000;
constexpr std::size_t kLongestValue = 4096;                 // longest value that is stored [bytes]
constexpr std::size_t kMostStored = std::size_t{64} << 20;  // of all stored values together [bytes]

// Sequences and elements in them that are stored.
constexpr std::uint32_t kShared = 0x52009229, kPerFrame = 0x52009230, kSegments = 0x00620002;
constexpr std::uint32_t kKept[] = {
    0x00180050, 0x00180088,               // SliceThickness, SpacingBetweenSlices
    0x00200032, 0x00200037, 0x00280030,   // ImagePositionPatient, ImageOrientationPatient, PixelSpacing
    0x00281052, 0x00281053,               // RescaleIntercept, RescaleSlope
    0x00620004, 0x00620005, 0x0062000b};  // SegmentNumber, SegmentLabel, ReferencedSegmentNumber

struct Header {
  std::uint32_t tag = 0, length = 0;
  std::string vr;  // empty if implicit
};

/// Parser for the elements. The first error stops it and is stored in `problem`.
class Walk {
 public:
  explicit Walk(FileWindow& file) : file_(file), file_size_(file.size()) {}

  std::uint64_t at = 0;
  std::string problem;
  bool is_big_endian = false;

  std::uint32_t number(std::size_t size) {
    const std::string_view bytes = view(at, size);
    if (bytes.empty()) return fail("the file ends within an element"), 0;
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < size; i++)
      value = value << 8 | static_cast<unsigned char>(bytes[is_big_endian ? i : size - 1 - i]);
    at += size;
    return value;
  }

  Header header(bool is_explicit) {
    Header h;
    if (++headers_ > kMostElements) return fail("too many elements for an image"), h;
    const std::uint32_t group = number(2);
    h.tag = group << 16 | number(2);
    if (group == 0xfffe || !is_explicit) {
      h.length = number(4);
      return h;
    }
    h.vr = view(at, 2);
    if (h.vr.empty()) return fail("the file ends within an element"), h;
    at += 2;
    if (h.vr[0] < 'A' || h.vr[0] > 'Z' || h.vr[1] < 'A' || h.vr[1] > 'Z')
      fail_at(h.tag, "has no value representation");
    const bool is_long = has_long_length(h.vr);
    if (is_long) number(2);
    h.length = number(is_long ? 4 : 2);
    return h;
  }

  /// Advances past a value; false if the file ends before.
  bool skip(const Header& h) {
    if (h.length > file_size_ - at)
      return fail_at(h.tag, fmt::format("of {} bytes runs beyond the end of the file", h.length)), false;
    at += h.length;
    return true;
  }
  std::string_view view(std::uint64_t from, std::size_t length) const { return file_.view(from, length); }
  /// View of a value that will be stored. All of them together are bounded, because a few deflated bytes may
  /// hold many.
  std::string_view stored(std::uint64_t from, std::size_t length) {
    if ((stored_ += length) <= kMostStored) return view(from, length);
    return fail("the header is too large for an image"), std::string_view();
  }

  /// Parses the items of a sequence, up to `end` or, if that is unknown, to the sequence's delimiter. Stored
  /// values of each item are added to `items`, if given.
  void sequence(bool is_explicit, std::optional<std::uint64_t> end, int depth,
                std::vector<DicomValues>* items = nullptr) {
    if (depth > kDeepest) return fail("sequences are nested too deep");
    while (problem.empty() && !(end && at >= *end)) {
      const Header item = header(is_explicit);
      if (!problem.empty() || (item.tag == kSequenceEnd && !end)) return;
      if (item.tag != kItem) return fail_at(item.tag, "found instead of an item of a sequence");
      if (items) kept_ = &items->emplace_back();
      if (item.length == kUndefined)
        dataset(is_explicit, std::nullopt, depth + 1);
      else if (item.length > file_size_ - at)
        return fail_at(item.tag, "runs beyond the end of the file");
      else
        dataset(is_explicit, at + item.length, depth + 1);
    }
    if (problem.empty() && end && at != *end) fail("a sequence and its items differ in length");
  }

  void value(const Header& h, bool is_explicit, int depth, std::vector<DicomValues>* items = nullptr) {
    if (h.length == kUndefined) {
      if (is_explicit && h.vr != "SQ" && h.vr != "UN") return fail_at(h.tag, "has no length");
      return sequence(is_explicit && h.vr != "UN", std::nullopt, depth, items);
    }
    const bool is_sequence = h.vr == "SQ" || (h.vr.empty() && is_sequence_of_frames(h.tag));
    if (!is_sequence || h.length > file_size_ - at) return keep(h);
    sequence(is_explicit, at + h.length, depth, items);
  }

  /// A sequence with stored values.
  void value_with_items(const Header& h, bool is_explicit, std::vector<DicomValues>& items) {
    items.clear();
    value(h, is_explicit, 0, &items);
    kept_ = nullptr;
  }

  void dataset(bool is_explicit, std::optional<std::uint64_t> end, int depth) {
    while (problem.empty() && !(end && at >= *end)) {
      const Header h = header(is_explicit);
      if (!problem.empty() || (h.tag == kItemEnd && !end)) return;
      if (h.tag >> 16 == 0xfffe) return fail_at(h.tag, "found outside a sequence");
      value(h, is_explicit, depth);
    }
    if (problem.empty() && end && at != *end) fail("an item and its elements differ in length");
  }

  /// Compressed pixels: items of known length and a delimiter. The first item is a table of offsets.
  std::vector<DicomFragment> fragments() {
    std::vector<DicomFragment> found;
    for (int count = 0; problem.empty(); count++) {
      const Header item = header(false);
      if (!problem.empty()) break;
      if (item.tag == kSequenceEnd && count > 1) return found;
      if (item.tag != kItem || item.length == kUndefined)
        fail_at(item.tag, "found instead of a fragment of pixels");
      else if (skip(item) && count > 0)
        found.push_back({at - item.length, item.length});
    }
    return found;
  }

  void fail(std::string what) {
    if (problem.empty()) problem = fmt::format("{} (at byte {})", what, at);
  }
  void fail_at(std::uint32_t tag, const std::string& what) {
    fail(fmt::format("element ({:04x},{:04x}) {}", tag >> 16, tag & 0xffff, what));
  }
  bool is_at_end() const { return at >= file_size_; }

 private:
  /// Sequences that hold the positions of frames and segments; needed when the value representation is
  /// implicit.
  static bool is_sequence_of_frames(std::uint32_t tag) {
    return tag == kShared || tag == kPerFrame || tag == kSegments || tag == 0x00209113 || tag == 0x00209116 ||
           tag == 0x00289110 || tag == 0x00289145 || tag == 0x0062000a;
  }
  /// Advances past a value; the first of its kind in an item is stored.
  void keep(const Header& h) {
    const std::uint64_t from = at;
    if (!skip(h) || !kept_ || h.length > kLongestValue) return;
    if (std::find(std::begin(kKept), std::end(kKept), h.tag) != std::end(kKept))
      kept_->emplace(h.tag, stored(from, h.length));
  }
  static bool has_long_length(std::string_view vr) {
    for (const std::string_view known :
         {"OB", "OD", "OF", "OL", "OV", "OW", "SQ", "SV", "UC", "UN", "UR", "UT", "UV"})
      if (vr == known) return true;
    return false;
  }
  FileWindow& file_;
  std::uint64_t file_size_;
  std::size_t headers_ = 0, stored_ = 0;
  DicomValues* kept_ = nullptr;  // of the current item
};

std::string uid(std::string_view value) {
  const std::size_t end = value.find_last_not_of(std::string_view(" \0", 2));
  return std::string(value.substr(0, end == value.npos ? 0 : end + 1));
}

/// Reads the elements of group 2, which are always explicit, up to the length that the first one gives.
void read_meta(Walk& walk, DicomElements& found) {
  std::optional<std::uint64_t> end;
  while (walk.problem.empty()) {
    found.dataset_offset = walk.at;
    if ((end && walk.at >= *end) || walk.view(walk.at, 2) != std::string_view("\2\0", 2)) return;
    const Header h = walk.header(true);
    const std::uint64_t from = walk.at;
    if (h.tag == 0x00020000 && h.length == 4) {
      const std::uint32_t length = walk.number(4);
      end = walk.at + length;
      continue;
    }
    if (!walk.problem.empty() || h.length == kUndefined || !walk.skip(h))
      return walk.fail("the file's meta information is corrupt");
    if (h.length > kLongestValue) continue;
    if (h.tag == 0x00020010) found.transfer_syntax = uid(walk.view(from, h.length));
    if (h.tag == 0x00020002) found.media_class = uid(walk.view(from, h.length));
  }
}

bool looks_explicit(const Walk& walk) {
  const std::string_view vr = walk.view(walk.at + 4, 2);
  return vr.size() == 2 && vr[0] >= 'A' && vr[0] <= 'Z' && vr[1] >= 'A' && vr[1] <= 'Z';
}

void read_pixels(Walk& walk, const Header& h, bool is_encapsulated, DicomElements& found) {
  found.pixel_offset = walk.at;
  found.is_encapsulated = h.length == kUndefined;
  if (found.is_encapsulated != is_encapsulated)
    return walk.fail("the encoding of the pixels contradicts the transfer syntax");
  if (!found.is_encapsulated) {
    if (walk.skip(h)) found.pixel_length = h.length;
    return;
  }
  found.fragments = walk.fragments();
  for (const DicomFragment& fragment : found.fragments) found.pixel_length += fragment.length;
}

std::vector<DicomValues>* items_of(std::uint32_t tag, DicomElements& found) {
  return tag == kShared     ? &found.shared
         : tag == kPerFrame ? &found.frames
         : tag == kSegments ? &found.segments
                            : nullptr;
}

void read_dataset(Walk& walk, bool is_explicit, bool is_encapsulated, DicomElements& found) {
  while (walk.problem.empty() && !walk.is_at_end()) {
    const Header h = walk.header(is_explicit);
    if (!walk.problem.empty()) return;
    if (h.tag == kPixels) return read_pixels(walk, h, is_encapsulated, found);
    if (std::vector<DicomValues>* items = items_of(h.tag, found)) {
      walk.value_with_items(h, is_explicit, *items);
      continue;
    }
    const std::uint64_t from = walk.at;
    walk.value(h, is_explicit, 0);
    if (walk.problem.empty() && h.length <= kLongestValue) found.values[h.tag] = walk.stored(from, h.length);
  }
}

// Transfer syntaxes. All supported ones begin like the first one.
constexpr std::string_view kStandard = "1.2.840.10008.1.2", kLittleEndian = "1.2.840.10008.1.2.1",
                           kBigEndian = "1.2.840.10008.1.2.2", kDeflated = "1.2.840.10008.1.2.1.99";

/// Length of the inflated data set, found in constant memory before anything of it is stored.
Result<std::uint64_t> inflated_size(const FileRange& range) {
  constexpr std::uint64_t kMost = std::uint64_t{5} << 30;  // pixels have at most 4 GiB
  InflatedStream stream(range);
  stream.read(kMost, {});
  char one = 0;
  if (stream.read(stream.position(), {&one, 1}) > 0)
    return Error{
        fmt::format("corrupt DICOM file: its deflated data is longer than {:.1f} GB", double(kMost) * 1e-9)};
  if (!stream.is_whole()) return Error{"truncated or corrupt DICOM file: its deflated data is damaged"};
  return stream.position();
}

Status find_deflated(const std::filesystem::path& file, DicomElements& found) {
  found.is_deflated = true;
  const FileRange range = deflated_dataset(file, found.dataset_offset);
  const Result<std::uint64_t> size = inflated_size(range);
  if (!size) return size.error();
  FileWindow window(range, *size);
  Walk walk(window);
  read_dataset(walk, true, false, found);
  if (!walk.problem.empty()) return Error{"truncated or corrupt DICOM file: " + walk.problem};
  return Done{};
}

}  // namespace

FileRange deflated_dataset(const std::filesystem::path& file, std::uint64_t dataset_offset) {
  std::error_code failed;
  const std::uintmax_t size = std::filesystem::file_size(file, failed);
  return {file, std::int64_t(dataset_offset), failed ? 0 : std::int64_t(size)};
}

FileWindow::FileWindow(const std::filesystem::path& file) : file_(file), stream_(file, std::ios::binary) {
  std::error_code failed;
  const std::uintmax_t size = std::filesystem::file_size(file, failed);
  size_ = failed ? 0 : size;
}

FileWindow::FileWindow(const FileRange& deflated, std::uint64_t inflated_size)
    : deflated_(deflated), inflated_(std::in_place, deflated), size_(inflated_size) {}

std::string_view FileWindow::view(std::uint64_t at, std::size_t length) {
  constexpr std::size_t kWindow = std::size_t{1} << 15;  // most headers are shorter
  if (length > size_ || at > size_ - length) return {};
  if (at < start_ || at + length > start_ + bytes_.size()) {
    const auto count = std::size_t(std::min<std::uint64_t>(std::max(length, kWindow), size_ - at));
    if (inflated_)
      load_inflated(at, count);
    else
      load(at, count);
    if (start_ + bytes_.size() < at + length) return {};
  }
  return std::string_view(bytes_).substr(std::size_t(at - start_), length);
}

void FileWindow::load(std::uint64_t at, std::size_t count) {
  start_ = at;
  bytes_.resize(count);
  stream_.clear();
  stream_.seekg(std::streamoff(at));
  stream_.read(bytes_.data(), std::streamsize(bytes_.size()));
  bytes_.resize(std::size_t(std::max<std::streamsize>(stream_.gcount(), 0)));
}

/// The window keeps some bytes before `at`, because the parser returns to short values that it has passed.
void FileWindow::load_inflated(std::uint64_t at, std::size_t count) {
  constexpr std::uint64_t kBefore = 2 * kLongestValue;
  if (at < start_) inflated_.emplace(deflated_), start_ = 0, bytes_.clear();
  const std::uint64_t end = start_ + bytes_.size(), from = std::max(start_, at - std::min(at, kBefore));
  bytes_.erase(0, std::size_t(std::min(from, end) - start_));
  start_ = from;
  const std::size_t kept = bytes_.size();
  bytes_.resize(std::size_t(at + count - start_));
  bytes_.resize(kept + inflated_->read(start_ + kept, std::span(bytes_).subspan(kept)));
}

Status find_elements(FileWindow& file, DicomElements& found) {
  Walk walk(file);
  found.has_magic = walk.view(128, 4) == "DICM";
  if (found.has_magic) walk.at = 132;
  read_meta(walk, found);
  const std::string& syntax = found.transfer_syntax;
  if (!syntax.empty() && !syntax.starts_with(kStandard))
    return Error{fmt::format("a DICOM file of transfer syntax {}, which is not supported", syntax)};
  if (syntax == kDeflated && walk.problem.empty()) return find_deflated(file.file(), found);
  const bool is_explicit = syntax.empty() ? looks_explicit(walk) : syntax != kStandard;
  walk.is_big_endian = found.is_big_endian = syntax == kBigEndian;
  const bool is_plain =
      syntax.empty() || syntax == kStandard || syntax == kLittleEndian || syntax == kBigEndian;
  read_dataset(walk, is_explicit, !is_plain, found);
  if (!walk.problem.empty()) return Error{"truncated or corrupt DICOM file: " + walk.problem};
  return Done{};
}

}  // namespace turgor::io
