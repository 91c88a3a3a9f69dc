// Builder for binary files in tests, in either byte order.
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

namespace turgor::test {

class Bytes {
 public:
  explicit Bytes(bool is_big_endian) : is_big_endian_(is_big_endian) {}

  template <class T>
  Bytes& add(T value) {
    char bytes[sizeof(T)];
    std::memcpy(bytes, &value, sizeof(T));
    if (is_big_endian_ == (std::endian::native == std::endian::little))
      for (std::size_t i = 0; i < sizeof(T) / 2; i++) std::swap(bytes[i], bytes[sizeof(T) - 1 - i]);
    text.append(bytes, sizeof(T));
    return *this;
  }
  Bytes& ints(const std::vector<int>& values) {
    for (const int v : values) add(std::int32_t(v));
    return *this;
  }
  Bytes& sizes(const std::vector<int>& values) {
    for (const int v : values) add(std::int64_t(v));
    return *this;
  }
  Bytes& reals(const std::vector<double>& values) {
    for (const double v : values) add(v);
    return *this;
  }
  Bytes& raw(const std::string& bytes) {
    text += bytes;
    return *this;
  }

  std::string text;

 private:
  bool is_big_endian_;
};

}  // namespace turgor::test
