#include "turgor/io/files/base64.hpp"

#include <gtest/gtest.h>

namespace turgor {
namespace {

// The encoder reproduces the examples of RFC 4648.
TEST(Base64, MatchesRfc4648Examples) {  // RFC 4648, section 10
  const std::pair<const char*, const char*> kExamples[] = {{"", ""},
                                                           {"f", "Zg=="},
                                                           {"fo", "Zm8="},
                                                           {"foo", "Zm9v"},
                                                           {"foob", "Zm9vYg=="},
                                                           {"fooba", "Zm9vYmE="},
                                                           {"foobar", "Zm9vYmFy"}};
  for (const auto& [bytes, text] : kExamples) EXPECT_EQ(io::base64(bytes), text);
}

}  // namespace
}  // namespace turgor
