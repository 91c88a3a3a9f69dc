#include "c/guard.hpp"

#include <cstdio>
#include <cstring>

#include "turgor/core/assert.hpp"

namespace turgor::c {

namespace {

thread_local char error_of_thread[2048] = "";

void throw_broken(const char* file, int line, const char* sentence, const char* condition) {
  char text[1024];
  std::snprintf(text, sizeof text, "%s:%d: %s (%s is false)", file, line, sentence, condition);
  throw Broken(text);
}

}  // namespace

void set_error(const char* sentence) noexcept {
  std::size_t size = strnlen(sentence, sizeof error_of_thread - 1);
  // a longer sentence ends with a whole character of UTF-8
  while (size > 0 && (sentence[size] & 0xc0) == 0x80) size--;
  std::memcpy(error_of_thread, sentence, size);
  error_of_thread[size] = '\0';
}

const char* current_error() noexcept { return error_of_thread; }

void throw_assertions() noexcept {
  static const AssertionHandler before = set_assertion_handler(throw_broken);
  (void)before;
}

}  // namespace turgor::c
