// Memory that decode_dicom_samples shares with turgor-read, which decodes compressed pixels: a DecodeJob, its
// DecodeSlices, fragments, texts, then the decoded bytes of every slice. A change of it changes
// kReaderProtocol.
#pragma once

#include <atomic>
#include <cstdint>

namespace turgor::io {

enum class Decoding : std::uint8_t { kWaiting, kWorking, kDone, kRefused };
static_assert(std::atomic<Decoding>::is_always_lock_free, "processes share it");

/// Counts and offsets from the start of the memory [bytes].
struct DecodeJob {
  std::uint64_t slice_count = 0, slice_bytes = 0;
  std::uint64_t fragments_at = 0, texts_at = 0, pixels_at = 0, size = 0;
};

struct DecodeFragment {
  std::uint64_t offset = 0, length = 0;  // in the file [bytes]
};

/// One slice. Texts end with a zero.
struct DecodeSlice {
  std::atomic<Decoding> state = Decoding::kWaiting;  // written by turgor-read
  std::int32_t columns = 0, rows = 0;
  std::int32_t bits_allocated = 0, bits_stored = 0, is_signed = 0;
  std::uint64_t file_at = 0, syntax_at = 0;  // texts: path, transfer syntax
  std::uint64_t fragments_at = 0, fragment_count = 0;
};

}  // namespace turgor::io
