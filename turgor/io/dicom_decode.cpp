// Compressed DICOM samples, decoded by GDCM in processes of their own: its codecs crash on some damaged
// images, and a damaged file must end in a sentence, not in the end of the program.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <fstream>
#include <thread>

#include <fcntl.h>
#include <fmt/format.h>
#include <gdcmImage.h>
#include <gdcmSequenceOfFragments.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "turgor/io/dicom.hpp"

namespace turgor::io {

namespace {

enum class Progressed : std::uint8_t { kWaiting, kWorking, kDone, kRefused };

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

/// What a child leaves behind of one slice, besides its samples.
struct Decoded {
  std::atomic<Progressed> state;
  ChangedSamples changed;
};

struct Work {
  std::span<const DicomSlice* const> slices;
  std::size_t area;       // samples of a slice
  std::int16_t* samples;  // shared, slice after slice
  Decoded* decoded;       // shared, one a slice
};

/// The compressed pixels as GDCM wants them.
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

/// False if GDCM refuses. It may also crash.
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
  const std::size_t wanted = hu.size() * std::size_t(slice.bits_allocated) / 8;
  if (image.GetBufferLength() != wanted) return false;
  std::vector<char> stored(wanted);
  if (!image.GetBuffer(stored.data())) return false;
  changed = convert_to_hu(slice, stored.data(), hu);
  return true;
}

/// A codec that believes a damaged image asks for memory without end: no more than decoding one slice takes.
void limit_memory(const Work& work) {
  constexpr rlim_t kCodec = rlim_t{256} << 20, kBytesPerSample = 32;
  rlim_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;  // what was mapped before counts, too
  rlimit limit{};
  if (pages == 0 || getrlimit(RLIMIT_AS, &limit) != 0) return;
  const rlim_t wanted = pages * rlim_t(sysconf(_SC_PAGESIZE)) + kCodec + kBytesPerSample * work.area;
  limit.rlim_cur = std::min(wanted, limit.rlim_max);
  setrlimit(RLIMIT_AS, &limit);
}

/// What a child does: every step-th slice. Never returns.
[[noreturn]] void decode_stripe(const Work& work, std::size_t first, std::size_t step) {
  const rlimit no_core{0, 0};
  setrlimit(RLIMIT_CORE, &no_core);
  limit_memory(work);
  const int nowhere = open("/dev/null", O_WRONLY);  // codecs talk about what they find
  dup2(nowhere, STDERR_FILENO);
  for (std::size_t k = first; k < work.slices.size(); k += step) {
    Decoded& decoded = work.decoded[k];
    decoded.state = Progressed::kWorking;
    bool done = false;
    try {
      done = decode(*work.slices[k], std::span(work.samples + k * work.area, work.area), decoded.changed);
    } catch (...) {
    }
    decoded.state = done ? Progressed::kDone : Progressed::kRefused;
  }
  _exit(0);
}

std::vector<pid_t> start_children(const Work& work, std::size_t count) {
  std::vector<pid_t> children;
  for (std::size_t child = 0; child < count; child++) {
    const pid_t id = fork();
    if (id == 0) decode_stripe(work, child, count);
    if (id > 0) children.push_back(id);
  }
  return children;
}

void wait_for(const std::vector<pid_t>& children, const Work& work, const Progress& progress) {
  for (const pid_t child : children)
    while (waitpid(child, nullptr, progress ? WNOHANG : 0) == 0) {
      const auto finished = [](const Decoded& d) { return d.state.load() >= Progressed::kDone; };
      progress(double(std::count_if(work.decoded, work.decoded + work.slices.size(), finished)) /
               double(work.slices.size()));
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
}

}  // namespace

Result<ChangedSamples> decode_dicom_samples(const Exec& exec, std::span<const DicomSlice* const> slices,
                                            std::span<const std::span<std::int16_t>> hu,
                                            const Progress& progress) {
  if (slices.empty()) return ChangedSamples{};
  const std::size_t area = hu[0].size(), count = slices.size();
  static_assert(std::atomic<Progressed>::is_always_lock_free);
  const std::size_t table = count * sizeof(Decoded);  // first, where memory is aligned
  const SharedMemory shared(table + count * area * sizeof(std::int16_t));
  if (!shared)
    return Error{fmt::format("{}: not enough memory to decode {} slices", slices[0]->file.string(), count)};
  auto* samples = reinterpret_cast<std::int16_t*>(shared.data() + table);
  auto* decoded = reinterpret_cast<Decoded*>(shared.data());
  const Work work{slices, area, samples, decoded};  // fresh shared memory is zero: all waiting
  wait_for(start_children(work, std::min(count, std::size_t(exec.threads()))), work, progress);
  ChangedSamples changed;
  for (std::size_t k = 0; k < count; k++) {
    if (decoded[k].state != Progressed::kDone)
      return Error{fmt::format(
          "{}: damaged, or compressed in an unknown way: the pixels cannot be decoded (transfer syntax {})",
          slices[k]->file.string(), slices[k]->transfer_syntax)};
    std::copy_n(samples + k * area, area, hu[k].begin());
    changed += decoded[k].changed;
  }
  return changed;
}

}  // namespace turgor::io
