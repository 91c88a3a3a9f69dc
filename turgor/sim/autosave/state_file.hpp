// File with the bytes of a state, for autosaves (autosave.hpp): a title, blocks of bytes and a checksum. It
// is read by the same program that wrote it and is no format of exchange; recording.h5 is one.
#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "turgor/core/result.hpp"

namespace turgor {

/// Writer of a state file. The first failure is kept, and nothing is written after it.
class StateWriter {
 public:
  static constexpr bool kReads = false;

  static Result<StateWriter> create(const std::filesystem::path& path);
  void bytes(const void* data, std::size_t size);
  void number(std::uint64_t value) { bytes(&value, sizeof value); }
  /// Writes the checksum; afterwards the file survives a crash of the system.
  Status close();

 private:
  struct Closer {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  StateWriter(std::filesystem::path path, std::unique_ptr<std::FILE, Closer> file);
  void write_block();
  Error error() const;

  std::filesystem::path path_;
  std::unique_ptr<std::FILE, Closer> file_;
  std::string block_;
  std::uint64_t hash_;
  int failure_ = 0;  // errno of the first failure
};

/// Reader of a state file whose checksum was verified. After the end, and after a failure, all bytes are
/// zero.
class StateReader {
 public:
  static constexpr bool kReads = true;

  /// Error: missing, not such a file, damaged or cut short.
  static Result<StateReader> open(const std::filesystem::path& path);
  void bytes(void* data, std::size_t size);
  std::uint64_t number() {
    std::uint64_t value = 0;
    bytes(&value, sizeof value);
    return value;
  }
  /// Number of elements that follow, each of at least `size` bytes. It fails if the file is too short for
  /// them.
  std::size_t count(std::size_t size);
  void fail() { failed_ = true; }
  /// False after a read that the content did not allow.
  bool is_sound() const { return !failed_; }
  bool is_at_end() const { return !failed_ && at_ == content_.size(); }

 private:
  explicit StateReader(std::string content, std::size_t begin) : content_(std::move(content)), at_(begin) {}

  std::string content_;
  std::size_t at_ = 0;
  bool failed_ = false;
};

}  // namespace turgor
