// The samples of NIfTI files, plain or compressed, in either byte order.
#include <algorithm>
#include <memory>

#include <fmt/format.h>
#include <zlib.h>

#include "turgor/io/volume_file.hpp"

namespace turgor::io {

namespace {

struct CloseGzip {
  void operator()(gzFile_s* file) const { gzclose(file); }
};

/// Fills `bytes` from the file at `offset`; how many there were.
std::size_t read_bytes(const std::filesystem::path& path, std::int64_t offset,
                       std::vector<std::byte>& bytes) {
  const std::unique_ptr<gzFile_s, CloseGzip> file(gzopen(path.c_str(), "rb"));
  if (!file) return 0;
  gzbuffer(file.get(), 1 << 18);
  if (gzseek(file.get(), static_cast<z_off_t>(offset), SEEK_SET) != offset) return 0;
  std::size_t done = 0;
  while (done < bytes.size()) {
    const auto block = static_cast<unsigned>(std::min(bytes.size() - done, std::size_t{1} << 28));
    const int got = gzread(file.get(), bytes.data() + done, block);
    if (got <= 0) break;
    done += static_cast<std::size_t>(got);
  }
  return done;
}

/// Components that a file holds volume after volume become neighbours in memory.
std::vector<std::byte> interleaved(const std::vector<std::byte>& planes, std::size_t components,
                                   std::size_t size) {
  std::vector<std::byte> mixed(planes.size());
  const std::size_t samples = planes.size() / (components * size);
  for (std::size_t c = 0; c < components; c++)
    for (std::size_t i = 0; i < samples; i++)
      std::copy_n(planes.begin() + std::ptrdiff_t((c * samples + i) * size), size,
                  mixed.begin() + std::ptrdiff_t((i * components + c) * size));
  return mixed;
}

}  // namespace

Result<RawVolume> read_nifti_samples(const std::filesystem::path& path, const VolumeHeader& header) {
  RawVolume raw{header.format, header.grid,      header.type, header.components,
                header.slope,  header.intercept, {},          {}};
  const std::size_t size = byte_size(raw.type), components = std::size_t(raw.components);
  raw.bytes.resize(sample_count(raw.grid) * components * size);
  const std::size_t found = read_bytes(path, header.data_offset, raw.bytes);
  if (found < raw.bytes.size())
    return Error{
        fmt::format("{}: truncated or corrupt: the header promises {} bytes of samples, the file holds {}",
                    path.string(), raw.bytes.size(), found)};
  if (header.is_swapped)
    for (auto at = raw.bytes.begin(); at != raw.bytes.end(); at += std::ptrdiff_t(size))
      std::reverse(at, at + std::ptrdiff_t(size));
  if (components > 1) raw.bytes = interleaved(raw.bytes, components, size);
  return raw;
}

}  // namespace turgor::io
