// [DICOM PS3.5, 7 and annex A] Little endian only; big endian and deflated files are named and refused.
#include "turgor/io/dicom_elements.hpp"

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
constexpr std::size_t kLongestValue = 4096;  // of those that are kept [bytes]

struct Header {
  std::uint32_t tag = 0, length = 0;
  std::string vr;  // empty if implicit
};

/// Walks through the bytes. The first thing that is wrong ends the walk and is kept in `problem`.
class Walk {
 public:
  explicit Walk(FileWindow& file) : file_(file), file_size_(file.size()) {}

  std::uint64_t at = 0;
  std::string problem;

  std::uint32_t number(std::size_t size) {
    const std::string_view bytes = view(at, size);
    if (bytes.empty()) return fail("the file ends within an element"), 0;
    std::uint32_t value = 0;
    for (std::size_t i = size; i-- > 0;) value = value << 8 | static_cast<unsigned char>(bytes[i]);
    at += size;
    return value;
  }

  Header header(bool is_explicit) {
    Header h;
    if (++headers_ > kMostElements) return fail("more elements than any image has"), h;
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

  /// Moves behind a value; false if the file ends before.
  bool skip(const Header& h) {
    if (h.length > file_size_ - at)
      return fail_at(h.tag, fmt::format("of {} bytes runs beyond the end of the file", h.length)), false;
    at += h.length;
    return true;
  }
  std::string_view view(std::uint64_t from, std::size_t length) const { return file_.view(from, length); }

  /// The items of a sequence, up to `end` or, if that is not known, to the sequence's delimiter.
  void sequence(bool is_explicit, std::optional<std::uint64_t> end, int depth) {
    if (depth > kDeepest) return fail("sequences are nested too deep");
    while (problem.empty() && !(end && at >= *end)) {
      const Header item = header(is_explicit);
      if (!problem.empty() || (item.tag == kSequenceEnd && !end)) return;
      if (item.tag != kItem) return fail_at(item.tag, "stands where an item of a sequence was expected");
      if (item.length == kUndefined)
        dataset(is_explicit, std::nullopt, depth + 1);
      else if (item.length > file_size_ - at)
        return fail_at(item.tag, "runs beyond the end of the file");
      else
        dataset(is_explicit, at + item.length, depth + 1);
    }
    if (problem.empty() && end && at != *end) fail("a sequence and its items differ in length");
  }

  void value(const Header& h, bool is_explicit, int depth) {
    if (h.length == kUndefined) {
      if (is_explicit && h.vr != "SQ" && h.vr != "UN") return fail_at(h.tag, "has no length");
      return sequence(is_explicit && h.vr != "UN", std::nullopt, depth);
    }
    if (h.vr != "SQ") return void(skip(h));
    if (h.length > file_size_ - at) return void(skip(h));
    sequence(is_explicit, at + h.length, depth);
  }

  void dataset(bool is_explicit, std::optional<std::uint64_t> end, int depth) {
    while (problem.empty() && !(end && at >= *end)) {
      const Header h = header(is_explicit);
      if (!problem.empty() || (h.tag == kItemEnd && !end)) return;
      if (h.tag >> 16 == 0xfffe) return fail_at(h.tag, "stands outside of a sequence");
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
        fail_at(item.tag, "stands where a fragment of pixels was expected");
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
  static bool has_long_length(std::string_view vr) {
    for (const std::string_view known :
         {"OB", "OD", "OF", "OL", "OV", "OW", "SQ", "SV", "UC", "UN", "UR", "UT", "UV"})
      if (vr == known) return true;
    return false;
  }
  FileWindow& file_;
  std::uint64_t file_size_;
  std::size_t headers_ = 0;
};

std::string uid(std::string_view value) {
  const std::size_t end = value.find_last_not_of(std::string_view(" \0", 2));
  return std::string(value.substr(0, end == value.npos ? 0 : end + 1));
}

/// The elements of group 2, which are always explicit.
void read_meta(Walk& walk, DicomElements& found) {
  while (walk.problem.empty()) {
    if (walk.view(walk.at, 2) != std::string_view("\2\0", 2)) return;
    const Header h = walk.header(true);
    const std::uint64_t from = walk.at;
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
    return walk.fail("the pixels are not packed as the transfer syntax says");
  if (!found.is_encapsulated) {
    if (walk.skip(h)) found.pixel_length = h.length;
    return;
  }
  found.fragments = walk.fragments();
  for (const DicomFragment& fragment : found.fragments) found.pixel_length += fragment.length;
}

void read_dataset(Walk& walk, bool is_explicit, bool is_encapsulated, DicomElements& found) {
  while (walk.problem.empty() && !walk.is_at_end()) {
    const Header h = walk.header(is_explicit);
    if (!walk.problem.empty()) return;
    if (h.tag == kPixels) return read_pixels(walk, h, is_encapsulated, found);
    const std::uint64_t from = walk.at;
    walk.value(h, is_explicit, 0);
    if (walk.problem.empty() && h.length <= kLongestValue) found.values[h.tag] = walk.view(from, h.length);
  }
}

}  // namespace

FileWindow::FileWindow(const std::filesystem::path& file) : stream_(file, std::ios::binary) {
  std::error_code failed;
  const std::uintmax_t size = std::filesystem::file_size(file, failed);
  size_ = failed ? 0 : size;
}

std::string_view FileWindow::view(std::uint64_t at, std::size_t length) {
  constexpr std::size_t kWindow = std::size_t{1} << 15;  // most headers are shorter
  if (length > size_ || at > size_ - length) return {};
  if (at < start_ || at + length > start_ + bytes_.size()) {
    start_ = at;
    bytes_.resize(std::size_t(std::min<std::uint64_t>(std::max(length, kWindow), size_ - at)));
    stream_.clear();
    stream_.seekg(std::streamoff(at));
    stream_.read(bytes_.data(), std::streamsize(bytes_.size()));
    bytes_.resize(std::size_t(std::max<std::streamsize>(stream_.gcount(), 0)));
    if (bytes_.size() < length) return {};
  }
  return std::string_view(bytes_).substr(std::size_t(at - start_), length);
}

Status find_elements(FileWindow& file, DicomElements& found) {
  Walk walk(file);
  found.has_magic = walk.view(128, 4) == "DICM";
  if (found.has_magic) walk.at = 132;
  read_meta(walk, found);
  const std::string& syntax = found.transfer_syntax;
  constexpr std::string_view kStandard = "1.2.840.10008.1.2";
  if (syntax == "1.2.840.10008.1.2.2")
    return Error{"a DICOM file in big endian byte order (a retired transfer syntax), which is not read"};
  if (syntax == "1.2.840.10008.1.2.1.99")
    return Error{"a deflated DICOM file (a transfer syntax), which is not read"};
  if (!syntax.empty() && !syntax.starts_with(kStandard))
    return Error{fmt::format("a DICOM file of transfer syntax {}, which is not read", syntax)};
  const bool is_explicit = syntax.empty() ? looks_explicit(walk) : syntax != kStandard;
  const bool is_encapsulated = !syntax.empty() && syntax != kStandard && syntax != "1.2.840.10008.1.2.1";
  read_dataset(walk, is_explicit, is_encapsulated, found);
  if (!walk.problem.empty()) return Error{"truncated or corrupt DICOM file: " + walk.problem};
  return Done{};
}

}  // namespace turgor::io
