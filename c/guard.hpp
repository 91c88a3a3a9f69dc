// Boundary between C++ and C: exceptions become a status and the thread's error message.
#pragma once

#include <new>
#include <stdexcept>
#include <string>
#include <string_view>

#include "c/turgor.h"
#include "turgor/core/plain_text.hpp"
#include "turgor/core/result.hpp"

namespace turgor::c {

struct Misuse : std::runtime_error {
  using std::runtime_error::runtime_error;
};
struct Refused : std::runtime_error {
  explicit Refused(std::string_view sentence) : std::runtime_error(plain_text(sentence)) {}
};
/// Failed assertion of the library.
struct Broken : std::runtime_error {
  using std::runtime_error::runtime_error;
};

template <class T>
T required(Result<T> result) {
  if (!result) throw Refused(result.error().message);
  return std::move(*result);
}
inline void expect(bool condition, const char* sentence) {
  if (!condition) throw Misuse(sentence);
}

/// Error message of this thread; without allocation.
void set_error(const char* sentence) noexcept;
const char* current_error() noexcept;
/// Makes failed assertions throw instead of ending the program.
void throw_assertions() noexcept;

/// Runs `call` and converts exceptions to a status.
template <class Call>
tg_status guarded(const Call& call) noexcept {
  throw_assertions();
  const auto failed = [](tg_status status, const char* sentence) {
    set_error(sentence);
    return status;
  };
  try {
    set_error("");
    call();
    return TG_OK;
  } catch (const Misuse& error) {
    return failed(TG_MISUSE, error.what());
  } catch (const Refused& error) {
    return failed(TG_ERROR, error.what());
  } catch (const std::bad_alloc&) {
    return failed(TG_NO_MEMORY, "not enough memory");
  } catch (const std::exception& error) {
    return failed(TG_BROKEN, error.what());
  } catch (...) {
    return failed(TG_BROKEN, "unknown exception");
  }
}

}  // namespace turgor::c
