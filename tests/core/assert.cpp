#include "turgor/core/assert.hpp"

#include <stdexcept>
#include <string>

#include <gtest/gtest.h>

namespace turgor {
namespace {

void throw_message(const char*, int, const char* message, const char* condition) {
  throw std::logic_error(std::string(message) + ": " + condition);
}

/// Installs a handler and restores the previous one at the end of the scope.
struct WithHandler {
  AssertionHandler before;
  explicit WithHandler(AssertionHandler handler) : before(set_assertion_handler(handler)) {}
  ~WithHandler() { set_assertion_handler(before); }
};

// A host program installs a handler that turns a failed assertion into an exception.
TEST(Assert, HandlerMayThrow) {
  const WithHandler with(throw_message);
  int two = 2;
  try {
    TURGOR_ASSERT(two == 3, "two is three");
    FAIL() << "nothing was thrown";
  } catch (const std::logic_error& error) {
    EXPECT_STREQ(error.what(), "two is three: two == 3");
  }
  EXPECT_EQ(set_assertion_handler(throw_message), throw_message) << "returns the previous handler";
}

// Without a handler, a failed assertion prints its message and aborts the program.
TEST(AssertDeathTest, AbortsWithMessageByDefault) {
  EXPECT_DEATH(TURGOR_ASSERT(1 + 1 == 3, "sums are right"), "assert.cpp:[0-9]+: sums are right");
}

// The program aborts even if the handler returns.
TEST(AssertDeathTest, AbortsWhenHandlerReturns) {
  EXPECT_DEATH(
      {
        set_assertion_handler([](const char*, int, const char*, const char*) {});
        TURGOR_ASSERT(false, "never");
      },
      "");
}

}  // namespace
}  // namespace turgor
