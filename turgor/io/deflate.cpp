#include "turgor/io/deflate.hpp"

#include <algorithm>
#include <new>
#include <vector>

#include <zlib.h>

#include "turgor/core/assert.hpp"

namespace turgor::io {

namespace {

constexpr int kLevel = 1;  // noise packs no better at higher levels, only slower

struct Stream {
  z_stream z{};
  explicit Stream(Deflate format) {
    constexpr int kMemoryLevel = 8;
    if (deflateInit2(&z, kLevel, Z_DEFLATED, int(format), kMemoryLevel, Z_DEFAULT_STRATEGY) != Z_OK)
      throw std::bad_alloc();
  }
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;
  ~Stream() { deflateEnd(&z); }
};

}  // namespace

void deflate(std::initializer_list<std::string_view> parts, Deflate format,
             const std::function<void(std::string_view)>& out) {
  constexpr std::size_t kBlock = std::size_t{1} << 28;
  Stream stream(format);
  std::vector<char> packed(std::size_t{1} << 18);
  const auto feed = [&](std::string_view bytes, int flush) {
    stream.z.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
    stream.z.avail_in = uInt(bytes.size());
    do {
      stream.z.next_out = reinterpret_cast<Bytef*>(packed.data());
      stream.z.avail_out = uInt(packed.size());
      const int status = ::deflate(&stream.z, flush);
      TURGOR_ASSERT(status != Z_STREAM_ERROR, "a stream of deflate is used as zlib wants it");
      out({packed.data(), packed.size() - stream.z.avail_out});
    } while (stream.z.avail_out == 0);
  };
  for (std::string_view part : parts)
    for (; !part.empty(); part.remove_prefix(std::min(kBlock, part.size())))
      feed(part.substr(0, kBlock), Z_NO_FLUSH);
  feed({}, Z_FINISH);
}

}  // namespace turgor::io
