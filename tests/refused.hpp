// Expectations on the message of an error.
#pragma once

#include <string>

#include <gtest/gtest.h>

/// The result is an error whose message names each of the words.
#define EXPECT_REFUSED(expression, ...)                                                  \
  do {                                                                                   \
    const auto refused_result = (expression);                                            \
    ASSERT_FALSE(refused_result) << "expected an error";                                 \
    for (const std::string refused_word : {__VA_ARGS__})                                 \
      EXPECT_NE(refused_result.error().message.find(refused_word), std::string::npos)    \
          << "\"" << refused_word << "\" is not in: " << refused_result.error().message; \
  } while (false)
