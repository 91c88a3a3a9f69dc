// Arrays for NumPy, and errors that become Python exceptions.
#pragma once

#include <memory>
#include <stdexcept>
#include <string_view>
#include <utility>
#include <vector>

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include "turgor/core/plain_text.hpp"
#include "turgor/core/result.hpp"
#include "turgor/core/vec.hpp"

namespace turgor {

namespace nb = nanobind;

/// Becomes turgor.Error with the message.
struct Refused : std::runtime_error {
  explicit Refused(std::string_view sentence) : std::runtime_error(plain_text(sentence)) {}
};

template <class T>
T required(Result<T> result) {
  if (!result) throw Refused(result.error().message);
  return std::move(*result);
}
inline void required(Status status) {
  if (!status) throw Refused(status.error().message);
}

template <class T>
using Array = nb::ndarray<nb::numpy, T>;
using Shape = std::vector<std::size_t>;

/// New array that owns its data.
template <class T>
Array<T> shaped_array(std::vector<T> numbers, const Shape& shape) {
  auto kept = std::make_unique<std::vector<T>>(std::move(numbers));
  T* data = kept->data();
  nb::capsule owner(kept.release(), [](void* p) noexcept { delete static_cast<std::vector<T>*>(p); });
  return Array<T>(data, shape.size(), shape.data(), owner);
}
/// New array of rows × columns; columns 0 = one dimension.
template <class T>
Array<T> new_array(std::vector<T> numbers, std::size_t columns) {
  const std::size_t count = numbers.size();
  return columns == 0 ? shaped_array(std::move(numbers), {count})
                      : shaped_array(std::move(numbers), {count / columns, columns});
}

template <class T>
Array<T> rows_of(const std::vector<Vec<T>>& points) {
  std::vector<T> numbers;
  numbers.reserve(3 * points.size());
  for (const Vec<T> p : points) numbers.insert(numbers.end(), {p.x, p.y, p.z});
  return new_array(std::move(numbers), 3);
}

}  // namespace turgor
