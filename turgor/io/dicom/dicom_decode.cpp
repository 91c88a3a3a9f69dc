// Decoding of compressed DICOM samples by turgor-read. GDCM's codecs crash on some damaged images, and a
// damaged file must give an error message instead of ending the program. The processes share memory with this
// one: it holds descriptions of the slices and their decoded bytes (decode_job.hpp).
#include <algorithm>
#include <cstring>
#include <new>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include "turgor/io/dicom/decode_job.hpp"
#include "turgor/io/dicom/dicom.hpp"
#include "turgor/io/files/reader_program.hpp"

namespace turgor::io {

namespace {

namespace fs = std::filesystem;

// A slice takes far less than a second; a codec that needs longer is in an endless loop.
constexpr double kSecondsPerSlice = 60;
// Damaged images make codecs request unlimited memory. The limit covers the decoding of one slice.
constexpr std::size_t kCodecBytes = std::size_t{256} << 20, kBytesPerSample = 32;

/// Memory that other programs share by a descriptor. None of them can change its size.
class SharedMemory {
 public:
  explicit SharedMemory(std::size_t size) : size_(size) {
    rlimit most{};  // of a file; beyond it the process would get a signal
    if (getrlimit(RLIMIT_FSIZE, &most) != 0 || size > most.rlim_cur) return;
    file_ = memfd_create("turgor", MFD_CLOEXEC | MFD_ALLOW_SEALING);
    if (file_ < 0 || ftruncate(file_, off_t(size)) != 0) return;
    fcntl(file_, F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL);
    data_ = mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED, file_, 0);
  }
  ~SharedMemory() {
    if (*this) munmap(data_, size_);
    if (file_ >= 0) close(file_);
  }
  SharedMemory(const SharedMemory&) = delete;
  SharedMemory& operator=(const SharedMemory&) = delete;
  explicit operator bool() const { return data_ != MAP_FAILED; }
  std::byte* data() const { return static_cast<std::byte*>(data_); }
  int file() const { return file_; }

 private:
  std::size_t size_;
  int file_ = -1;
  void* data_ = MAP_FAILED;
};

/// Sizes and offsets of the shared memory.
DecodeJob layout_of(std::span<const DicomSlice* const> slices, std::size_t slice_bytes) {
  std::size_t texts = 0, fragments = 0;
  for (const DicomSlice* s : slices) {
    texts += s->file.native().size() + s->transfer_syntax.size() + 2;
    fragments += s->fragments.size();
  }
  DecodeJob job;
  job.slice_count = slices.size();
  job.slice_bytes = slice_bytes;
  job.fragments_at = sizeof(DecodeJob) + slices.size() * sizeof(DecodeSlice);
  job.texts_at = job.fragments_at + fragments * sizeof(DecodeFragment);
  job.pixels_at = (job.texts_at + texts + 63) / 64 * 64;
  job.size = job.pixels_at + slices.size() * slice_bytes;
  return job;
}

/// Describes the slices in shared memory.
void write_job(std::span<const DicomSlice* const> slices, const DecodeJob& job, std::byte* data) {
  std::size_t fragment_at = job.fragments_at, text_at = job.texts_at;
  const auto put = [&](const std::string& text) {
    std::memcpy(data + text_at, text.c_str(), text.size() + 1);
    return std::exchange(text_at, text_at + text.size() + 1);
  };
  new (data) DecodeJob(job);
  for (std::size_t k = 0; k < slices.size(); k++) {
    const DicomSlice& s = *slices[k];
    auto* slice = new (data + sizeof(DecodeJob) + k * sizeof(DecodeSlice)) DecodeSlice;
    slice->columns = s.columns, slice->rows = s.rows;
    slice->bits_allocated = s.bits_allocated, slice->bits_stored = s.bits_stored;
    slice->is_signed = s.is_signed;
    slice->file_at = put(s.file.native()), slice->syntax_at = put(s.transfer_syntax);
    slice->fragments_at = fragment_at, slice->fragment_count = s.fragments.size();
    for (const DicomFragment& piece : s.fragments) {
      new (data + fragment_at) DecodeFragment{piece.offset, piece.length};
      fragment_at += sizeof(DecodeFragment);
    }
  }
}

/// Runs that many processes; each decodes every count-th slice of the shared memory.
Result<std::vector<ChildEnd>> decode_all(std::span<DecodeSlice> decoded, int shared, std::size_t count,
                                         const ChildLimits& limits, const Progress& progress) {
  const Result<fs::path> program = find_reader();
  if (!program) return program.error();
  std::vector<Child> children;
  for (std::size_t c = 0; c < count; c++)
    children.push_back(
        start_reader(*program, {"dicom", fmt::format("{}", c), fmt::format("{}", count)}, limits, shared));
  std::vector<ChildEnd> ends = wait_for(children, limits, [&] {
    const auto finished = [](const DecodeSlice& d) { return d.state.load() >= Decoding::kDone; };
    const auto done = double(std::ranges::count_if(decoded, finished));
    if (progress) progress(done / double(decoded.size()));
    return done;
  });
  for (ChildEnd& end : ends) {
    const Result<ChildEnd> judged = end_of_reader(end);
    if (!judged) return judged.error();
    end = *judged;
  }
  return ends;
}

/// Reason why a slice has no samples.
Error why_not(const DicomSlice& slice, Decoding state, const ChildEnd& end, const ChildLimits& limits) {
  const std::string file = slice.file.string();
  if (state == Decoding::kRefused || end)
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
  // shared memory with the descriptions
  const std::size_t area = hu[0].size(), count = slices.size();
  const auto bytes_of = [&](const DicomSlice& s) { return area * std::size_t(s.bits_allocated) / 8; };
  std::size_t slice_bytes = 0;
  for (const DicomSlice* slice : slices) slice_bytes = std::max(slice_bytes, bytes_of(*slice));
  const DecodeJob job = layout_of(slices, slice_bytes);
  const SharedMemory memory(job.size);
  if (!memory)
    return Error{fmt::format("{}: not enough memory to decode {} slices", slices[0]->file.string(), count)};
  write_job(slices, job, memory.data());
  const std::span decoded(reinterpret_cast<DecodeSlice*>(memory.data() + sizeof(DecodeJob)), count);

  // decoding in other processes
  const std::size_t processes = std::min(count, std::size_t(exec.threads()));
  const ChildLimits limits{.seconds = kSecondsPerSlice, .memory = kCodecBytes + kBytesPerSample * area};
  const Result<std::vector<ChildEnd>> ends = decode_all(decoded, memory.file(), processes, limits, progress);
  if (!ends)
    return Error{fmt::format("{}: cannot be decoded: {}", slices[0]->file.string(), ends.error().message)};
  for (std::size_t k = 0; k < count; k++)
    if (const Decoding state = decoded[k].state; state != Decoding::kDone)
      return why_not(*slices[k], state, (*ends)[k % processes], limits);

  // Hounsfield units
  std::vector<ChangedSamples> each(count);
  parallel_for(exec, count, [&](std::size_t k) {
    const std::byte* pixels = memory.data() + job.pixels_at + k * slice_bytes;
    each[k] = convert_to_hu(*slices[k], reinterpret_cast<const char*>(pixels), hu[k]);
  });
  ChangedSamples changed;
  for (const ChangedSamples& slice : each) changed += slice;
  return changed;
}

}  // namespace turgor::io
