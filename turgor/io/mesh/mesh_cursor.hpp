// The words and numbers of a mesh file in their order, as text or as bytes of either order. The first thing
// that is not as expected is remembered with its place; whatever is read after it is empty or zero, so that
// readers look at ok() where they loop, and count() never lets them allocate more than the file can hold.
// Internal to io/.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "turgor/core/result.hpp"

namespace turgor::io {

enum class Encoding { kText, kLittleEndian, kBigEndian };

/// The least that one item takes in a file: words of text, or bytes.
struct ItemSize {
  std::size_t words, bytes;
};

class MeshCursor {
 public:
  MeshCursor(const std::filesystem::path& path, std::string_view bytes) : path_(path), bytes_(bytes) {}

  Encoding encoding = Encoding::kText;
  bool has_comments = false;  // in text, '#' and what follows it on its line are passed over

  bool ok() const { return message_.empty(); }
  Error error() const { return {message_}; }
  /// Remembers that something else was expected at the word or number read last.
  void fail(std::string_view expected, std::string_view found);
  /// The same, with the word itself as what was found.
  void fail(std::string_view expected);

  /// The next word of text; empty at the end.
  std::string_view word();
  std::string_view peek_word();
  void expect(std::string_view word);
  /// The rest of this line, without its end.
  std::string_view line();
  bool at_end();

  /// The next number: a word of text, or so many bytes.
  std::int64_t whole(int bytes, std::string_view what);
  std::uint64_t unsigned_whole(int bytes, std::string_view what);
  double real(int bytes, std::string_view what);
  /// How many items follow; fails where the rest of the file cannot hold them.
  std::size_t count(int bytes, ItemSize item, std::string_view what);
  /// Whether the rest of the file can hold so many items; fails if not.
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
  std::size_t at_ = 0, last_ = 0;  // where reading goes on; where the last word or number began
  std::string message_;
};

/// A type of numbers in a file.
struct NumberType {
  enum Kind { kReal, kSigned, kUnsigned } kind = kReal;
  int bytes = 8;  // 0: bits
};
double read_real(MeshCursor& cursor, NumberType type);
/// Fails for real types.
std::int64_t read_whole(MeshCursor& cursor, NumberType type);

/// A piece of a file as a message may show it.
std::string quoted(std::string_view text);
std::string lower_case(std::string_view text);
/// "1 node", "2 nodes".
std::string counted(std::size_t count, std::string_view noun);
/// The whole of a word as a number; false if it is none.
bool parse_whole(std::string_view word, std::int64_t& value);
bool parse_real(std::string_view word, double& value);
/// The number of the line that holds a byte, from 1.
std::size_t line_of(std::string_view bytes, std::size_t offset);

/// The whole mesh file. Error: not there, a folder, empty.
Result<std::string> read_mesh_bytes(const std::filesystem::path& path);
/// The beginning of a file, by which it is recognised; empty if there is no file.
std::string first_bytes(const std::filesystem::path& path);

}  // namespace turgor::io
