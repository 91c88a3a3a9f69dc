// Between C++ and C: what is thrown becomes a status and a sentence of the thread.
#pragma once

#include <new>
#include <stdexcept>
#include <string>

#include "c/turgor.h"
#include "turgor/core/result.hpp"

namespace turgor::c {

struct Misuse : std::runtime_error {
  using std::runtime_error::runtime_error;
};
struct Refused : std::runtime_error {
  using std::runtime_error::runtime_error;
};
/// A promise of the library's own that does not hold.
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

/// Of this thread; allocates nothing.
void keep_error(const char* sentence) noexcept;
const char* kept_error() noexcept;
/// From here on broken promises are thrown, where they would end the program.
void throw_assertions() noexcept;

/// What `call` throws as a status.
template <class Call>
tg_status guarded(const Call& call) noexcept {
  throw_assertions();
  const auto failed = [](tg_status status, const char* sentence) {
    keep_error(sentence);
    return status;
  };
  try {
    keep_error("");
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
    return failed(TG_BROKEN, "something unknown was thrown");
  }
}

}  // namespace turgor::c
