// Result<T>: a value, or a message about an external error (a file, a scene, a device): location, what was
// expected, what was found. Errors of the programmer are assertions instead.
#pragma once

#include <string>
#include <utility>
#include <variant>

#include "turgor/core/assert.hpp"

namespace turgor {

struct Error {
  std::string message;
};

template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value)
      : content_(std::in_place_index<0>, std::move(value)) {}  // NOLINT(google-explicit-constructor)
  Result(Error error)
      : content_(std::in_place_index<1>, std::move(error)) {}  // NOLINT(google-explicit-constructor)

  explicit operator bool() const { return content_.index() == 0; }
  T& value() & {
    TURGOR_ASSERT(*this, error().message.c_str());
    return std::get<0>(content_);
  }
  const T& value() const& {
    TURGOR_ASSERT(*this, error().message.c_str());
    return std::get<0>(content_);
  }
  T&& value() && { return std::move(value()); }
  T& operator*() & { return value(); }
  const T& operator*() const& { return value(); }
  T&& operator*() && { return std::move(value()); }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }
  const Error& error() const { return std::get<1>(content_); }

 private:
  std::variant<T, Error> content_;
};

/// Success without a value.
struct Done {};
using Status = Result<Done>;

}  // namespace turgor
