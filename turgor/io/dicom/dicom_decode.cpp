// Decoding of compressed DICOM samples by GDCM in child processes. GDCM's codecs crash on some damaged
// images, and a damaged file must give an error message instead of ending the program.
#include <algorithm>
#include <atomic>
#include <fstream>
#include <new>

#include <fmt/format.h>
#include <gdcmImage.h>
#include <gdcmSequenceOfFragments.h>
#include <sys/mman.h>

#include "turgor/io/dicom/dicom.hpp"
#include "turgor/io/files/child.hpp"

namespace turgor::io {

namespace {

enum class Progressed : std::uint8_t { kWaiting, kWorking, kDone, kRefused };

// A slice takes far less than a second; a codec that needs longer is in an endless loop.
constexpr double kSecondsPerSlice = 60;
// Damaged images make codecs request unlimited memory. The limit covers the decoding of one slice.
constexpr std::size_t kCodecBytes = std::size_t{256} << 20, kBytesPerSample = 32;

/// Memory that child processes share with this one.
class SharedMemory {
 public:
  explicit SharedMemory(std::size_t size)
      : size_(size), data_(mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0)) {}
  ~SharedMemory() {
    if (*this) munmap(data_, size_);
  }
  SharedMemory(const SharedMemory&) = delete;
  SharedMemory& operator=(const SharedMemory&) = delete;
  explicit operator bool() const { return data_ != MAP_FAILED; }
  char* data() const { return static_cast<char*>(data_); }

 private:
  std::size_t size_;
  void* data_;
};

/// Result of a child for one slice, besides its samples.
struct Decoded {
  std::atomic<Progressed> state;
  ChangedSamples changed;
};

struct Work {
  std::span<const DicomSlice* const> slices;
  std::size_t area;       // samples of a slice
  std::int16_t* samples;  // shared, all slices in order
  Decoded* decoded;       // shared, one per slice
};

/// Compressed pixels in GDCM's type.
gdcm::SmartPointer<gdcm::SequenceOfFragments> load_fragments(const DicomSlice& slice) {
  gdcm::SmartPointer<gdcm::SequenceOfFragments> sequence = new gdcm::SequenceOfFragments;
  std::ifstream stream(slice.file, std::ios::binary);
  for (const DicomFragment& piece : slice.fragments) {
    std::vector<char> bytes(piece.length);
    stream.seekg(std::streamoff(piece.offset));
    stream.read(bytes.data(), std::streamsize(piece.length));
    gdcm::Fragment fragment;
    fragment.SetByteValue(bytes.data(), std::uint32_t(piece.length));
    sequence->AddFragment(fragment);
  }
  return sequence;
}

/// False if GDCM fails; it may also crash.
bool decode(const DicomSlice& slice, std::span<std::int16_t> hu, ChangedSamples& changed) {
  gdcm::Image image;
  image.SetNumberOfDimensions(2);
  image.SetDimension(0, unsigned(slice.columns));
  image.SetDimension(1, unsigned(slice.rows));
  const auto bits = [](int count) { return static_cast<unsigned short>(count); };
  image.SetPixelFormat(gdcm::PixelFormat(1, bits(slice.bits_allocated), bits(slice.bits_stored),
                                         bits(slice.bits_stored - 1), bits(slice.is_signed)));
  image.SetPhotometricInterpretation(gdcm::PhotometricInterpretation::MONOCHROME2);
  image.SetTransferSyntax(gdcm::TransferSyntax::GetTSType(slice.transfer_syntax.c_str()));
  gdcm::DataElement pixels(gdcm::Tag(0x7fe0, 0x0010));
  pixels.SetVR(gdcm::VR::OB);
  pixels.SetValue(*load_fragments(slice));
  image.SetDataElement(pixels);
  const std::size_t byte_count = hu.size() * std::size_t(slice.bits_allocated) / 8;
  if (image.GetBufferLength() != byte_count) return false;
  std::vector<char> stored(byte_count);
  if (!image.GetBuffer(stored.data())) return false;
  changed = convert_to_hu(slice, stored.data(), hu);
  return true;
}

/// Work of a child: every step-th slice.
int decode_stripe(const Work& work, std::size_t first, std::size_t step) {
  for (std::size_t k = first; k < work.slices.size(); k += step) {
    Decoded& decoded = work.decoded[k];
    decoded.state = Progressed::kWorking;
    bool done = false;
    try {
      done = decode(*work.slices[k], std::span(work.samples + k * work.area, work.area), decoded.changed);
    } catch (const std::bad_alloc&) {
      throw;
    } catch (...) {
    }
    decoded.state = done ? Progressed::kDone : Progressed::kRefused;
  }
  return 0;
}

std::vector<ChildEnd> decode_all(const Work& work, std::size_t count, const ChildLimits& limits,
                                 const Progress& progress) {
  std::vector<Child> children;
  for (std::size_t c = 0; c < count; c++)
    children.push_back(start_child([&, c] { return decode_stripe(work, c, count); }, limits));
  return wait_for(children, limits, [&] {
    const auto finished = [](const Decoded& d) { return d.state.load() >= Progressed::kDone; };
    const auto done = double(std::count_if(work.decoded, work.decoded + work.slices.size(), finished));
    if (progress) progress(done / double(work.slices.size()));
    return done;
  });
}

/// Reason why a slice has no samples.
Error why_not(const DicomSlice& slice, Progressed state, const ChildEnd& end, const ChildLimits& limits) {
  const std::string file = slice.file.string();
  if (state == Progressed::kRefused || end)
    return {fmt::format(
        "{}: damaged, or compressed in an unknown way: the pixels cannot be decoded (transfer syntax {})",
        file, slice.transfer_syntax)};
  return {fmt::format("{}: the pixels cannot be decoded (transfer syntax {}): {}{}", file,
                      slice.transfer_syntax,
                      end.kind == ChildEnd::Kind::kCrashed ? "the file is damaged, or the decoder is: " : "",
                      describe(end, limits))};
}

}  // namespace

Result<ChangedSamples> decode_dicom_samples(const Exec& exec, std::span<const DicomSlice* const> slices,
                                            std::span<const std::span<std::int16_t>> hu,
                                            const Progress& progress) {
  if (slices.empty()) return ChangedSamples{};
  const std::size_t area = hu[0].size(), count = slices.size();
  static_assert(std::atomic<Progressed>::is_always_lock_free);
  const std::size_t table = count * sizeof(Decoded);  // first, because it needs alignment
  const SharedMemory shared(table + count * area * sizeof(std::int16_t));
  if (!shared)
    return Error{fmt::format("{}: not enough memory to decode {} slices", slices[0]->file.string(), count)};
  auto* samples = reinterpret_cast<std::int16_t*>(shared.data() + table);
  auto* decoded = reinterpret_cast<Decoded*>(shared.data());
  const Work work{slices, area, samples, decoded};  // new shared memory is zero: all slices are waiting
  const std::size_t processes = std::min(count, std::size_t(exec.threads()));
  const ChildLimits limits{.seconds = kSecondsPerSlice, .memory = kCodecBytes + kBytesPerSample * area};
  const std::vector<ChildEnd> ends = decode_all(work, processes, limits, progress);
  ChangedSamples changed;
  for (std::size_t k = 0; k < count; k++) {
    const Progressed state = decoded[k].state;
    if (state != Progressed::kDone) return why_not(*slices[k], state, ends[k % processes], limits);
    std::copy_n(samples + k * area, area, hu[k].begin());
    changed += decoded[k].changed;
  }
  return changed;
}

}  // namespace turgor::io
