#include "turgor/io/files/file_cursor.hpp"

#include <algorithm>
#include <bit>
#include <cctype>
#include <charconv>
#include <fstream>

#include <fmt/format.h>

#include "turgor/io/files/file.hpp"
#include "turgor/io/files/input_file.hpp"

namespace turgor::io {

namespace fs = std::filesystem;

namespace {

bool is_space(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

template <class T>
bool parse(std::string_view word, T& value) {
  if (word.starts_with('+')) word.remove_prefix(1);
  const auto [end, failed] = std::from_chars(word.data(), word.data() + word.size(), value);
  return failed == std::errc{} && end == word.data() + word.size();
}

std::int64_t sign_extended(std::uint64_t bits, int bytes) {
  const int unused = 64 - 8 * bytes;
  return std::int64_t(bits << unused) >> unused;
}

}  // namespace

std::string quoted(std::string_view text) {
  constexpr std::size_t kShown = 40;
  std::string shown;
  for (const char c : text.substr(0, kShown)) shown += c >= ' ' && c <= '~' ? c : '?';
  return fmt::format("\"{}{}\"", shown, text.size() > kShown ? "..." : "");
}

double read_real(FileCursor& cursor, NumberType type) {
  return type.kind == NumberType::kReal ? cursor.real(type.bytes, "a number")
                                        : double(read_whole(cursor, type));
}

std::int64_t read_whole(FileCursor& cursor, NumberType type) {
  if (type.kind == NumberType::kReal) cursor.fail("an integer type", "a real type");
  return type.kind == NumberType::kSigned ? cursor.whole(type.bytes, "a whole number")
                                          : std::int64_t(cursor.unsigned_whole(type.bytes, "a whole number"));
}

std::string lower_case(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) c = char(std::tolower(static_cast<unsigned char>(c)));
  return lower;
}

std::string counted(std::size_t count, std::string_view noun) {
  return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s");
}

bool parse_whole(std::string_view word, std::int64_t& value) { return parse(word, value); }
bool parse_real(std::string_view word, double& value) { return parse(word, value); }

std::size_t line_of(std::string_view bytes, std::size_t offset) {
  const std::string_view before = bytes.substr(0, offset);
  return 1 + std::size_t(std::count(before.begin(), before.end(), '\n'));
}

void FileCursor::fail(std::string_view expected, std::string_view found) {
  if (!ok()) return;
  const std::string location = encoding == Encoding::kText ? fmt::format(":{}", line_of(bytes_, last_))
                                                           : fmt::format(": byte {}", last_);
  message_ = fmt::format("{}{}: expected {}, found {}", path_.string(), location, expected, found);
}

void FileCursor::fail(std::string_view expected) {
  const std::string_view word = bytes_.substr(last_, at_ - last_);
  fail(expected, word.empty() ? std::string("the end of the file") : quoted(word));
}

void FileCursor::skip_space() {
  while (at_ < bytes_.size())
    if (has_comments && bytes_[at_] == '#')
      at_ = std::min(bytes_.find('\n', at_), bytes_.size());
    else if (is_space(bytes_[at_]))
      at_++;
    else
      return;
}

std::string_view FileCursor::word() {
  if (!ok()) return {};
  skip_space();
  last_ = at_;
  while (at_ < bytes_.size() && !is_space(bytes_[at_]) && !(has_comments && bytes_[at_] == '#')) at_++;
  return bytes_.substr(last_, at_ - last_);
}

std::string_view FileCursor::peek_word() {
  const std::size_t start = at_, last = last_;
  const std::string_view next = word();
  at_ = start;
  last_ = last;
  return next;
}

void FileCursor::expect(std::string_view expected) {
  if (word() != expected) fail(expected);
}

std::string_view FileCursor::line() {
  if (!ok()) return {};
  last_ = at_;
  const std::size_t end = std::min(bytes_.find('\n', at_), bytes_.size());
  std::string_view text = bytes_.substr(at_, end - at_);
  at_ = std::min(end + 1, bytes_.size());
  if (text.ends_with('\r')) text.remove_suffix(1);
  return text;
}

bool FileCursor::at_end() {
  skip_space();
  return !ok() || at_ == bytes_.size();
}

std::string_view FileCursor::skip(std::size_t bytes) {
  if (!ok()) return {};
  last_ = at_;
  if (bytes > bytes_.size() - at_) {
    fail(fmt::format("{} more bytes", bytes), fmt::format("{}", bytes_.size() - at_));
    return {};
  }
  at_ += bytes;
  return bytes_.substr(last_, bytes);
}

std::uint64_t FileCursor::number_bits(std::string_view bytes) const {
  std::uint64_t bits = 0;
  for (std::size_t i = 0; i < bytes.size(); i++) {
    const std::size_t from = encoding == Encoding::kBigEndian ? i : bytes.size() - 1 - i;
    bits = bits << 8 | std::uint64_t(static_cast<unsigned char>(bytes[from]));
  }
  return bits;
}

std::int64_t FileCursor::whole(int bytes, std::string_view what) {
  if (encoding != Encoding::kText) return sign_extended(number_bits(skip(std::size_t(bytes))), bytes);
  std::int64_t value = 0;
  if (!parse_whole(word(), value)) fail(what);
  return value;
}

std::uint64_t FileCursor::unsigned_whole(int bytes, std::string_view what) {
  if (encoding != Encoding::kText) return number_bits(skip(std::size_t(bytes)));
  std::uint64_t value = 0;
  if (!parse(word(), value)) fail(what);
  return value;
}

double FileCursor::real(int bytes, std::string_view what) {
  double value = 0;
  if (encoding == Encoding::kText) {
    if (!parse_real(word(), value)) fail(what);
    return value;
  }
  const std::uint64_t bits = number_bits(skip(std::size_t(bytes)));
  return bytes == 4 ? double(std::bit_cast<float>(std::uint32_t(bits))) : std::bit_cast<double>(bits);
}

bool FileCursor::can_hold(std::uint64_t items, ItemSize item, std::string_view what) {
  const std::size_t smallest = encoding == Encoding::kText ? 2 * item.words : item.bytes;
  // The last word of a text needs no separator after it.
  if (ok() && items > (bytes_.size() - at_ + 1) / std::max<std::size_t>(smallest, 1))
    fail(fmt::format("{} that the rest of the file can hold", what), fmt::format("{}", items));
  return ok();
}

std::size_t FileCursor::count(int bytes, ItemSize item, std::string_view what) {
  const std::int64_t items = whole(bytes, what);
  if (items < 0) fail(what, fmt::format("{}", items));
  return can_hold(std::uint64_t(items), item, what) ? std::size_t(items) : 0;
}

std::string first_bytes(const fs::path& path) {
  if (!check_input(path)) return {};
  std::string head(65536, '\0');
  std::ifstream stream(path, std::ios::binary);
  stream.read(head.data(), std::streamsize(head.size()));
  head.resize(std::size_t(stream.gcount()));
  return head;
}

}  // namespace turgor::io
