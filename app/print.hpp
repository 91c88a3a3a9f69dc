// Standard output and standard error of the commands. Their text leaves here, cleaned by plain_text.
#pragma once

#include <cstdio>
#include <string>
#include <string_view>
#include <type_traits>

#include <fmt/format.h>

#include "turgor/core/plain_text.hpp"

namespace turgor {

template <class T>
constexpr bool kIsText = std::is_convertible_v<const T&, std::string_view>;
/// An argument as it is printed: a text on one line of its own, everything else unchanged.
template <class T>
using Printed = std::conditional_t<kIsText<T>, std::string, T>;

template <class T>
Printed<T> printed(const T& value) {
  if constexpr (kIsText<T>)
    return on_one_line(value);
  else
    return value;
}

/// Prints on standard output. No text among the arguments can start a line; `format` is the program's own.
template <class... Args>
void print_plain(fmt::format_string<Printed<Args>...> format, const Args&... args) {
  fmt::print(format, printed(args)...);
}

/// The same on a stream.
template <class... Args>
void print_plain(std::FILE* stream, fmt::format_string<Printed<Args>...> format, const Args&... args) {
  fmt::print(stream, format, printed(args)...);
}

/// Prints several lines on standard output.
inline void print_text(std::string_view text) { fmt::print("{}", plain_text(text)); }

/// Prints a message on standard error. Errors of a scene have several lines.
inline void print_message(std::string_view program, std::string_view message) {
  std::fflush(stdout);  // so that both are in order where they go to one file
  std::fputs((std::string(program) + ": " + plain_text(message) + "\n").c_str(), stderr);
}

}  // namespace turgor
