#include "turgor/sim/autosave/state_file.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <string_view>

#include <fmt/format.h>
#include <unistd.h>

#include "turgor/core/hash.hpp"
#include "turgor/io/files/file.hpp"

namespace turgor {

namespace {

constexpr std::string_view kTitle = "turgor autosave 1\n";
constexpr std::size_t kBlock = 1 << 20;  // bytes that are hashed at once

/// Checksum of bytes as StateWriter calculates it, block by block.
std::uint64_t checksum(std::string_view content) {
  std::uint64_t hash = kHashSeed;
  for (std::size_t at = 0; at < content.size(); at += kBlock) {
    const std::string_view block = content.substr(at, kBlock);
    hash = hash_bytes(block.data(), block.size(), hash);
  }
  return hash;
}

}  // namespace

StateWriter::StateWriter(std::filesystem::path path, std::unique_ptr<std::FILE, Closer> file)
    : path_(std::move(path)), file_(std::move(file)), block_(kTitle), hash_(kHashSeed) {}

Error StateWriter::error() const {
  return {fmt::format("{}: cannot write the autosave: {}", path_.string(), std::strerror(failure_))};
}

Result<StateWriter> StateWriter::create(const std::filesystem::path& path) {
  std::unique_ptr<std::FILE, Closer> file(std::fopen(path.c_str(), "wbe"));
  if (!file)
    return Error{fmt::format("{}: cannot write the autosave: {}", path.string(), std::strerror(errno))};
  return StateWriter(path, std::move(file));
}

void StateWriter::write_block() {
  hash_ = hash_bytes(block_.data(), block_.size(), hash_);
  if (failure_ == 0 && std::fwrite(block_.data(), 1, block_.size(), file_.get()) != block_.size())
    failure_ = errno;
  block_.clear();
}

void StateWriter::bytes(const void* data, std::size_t size) {
  const char* from = static_cast<const char*>(data);
  while (size > 0 && failure_ == 0) {
    const std::size_t now = std::min(size, kBlock - block_.size());
    block_.append(from, now);
    from += now, size -= now;
    if (block_.size() == kBlock) write_block();
  }
}

Status StateWriter::close() {
  if (!block_.empty()) write_block();
  const std::uint64_t hash = hash_;
  if (failure_ == 0 && std::fwrite(&hash, sizeof hash, 1, file_.get()) != 1) failure_ = errno;
  if (failure_ == 0 && (std::fflush(file_.get()) != 0 || fsync(fileno(file_.get())) != 0)) failure_ = errno;
  if (std::fclose(file_.release()) != 0 && failure_ == 0) failure_ = errno;
  return failure_ == 0 ? Status(Done{}) : error();
}

Result<StateReader> StateReader::open(const std::filesystem::path& path) {
  Result<std::string> content = read_file(path);
  if (!content) return content.error();
  if (!content->starts_with(kTitle))
    return Error{fmt::format("{}: expected an autosave of turgor run, found another file", path.string())};
  std::uint64_t stored = 0;
  const std::size_t size = content->size() - std::min(content->size(), sizeof stored);
  std::memcpy(&stored, content->data() + size, content->size() - size);
  content->resize(size);
  if (size < kTitle.size() || checksum(*content) != stored)
    return Error{
        fmt::format("{}: the autosave is damaged; run without --resume to start again", path.string())};
  return StateReader(std::move(*content), kTitle.size());
}

void StateReader::bytes(void* data, std::size_t size) {
  failed_ = failed_ || size > content_.size() - at_;
  if (size == 0) return;
  if (failed_) {
    std::memset(data, 0, size);
    return;
  }
  std::memcpy(data, content_.data() + at_, size);
  at_ += size;
}

std::size_t StateReader::count(std::size_t size) {
  const std::uint64_t elements = number();
  failed_ = failed_ || elements > (content_.size() - at_) / std::max<std::size_t>(size, 1);
  return failed_ ? 0 : std::size_t(elements);
}

}  // namespace turgor
