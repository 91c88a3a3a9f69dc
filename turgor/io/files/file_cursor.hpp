// Sequential reader for words and numbers of a file, as text or as binary of either byte order. The first
// error is stored with its location; later reads return empty words and zeros. Readers check ok() in their
// loops, and count() bounds allocations by the size of the file. Internal to io/.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "turgor/core/result.hpp"

namespace turgor::io {

enum class Encoding { kText, kLittleEndian, kBigEndian };

/// Minimum size of an item in a file: words of text, or bytes.
struct ItemSize {
  std::size_t words, bytes;
};

class FileCursor {
 public:
  FileCursor(const std::filesystem::path& path, std::string_view bytes) : path_(path), bytes_(bytes) {}

  Encoding encoding = Encoding::kText;
  bool has_comments = false;  // text: '#' starts a comment up to the end of the line

  bool ok() const { return message_.empty(); }
  Error error() const { return {message_}; }
  /// Records an error at the last word or number.
  void fail(std::string_view expected, std::string_view found);
  /// The same; the word itself is reported as found.
  void fail(std::string_view expected);

  /// Next word of text; empty at the end.
  std::string_view word();
  std::string_view peek_word();
  void expect(std::string_view word);
  /// Rest of this line, without its line end.
  std::string_view line();
  bool at_end();

  /// Next number: a word of text, or the given number of bytes. `what` names it in errors.
  std::int64_t whole(int bytes, std::string_view what);
  std::uint64_t unsigned_whole(int bytes, std::string_view what);
  double real(int bytes, std::string_view what);
  /// Number of items that follow; fails if the rest of the file cannot hold them.
  std::size_t count(int bytes, ItemSize item, std::string_view what);
  /// True if the rest of the file can hold these items; fails otherwise.
  bool can_hold(std::uint64_t items, ItemSize item, std::string_view what);
  std::string_view skip(std::size_t bytes);

  const std::filesystem::path& path() const { return path_; }
  std::size_t offset() const { return at_; }
  void seek(std::size_t offset) { at_ = last_ = offset; }
  std::string_view bytes() const { return bytes_; }

 private:
  void skip_space();
  std::uint64_t number_bits(std::string_view bytes) const;

  std::filesystem::path path_;
  std::string_view bytes_;
  std::size_t at_ = 0, last_ = 0;  // current offset; start of the last word or number
  std::string message_;
};

/// Number type in a file.
struct NumberType {
  enum Kind { kReal, kSigned, kUnsigned } kind = kReal;
  int bytes = 8;  // 0: bits
};
double read_real(FileCursor& cursor, NumberType type);
/// Fails for real types.
std::int64_t read_whole(FileCursor& cursor, NumberType type);

/// Excerpt of a file for a message.
std::string quoted(std::string_view text);
std::string lower_case(std::string_view text);
/// "1 node", "2 nodes".
std::string counted(std::size_t count, std::string_view noun);
/// Parses a whole word as a number; false if it is not one.
bool parse_whole(std::string_view word, std::int64_t& value);
bool parse_real(std::string_view word, double& value);
/// Number of the line that holds a byte, from 1.
std::size_t line_of(std::string_view bytes, std::size_t offset);

/// First bytes of a file, for recognizing its format; empty if the file does not exist.
std::string first_bytes(const std::filesystem::path& path);

}  // namespace turgor::io
