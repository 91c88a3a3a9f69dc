// TURGOR_ASSERT: a sentence about what the programmer promised. On unless TURGOR_NO_ASSERT is defined; never
// used for files, devices or scenes (those return Result).
#pragma once

#include <cstdio>
#include <cstdlib>

#ifdef TURGOR_NO_ASSERT
#define TURGOR_ASSERT(condition, sentence) ((void)0)
#else
#define TURGOR_ASSERT(condition, sentence)                                                         \
  do {                                                                                             \
    if (!(condition)) {                                                                            \
      std::fprintf(stderr, "%s:%d: %s (%s is false)\n", __FILE__, __LINE__, sentence, #condition); \
      std::abort();                                                                                \
    }                                                                                              \
  } while (false)
#endif
