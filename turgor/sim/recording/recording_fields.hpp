// Reads and writes the recorded fields of a struct (core/field.hpp), as listed in the model's fields.hpp.
// Used by recording*.cpp.
#pragma once

#include <cstdint>
#include <span>
#include <type_traits>
#include <vector>

#include "turgor/core/field.hpp"
#include "turgor/core/vec.hpp"
#include "turgor/sim/recording/recording_arrays.hpp"

namespace turgor {

/// Entries of the fields of one axis that a file contains, and their order: the nodes of a body, or the
/// vertices of the given mesh. Fields of other axes are stored whole.
struct RecordedEntries {
  Axis axis = Axis::kOther;
  std::span<const int> listed;
};

namespace detail {

template <class T>
concept HasCoordinates = requires(const T& t) {
  t.x.data(), t[std::size_t(0)].x;
};
template <class T>
concept HasColumns = requires(const T& t) {
  visit_columns(t.data(), NoVisit{});
};
template <class T>
concept IsPlainList = requires(const T& t) {
  t.data();
}
&&std::is_arithmetic_v<typename T::value_type>;

template <HasCoordinates T>
void write_field(Writing& writing, const Field& field, const T& values, const RecordedEntries& entries) {
  std::vector<float> flat;
  flat.reserve(3 * entries.listed.size());
  for (const int i : entries.listed) {
    const Vec3 v = values[std::size_t(i)];
    flat.insert(flat.end(), {v.x, v.y, v.z});
  }
  writing.array(field.name, flat, 3, field.unit);
}
template <HasColumns T>
void write_field(Writing& writing, const Field& field, const T& values, const RecordedEntries&) {
  visit_columns(values.data(), [&](const Field& column, auto member) {
    std::vector<std::remove_cvref_t<decltype(values[0].*member)>> list;
    for (const auto& entry : values) list.push_back(entry.*member);
    writing.array(std::string(field.name) + "_" + column.name, list, 1, column.unit);
  });
}
template <IsPlainList T>
void write_field(Writing& writing, const Field& field, const T& values, const RecordedEntries& entries) {
  std::vector<typename T::value_type> list;
  if (field.axis == entries.axis)
    for (const int i : entries.listed) list.push_back(values[std::size_t(i)]);
  else
    list.assign(values.begin(), values.end());
  writing.array(field.name, list, 1, field.unit);
}

template <HasCoordinates T>
void read_field(Reading& reading, const Field& field, T& values, const RecordedEntries& entries,
                std::size_t) {
  const auto flat = reading.array<float>(field.name, 3 * entries.listed.size());
  for (std::size_t n = 0; 3 * n < flat.size(); n++) {
    const Vec3 v{flat[3 * n], flat[3 * n + 1], flat[3 * n + 2]};
    if (!std::isfinite(dot(v, v))) reading.fail(field.name, "a value is not a number");
    values.set(std::size_t(entries.listed[n]), v);
  }
}
template <HasColumns T>
void read_field(Reading& reading, const Field& field, T& values, const RecordedEntries&, std::size_t most) {
  std::optional<std::size_t> count;
  visit_columns(values.data(), [&](const Field& column, auto member) {
    using Value = std::remove_cvref_t<decltype(values[0].*member)>;
    const std::string name = std::string(field.name) + "_" + column.name;
    if (!count) values.resize(*(count = reading.count(name, most)));
    const std::vector<Value> list = reading.array<Value>(name, *count);
    for (std::size_t n = 0; n < list.size(); n++) values[n].*member = list[n];
  });
}
template <IsPlainList T>
void read_field(Reading& reading, const Field& field, T& values, const RecordedEntries& entries,
                std::size_t) {
  const bool some = field.axis == entries.axis;
  const auto list =
      reading.array<typename T::value_type>(field.name, some ? entries.listed.size() : values.size());
  for (std::size_t n = 0; n < list.size(); n++) values[some ? std::size_t(entries.listed[n]) : n] = list[n];
}

}  // namespace detail

/// Writes a dataset with its unit for each recorded field.
template <class Struct>
void write_fields(Writing& writing, const Struct& s, const RecordedEntries& entries) {
  visit_fields(s, [&](const Field& field, const auto& values) {
    if constexpr (requires { detail::write_field(writing, field, values, entries); })
      if (field.use & kRecorded) detail::write_field(writing, field, values, entries);
  });
}
/// Reads into a struct whose arrays have their sizes; growing lists have at most `most` entries.
template <class Struct>
void read_fields(Reading& reading, Struct& s, const RecordedEntries& entries, std::size_t most = 0) {
  visit_fields(s, [&](const Field& field, auto& values) {
    if constexpr (requires { detail::read_field(reading, field, values, entries, most); })
      if (field.use & kRecorded) detail::read_field(reading, field, values, entries, most);
  });
}

}  // namespace turgor
