#include "turgor/io/files/deflate.hpp"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <new>
#include <string>
#include <vector>

#include <zlib.h>

#include "turgor/core/assert.hpp"

namespace turgor::io {

namespace {

constexpr int kLevel = 1;  // higher levels compress noise no better, only slower

struct Stream {
  z_stream z{};
  explicit Stream(int format) {
    constexpr int kMemoryLevel = 8;
    if (deflateInit2(&z, kLevel, Z_DEFLATED, format, kMemoryLevel, Z_DEFAULT_STRATEGY) != Z_OK)
      throw std::bad_alloc();
  }
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;
  ~Stream() { deflateEnd(&z); }
};

/// Part of a stream, with the bytes before it that it may refer to.
struct Piece {
  std::string_view bytes, before;
};
struct PackedPiece {
  std::string bytes;
  uLong crc = 0;
};

/// Splits chunks into pieces. An empty piece ends the stream.
std::vector<Piece> pieces_of(std::initializer_list<std::string_view> chunks) {
  constexpr std::size_t kPiece = std::size_t{1} << 20, kWindow = std::size_t{1} << 15;
  std::vector<Piece> pieces;
  for (const std::string_view chunk : chunks)
    for (std::size_t at = 0; at < chunk.size(); at += kPiece) {
      const std::size_t window = std::min(at, kWindow);
      pieces.push_back({chunk.substr(at, kPiece), chunk.substr(at - window, window)});
    }
  pieces.push_back({});
  return pieces;
}

/// Compresses a piece as blocks of a bare stream that end at a byte.
PackedPiece pack(const Piece& piece, bool is_last) {
  constexpr int kBare = -15;  // zlib's windowBits
  Stream stream(kBare);
  z_stream& z = stream.z;
  const auto bytes = [](std::string_view text) {
    return reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
  };
  if (!piece.before.empty()) deflateSetDictionary(&z, bytes(piece.before), uInt(piece.before.size()));
  PackedPiece packed{std::string(std::size_t{1} << 16, '\0'),
                     crc32(0, bytes(piece.bytes), uInt(piece.bytes.size()))};
  z.next_in = bytes(piece.bytes), z.avail_in = uInt(piece.bytes.size());
  for (std::size_t done = 0;; packed.bytes.resize(2 * packed.bytes.size())) {
    z.next_out = bytes(packed.bytes) + done, z.avail_out = uInt(packed.bytes.size() - done);
    const int status = ::deflate(&z, is_last ? Z_FINISH : Z_SYNC_FLUSH);
    TURGOR_ASSERT(status != Z_STREAM_ERROR, "zlib accepts the state of a deflate stream");
    done = packed.bytes.size() - z.avail_out;
    if (z.avail_out == 0) continue;
    packed.bytes.resize(done);
    return packed;
  }
}

/// Lowest byte first.
std::string four_bytes(std::uint64_t number) {
  std::string bytes;
  for (int b = 0; b < 4; b++) bytes += char(number >> (8 * b) & 255);
  return bytes;
}

/// Compressed bytes of a range, block by block.
class PackedBytes {
 public:
  explicit PackedBytes(const FileRange& range)
      : file_(std::fopen(range.file.c_str(), "rb"), std::fclose), left_(range.end - range.begin) {
    if (file_ && fseeko(file_.get(), off_t(range.begin), SEEK_SET) != 0) file_.reset();
  }
  /// Gives the stream the next block if its input is empty; false at the end.
  bool feed(z_stream& z) {
    if (z.avail_in > 0) return true;
    if (!file_) return false;
    const auto size = std::min<std::int64_t>(left_, std::int64_t(block_.size()));
    z.next_in = block_.data();
    z.avail_in = uInt(std::fread(block_.data(), 1, std::size_t(size), file_.get()));
    left_ -= z.avail_in;
    return z.avail_in > 0;
  }

 private:
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file_;
  std::int64_t left_;
  std::vector<Bytef> block_ = std::vector<Bytef>(std::size_t{1} << 18);
};

struct InflateStream {
  z_stream z{};
  static constexpr int kZlibOrGzip = 15 + 32, kBare = -15;  // zlib's windowBits
  explicit InflateStream(int format) {
    if (inflateInit2(&z, format) != Z_OK) throw std::bad_alloc();
  }
  InflateStream(const InflateStream&) = delete;
  InflateStream& operator=(const InflateStream&) = delete;
  ~InflateStream() { inflateEnd(&z); }
};

/// Destination of inflated bytes: the first ones are discarded, then `out` is filled, and the rest is
/// discarded.
struct Unpacked {
  std::int64_t skip;
  std::span<std::byte> out;
  std::size_t done = 0;
  bool is_too_long = false;
  std::vector<std::byte> nothing = std::vector<std::byte>(std::size_t{1} << 14);

