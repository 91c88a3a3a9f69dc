#include "turgor/core/assert.hpp"

#include <stdexcept>
#include <string>

#include <gtest/gtest.h>

namespace turgor {
namespace {

void throw_sentence(const char*, int, const char* sentence, const char* condition) {
  throw std::logic_error(std::string(sentence) + ": " + condition);
}

/// Puts the handler of before back.
struct WithHandler {
  AssertionHandler before;
  explicit WithHandler(AssertionHandler handler) : before(set_assertion_handler(handler)) {}
  ~WithHandler() { set_assertion_handler(before); }
};

TEST(Assert, AHostProgramCanTurnABrokenPromiseIntoAnException) {
  const WithHandler with(throw_sentence);
  int two = 2;
  try {
    TURGOR_ASSERT(two == 3, "two is three");
    FAIL() << "nothing was thrown";
  } catch (const std::logic_error& error) {
    EXPECT_STREQ(error.what(), "two is three: two == 3");
  }
  EXPECT_EQ(set_assertion_handler(throw_sentence), throw_sentence) << "the handler before is told";
}

TEST(AssertDeathTest, WithoutAHandlerTheSentenceIsPrintedAndTheProgramAborted) {
  EXPECT_DEATH(TURGOR_ASSERT(1 + 1 == 3, "sums are right"), "assert.cpp:[0-9]+: sums are right");
}

TEST(AssertDeathTest, AHandlerThatReturnsDoesNotLetTheProgramGoOn) {
  EXPECT_DEATH(
      {
        set_assertion_handler([](const char*, int, const char*, const char*) {});
        TURGOR_ASSERT(false, "never");
      },
      "");
}

}  // namespace
}  // namespace turgor
