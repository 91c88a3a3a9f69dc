#include "turgor/core/assert.hpp"

#include <atomic>
#include <cstdio>
#include <cstdlib>

namespace turgor {

namespace {

void print_assertion(const char* file, int line, const char* sentence, const char* condition) {
  std::fprintf(stderr, "%s:%d: %s (%s is false)\n", file, line, sentence, condition);
}

std::atomic<AssertionHandler> handler_now{print_assertion};

}  // namespace

AssertionHandler set_assertion_handler(AssertionHandler handler) {
  return handler_now.exchange(handler ? handler : print_assertion);
}

void fail_assertion(const char* file, int line, const char* sentence, const char* condition) {
  handler_now.load()(file, line, sentence, condition);
  std::abort();
}

}  // namespace turgor