  std::span<std::byte> output() {
    constexpr std::size_t kMost = std::size_t{1} << 28;
    const std::span<std::byte> all(nothing);
    if (skip > 0) return all.first(std::size_t(std::min(skip, std::int64_t(all.size()))));
    return done < out.size() ? out.subspan(done, std::min(out.size() - done, kMost)) : all;
  }
  /// One call of zlib into the next free bytes.
  int next(z_stream& z) {
    const std::span<std::byte> to = output();
    z.next_out = reinterpret_cast<Bytef*>(to.data());
    z.avail_out = uInt(to.size());
    const int state = ::inflate(&z, Z_NO_FLUSH);
    const std::size_t count = to.size() - z.avail_out;
    if (skip > 0)
      skip -= std::int64_t(count);
    else if (done < out.size())
      done += count;
    else
      is_too_long = count > 0;
    return state;
  }
};

/// True if another gzip stream follows.
bool next_member(PackedBytes& packed, z_stream& z) {
  constexpr Bytef kGzipMagic = 0x1f;
  return packed.feed(z) && *z.next_in == kGzipMagic && inflateReset(&z) == Z_OK;
}

}  // namespace

Inflated inflate(const FileRange& range, std::int64_t skip, std::span<std::byte> out) {
  using End = Inflated::End;
  PackedBytes packed(range);
  InflateStream stream(InflateStream::kZlibOrGzip);
  Unpacked unpacked{.skip = skip, .out = out};
  for (;;) {
    const bool has_input = packed.feed(stream.z);
    const int state = unpacked.next(stream.z);
    if (unpacked.is_too_long) return {End::kTooLong, unpacked.done};
    if (state == Z_STREAM_END) {
      if (next_member(packed, stream.z)) continue;
      return {unpacked.done == out.size() ? End::kExact : End::kTooShort, unpacked.done};
    }
    if (state == Z_BUF_ERROR && !has_input) return {End::kTooShort, unpacked.done};
    if (state != Z_OK) return {End::kDamaged, unpacked.done};
  }
}

struct InflatedStream::Data {
  PackedBytes packed;
  InflateStream stream{InflateStream::kBare};
  std::uint64_t position = 0;
  bool is_whole = false, is_damaged = false;

  explicit Data(const FileRange& range) : packed(range) {}
  /// Next bytes; fewer at the end of the stream or at damage.
  std::size_t next(std::span<char> out) {
    std::size_t done = 0;
    while (done < out.size() && !is_whole && !is_damaged) {
      constexpr std::size_t kMost = std::size_t{1} << 28;
      const std::size_t free = std::min(out.size() - done, kMost);
      const bool has_input = packed.feed(stream.z);
      stream.z.next_out = reinterpret_cast<Bytef*>(out.data() + done);
      stream.z.avail_out = uInt(free);
      const int state = ::inflate(&stream.z, Z_NO_FLUSH);
      const std::size_t count = free - stream.z.avail_out;
      is_whole = state == Z_STREAM_END;
      is_damaged = (state != Z_OK && !is_whole) || (!has_input && count == 0 && !is_whole);
      done += count;
    }
    position += done;
    return done;
  }
};

InflatedStream::InflatedStream(const FileRange& range) : data_(std::make_unique<Data>(range)) {}
InflatedStream::~InflatedStream() = default;
std::uint64_t InflatedStream::position() const { return data_->position; }
bool InflatedStream::is_whole() const { return data_->is_whole; }

std::size_t InflatedStream::read(std::uint64_t at, std::span<char> out) {
  if (at < data_->position) return 0;
  std::vector<char> skipped(std::size_t(std::min<std::uint64_t>(at - data_->position, 1 << 16)));
  while (data_->position < at) {
    const std::uint64_t rest = at - data_->position;
    if (data_->next(std::span(skipped).first(std::size_t(std::min<std::uint64_t>(rest, skipped.size())))) ==
        0)
      return 0;
  }
  return data_->next(out);
}

void deflate(std::initializer_list<std::string_view> chunks, Deflate format,
             const std::function<void(std::string_view)>& out) {
  constexpr std::size_t kBlock = std::size_t{1} << 28;
  Stream stream{int(format)};
  std::vector<char> packed(std::size_t{1} << 18);
  const auto feed = [&](std::string_view bytes, int flush) {
    stream.z.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
    stream.z.avail_in = uInt(bytes.size());
    do {
      stream.z.next_out = reinterpret_cast<Bytef*>(packed.data());
      stream.z.avail_out = uInt(packed.size());
      const int status = ::deflate(&stream.z, flush);
      TURGOR_ASSERT(status != Z_STREAM_ERROR, "zlib accepts the state of a deflate stream");
      out({packed.data(), packed.size() - stream.z.avail_out});
    } while (stream.z.avail_out == 0);
  };
  for (std::string_view chunk : chunks)
    for (; !chunk.empty(); chunk.remove_prefix(std::min(kBlock, chunk.size())))
      feed(chunk.substr(0, kBlock), Z_NO_FLUSH);
  feed({}, Z_FINISH);
}

void deflate_gzip(const Exec& exec, std::initializer_list<std::string_view> chunks,
                  const std::function<void(std::string_view)>& out) {
  constexpr std::string_view kHeader("\x1f\x8b\x08\0\0\0\0\0\x04\x03", 10);  // no name or time; fastest, Unix
  constexpr std::size_t kBatch = 64;                                         // pieces in memory
  out(kHeader);
  // pieces
  const std::vector<Piece> pieces = pieces_of(chunks);
  uLong crc = 0;
  std::uint64_t size = 0;
  for (std::size_t begin = 0; begin < pieces.size(); begin += kBatch) {
    std::vector<PackedPiece> packed(std::min(kBatch, pieces.size() - begin));
    parallel_for(exec, packed.size(),
                 [&](std::size_t p) { packed[p] = pack(pieces[begin + p], begin + p + 1 == pieces.size()); });
    for (std::size_t p = 0; p < packed.size(); p++) {
      const std::size_t length = pieces[begin + p].bytes.size();
      crc = crc32_combine(crc, packed[p].crc, z_off_t(length)), size += length;
      out(packed[p].bytes);
    }
  }
  out(four_bytes(crc) + four_bytes(size));
}

}  // namespace turgor::io
