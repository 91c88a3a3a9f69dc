// transfer(file, value): writes a value to a StateWriter, or reads it from a StateReader. One function serves
// both directions, so that they cannot differ. Structs list their members by structured bindings: a new
// member does not compile until its transfer is decided.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "turgor/sim/autosave/state_file.hpp"

namespace turgor {

/// True for values that are stored as their bytes: numbers, and structs of numbers without pointers.
template <class T>
constexpr bool is_stored_as_bytes = std::is_trivially_copyable_v<T> && !std::is_pointer_v<T>;

template <class File, class... Values>
void transfer_all(File& file, Values&... values);

template <class File, class T>
requires is_stored_as_bytes<T>
void transfer(File& file, T& value) { file.bytes(&value, sizeof value); }

/// Number of elements: written, or read and bounded by the length of the file.
template <class File>
std::size_t transfer_count(File& file, std::size_t count, std::size_t element_size) {
  if constexpr (File::kReads) {
    return file.count(element_size);
  } else {
    file.number(count);
    return count;
  }
}

template <class File, class T, class Allocator>
void transfer(File& file, std::vector<T, Allocator>& values) {
  values.resize(transfer_count(file, values.size(), is_stored_as_bytes<T> ? sizeof(T) : 1));
  if constexpr (is_stored_as_bytes<T>)
    file.bytes(values.data(), values.size() * sizeof(T));
  else
    for (T& value : values) transfer(file, value);
}

template <class File>
void transfer(File& file, std::string& text) {
  text.resize(transfer_count(file, text.size(), 1));
  file.bytes(text.data(), text.size());
}

template <class File>
void transfer(File& file, std::filesystem::path& path) {
  std::string text = path.string();
  transfer(file, text);
  path = text;
}

template <class File, class A, class B>
requires(!is_stored_as_bytes<std::pair<A, B>>) void transfer(File& file, std::pair<A, B>& pair) {
  transfer_all(file, pair.first, pair.second);
}

template <class File, class T>
requires(!is_stored_as_bytes<std::optional<T>>) void transfer(File& file, std::optional<T>& value) {
  bool has_value = value.has_value();
  transfer(file, has_value);
  if (has_value && !value) value.emplace();
  if (!has_value) value.reset();
  if (value) transfer(file, *value);
}

template <class File, class... Ts>
requires(!is_stored_as_bytes<std::variant<Ts...>>) void transfer(File& file, std::variant<Ts...>& value) {
  std::uint64_t index = value.index();
  transfer(file, index);
  if constexpr (File::kReads) {
    std::uint64_t n = 0;
    ((n++ == index ? void(value = Ts()) : void()), ...);
    if (index >= sizeof...(Ts)) file.fail();
  }
  std::visit([&](auto& content) { transfer(file, content); }, value);
}

/// All of these values, in this order.
template <class File, class... Values>
void transfer_all(File& file, Values&... values) {
  (transfer(file, values), ...);
}

}  // namespace turgor
