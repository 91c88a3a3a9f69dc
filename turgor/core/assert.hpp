// TURGOR_ASSERT checks a precondition that the programmer must meet. It is on unless TURGOR_NO_ASSERT is
// defined, and is never used for files, devices or scenes (those return Result). A failed assertion is
// printed and the program aborts, unless the host program sets its own handler.
// TURGOR_CHECK does the same for invariants of data structures and steps. It exists in checked builds only
// (TURGOR_CHECKED: presets checked, debug, asan and tsan; CI) and costs nothing in others.
#pragma once

namespace turgor {

/// Receives __FILE__, __LINE__, the sentence and the condition that is false. It may log, save the user's
/// work, throw, or end the program. When it returns, the program aborts because the library's state is no
/// longer valid. After an exception, the objects that the library was working on must be discarded. An
/// exception cannot leave a thread of the library: it ends the program.
using AssertionHandler = void (*)(const char* file, int line, const char* sentence, const char* condition);

/// Sets the handler of all threads; null = print to standard error (the default). Returns the previous
/// handler.
AssertionHandler set_assertion_handler(AssertionHandler handler);

/// Called by TURGOR_ASSERT when its condition is false.
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

#if defined(TURGOR_CHECKED) && !defined(__CUDA_ARCH__)
#define TURGOR_CHECK(condition, sentence) TURGOR_ASSERT(condition, sentence)
#else
#define TURGOR_CHECK(condition, sentence) ((void)sizeof(!(condition)))
#endif
