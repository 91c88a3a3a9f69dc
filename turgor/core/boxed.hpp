// boxed<T>: an optional value on the heap. Unlike a unique_ptr it is copied with its owner. Structs with
// members that must keep their address, or that are seldom set, thus stay copyable.
#pragma once

#include <memory>
#include <utility>

namespace turgor {

template <class T>
class boxed {  // NOLINT(readability-identifier-naming): reads as a word in declarations, like std::optional
 public:
  boxed() = default;
  boxed(std::unique_ptr<T> value) : value_(std::move(value)) {}  // NOLINT(google-explicit-constructor)
  boxed(const boxed& other) : value_(other ? std::make_unique<T>(*other) : nullptr) {}
  boxed& operator=(const boxed& other) {
    if (this != &other) value_ = other ? std::make_unique<T>(*other) : nullptr;
    return *this;
  }
  boxed(boxed&&) noexcept = default;
  boxed& operator=(boxed&&) noexcept = default;
  ~boxed() = default;

  explicit operator bool() const { return value_ != nullptr; }
  T& operator*() { return *value_; }
  const T& operator*() const { return *value_; }
  T* operator->() { return value_.get(); }
  const T* operator->() const { return value_.get(); }
  void reset() { value_.reset(); }

 private:
  std::unique_ptr<T> value_;
};

}  // namespace turgor
