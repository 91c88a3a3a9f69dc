// Reflection of a body's fields: name, unit and axis, stated once beside the struct. `visit_fields(struct,
// visit)` in a model's fields.hpp calls visit(Field, array) for each. Memory sizes, hashes and recordings use
// that list, so that a new field needs one member and one line.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

#include "turgor/core/hash.hpp"

namespace turgor {

/// Items that the entries of a field belong to.
enum class Axis : unsigned char { kBody, kSlot, kRow, kVertex, kTriangle, kSkinTriangle, kCutEdge, kOther };

enum FieldUse : unsigned {
  kPlain = 0,     // counted only in memory sizes
  kHashed = 1,    // affects later steps: part of the state hash
  kRecorded = 2,  // stored in recordings under this name and unit
};

struct Field {
  const char* name;
  const char* unit;  // "" = a number, a flag or an index
  Axis axis = Axis::kOther;
  unsigned use = kPlain;
};

struct NoVisit {
  void operator()(const Field&, const auto&) const {}
};
template <class... Structs>
std::size_t bytes_of_fields(const Structs&... structs);

/// Bytes of a field's entries: arrays, arrays of arrays, three arrays of coordinates, plain values.
template <class T>
std::size_t field_bytes(const T& values) {
  if constexpr (requires { visit_fields(values, NoVisit{}); }) {
    return bytes_of_fields(values);
  } else if constexpr (requires { values.x.size(); }) {
    return field_bytes(values.x) + field_bytes(values.y) + field_bytes(values.z);
  } else if constexpr (requires { values.capacity(); }) {
    using Value = typename T::value_type;
    if constexpr (std::is_trivially_copyable_v<Value>) return values.capacity() * sizeof(Value);
    std::size_t sum = 0;
    for (const auto& value : values) sum += field_bytes(value);
    return sum;
  } else {
    return sizeof(T);
  }
}

/// Bytes of all fields of these structs.
template <class... Structs>
std::size_t bytes_of_fields(const Structs&... structs) {
  std::size_t sum = 0;
  const auto add = [&sum](const Field&, const auto& values) { sum += field_bytes(values); };
  (visit_fields(structs, add), ...);
  return sum;
}

/// Three arrays of coordinates, or one array of plain values.
template <class T>
concept HasEntries = requires(const T& t) {
  t.x.data();
}
|| (requires(const T& t) { t.data(); } && std::is_trivially_copyable_v<typename T::value_type>);

/// Hash of entries `begin` to `begin + count` of a field, continued from `seed`.
template <class T>
std::uint64_t hash_entries(const T& values, std::size_t begin, std::size_t count, std::uint64_t seed) {
  if constexpr (requires { values.x.size(); }) {
    for (const auto* axis : {&values.x, &values.y, &values.z}) seed = hash_entries(*axis, begin, count, seed);
    return seed;
  } else {
    return hash_values(std::span<const typename T::value_type>(values.data() + begin, count), seed);
  }
}
/// Hash of entries `begin` to `begin + count` of all hashed fields, one field after the other.
template <class Struct>
std::uint64_t hash_of_fields(const Struct& s, std::size_t begin, std::size_t count, std::uint64_t seed) {
  visit_fields(s, [&](const Field& field, const auto& values) {
    if constexpr (HasEntries<std::remove_cvref_t<decltype(values)>>)
      if (field.use & kHashed) seed = hash_entries(values, begin, count, seed);
  });
  return seed;
}

}  // namespace turgor
