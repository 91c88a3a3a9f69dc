// Conditions of data structures for TURGOR_ASSERT and TURGOR_CHECK (core/assert.hpp). Most of them read a
// whole list, and therefore belong in TURGOR_CHECK.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <iterator>
#include <type_traits>
#include <vector>

#include "turgor/core/vec.hpp"

namespace turgor {

/// True if `index` is in [0, count).
template <class Index>
bool is_index(Index index, std::size_t count) {
  if constexpr (std::is_signed_v<Index>)
    if (index < 0) return false;
  return std::size_t(index) < count;
}
/// True if all three indices are in [0, count).
inline bool are_indices(Int3 indices, std::size_t count) {
  return is_index(indices.x, count) && is_index(indices.y, count) && is_index(indices.z, count);
}
/// True if all entries of a list are in [0, count): indices, or triples of indices.
template <class List>
bool all_indices(const List& list, std::size_t count) {
  return std::all_of(std::begin(list), std::end(list), [count](const auto& entry) {
    if constexpr (std::is_same_v<std::remove_cvref_t<decltype(entry)>, Int3>)
      return are_indices(entry, count);
    else
      return is_index(entry, count);
  });
}

/// True if the offsets of a CSR list begin at 0, never descend and end at `item_count`. A list without
/// offsets has no items.
template <class Offsets>
bool is_csr(const Offsets& offsets, std::size_t item_count) {
  if (std::empty(offsets)) return item_count == 0;
  return *std::begin(offsets) == 0 && std::is_sorted(std::begin(offsets), std::end(offsets)) &&
         std::size_t(*std::prev(std::end(offsets))) == item_count;
}

/// True if a list contains each of 0, 1, …, count − 1 once and nothing else.
template <class List>
bool is_permutation(const List& list, std::size_t count) {
  if (std::size(list) != count) return false;
  std::vector<char> seen(count, 0);
  for (const auto entry : list)
    if (!is_index(entry, count) || seen[std::size_t(entry)]++) return false;
  return true;
}

/// True if the keys of a list ascend; equal keys may follow each other.
template <class List, class Key = std::identity>
bool is_ascending(const List& list, const Key& key = {}) {
  return std::is_sorted(std::begin(list), std::end(list), [&key](const auto& a, const auto& b) {
    return std::invoke(key, a) < std::invoke(key, b);
  });
}
/// True if the keys of a list ascend strictly, so that no key occurs twice.
template <class List, class Key = std::identity>
bool is_sorted_unique(const List& list, const Key& key = {}) {
  return std::adjacent_find(std::begin(list), std::end(list), [&key](const auto& a, const auto& b) {
           return !(std::invoke(key, a) < std::invoke(key, b));
         }) == std::end(list);
}

/// True if all numbers or vectors of a list are finite.
template <class List>
bool all_finite(const List& list) {
  return std::all_of(std::begin(list), std::end(list), [](const auto& value) {
    if constexpr (std::is_arithmetic_v<std::remove_cvref_t<decltype(value)>>)
      return std::isfinite(value);
    else
      return is_finite(value);
  });
}

/// True if the weights sum to one within a tolerance: a list, or the components of a vector.
template <class List>
bool sums_to_one(const List& weights, double tolerance = 1e-6) {
  double sum = 0;
  for (const auto weight : weights) sum += double(weight);
  return std::abs(sum - 1) <= tolerance;
}
template <class T>
bool sums_to_one(const Vec<T>& weights, double tolerance = 1e-6) {
  return std::abs(double(weights.x) + double(weights.y) + double(weights.z) - 1) <= tolerance;
}

/// True if a vector has length one within a tolerance.
template <class T>
bool is_unit(const Vec<T>& v, double tolerance = 1e-3) {
  return std::abs(double(norm(v)) - 1) <= tolerance;
}

/// True if dt is the length of a step: positive and finite [s].
inline bool is_step_length(double dt) { return dt > 0 && std::isfinite(dt); }

}  // namespace turgor
