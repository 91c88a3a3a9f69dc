#include "turgor/core/gpu.hpp"

#include <array>

#include <gtest/gtest.h>

namespace turgor {
namespace {

TEST(gpu, without_one_a_sentence_says_what_is_missing) {
  const Result<Gpu> gpu = open_gpu();
  if (gpu) GTEST_SKIP() << "there is one, " << gpu->name;
  const std::string& message = gpu.error().message;
  EXPECT_NE(message.find("expected"), std::string::npos) << message;
  EXPECT_NE(message.find("found"), std::string::npos) << message;
}

TEST(gpu, a_number_that_no_gpu_has_is_refused) { EXPECT_FALSE(open_gpu(1000)); }

TEST(gpu, arrays_come_back_as_they_went_over) {
  if (const Result<Gpu> gpu = open_gpu(); !gpu) GTEST_SKIP() << gpu.error().message;
  const std::array<float, 5> there{1, 2, 3, 4, 5};
  std::array<float, 5> back{};
  GpuArray<float> array(5);
  ASSERT_TRUE(array.is_allocated());
  array.upload(there);
  array.download(back);
  EXPECT_EQ(there, back);
}

}  // namespace
}  // namespace turgor
