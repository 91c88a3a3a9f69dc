// TURGOR_ASSERT: a sentence about what the programmer promised. On unless TURGOR_NO_ASSERT is defined; never
// used for files, devices or scenes (those return Result). A broken promise is printed and the program
// aborted, unless the host program sets a handler of its own.
#pragma once

namespace turgor {

/// Told where and what was promised: __FILE__, __LINE__, the sentence and the condition that is false. May
/// log, save the user's work, throw, or end the program; when it returns, the program is aborted, because
/// nothing holds behind a broken promise. An exception leaves what the library was working on to be thrown
/// away, and does not pass a thread of the library: there it ends the program.
using AssertionHandler = void (*)(const char* file, int line, const char* sentence, const char* condition);

/// For all threads; null = print to standard error, the default. Returns the handler before.
AssertionHandler set_assertion_handler(AssertionHandler handler);

/// What TURGOR_ASSERT does when its condition is false.
[[noreturn]] void fail_assertion(const char* file, int line, const char* sentence, const char* condition);

}  // namespace turgor

#ifdef TURGOR_NO_ASSERT
#define TURGOR_ASSERT(condition, sentence) ((void)0)
#else
#define TURGOR_ASSERT(condition, sentence)                                                \
  do {                                                                                    \
    if (!(condition)) ::turgor::fail_assertion(__FILE__, __LINE__, sentence, #condition); \
  } while (false)
#endif
