#include "turgor/core/gpu.hpp"

#include <array>

#include <gtest/gtest.h>

namespace turgor {
namespace {

// Without a GPU, the error message states what was expected and what was found.
TEST(GpuArrays, OpenGpu_ReportsMissingGpu) {
  const Result<Gpu> gpu = open_gpu();
  if (gpu) GTEST_SKIP() << "found a GPU: " << gpu->name;
  const std::string& message = gpu.error().message;
  EXPECT_NE(message.find("expected"), std::string::npos) << message;
  EXPECT_NE(message.find("found"), std::string::npos) << message;
}

// An index without a GPU is rejected.
TEST(GpuArrays, OpenGpu_RejectsUnknownIndex) { EXPECT_FALSE(open_gpu(1000)); }

// A download returns exactly the uploaded values.
TEST(GpuArrays, DownloadReturnsUploadedValues) {
  if (const Result<Gpu> gpu = open_gpu(); !gpu) GTEST_SKIP() << gpu.error().message;
  const std::array<float, 5> sent{1, 2, 3, 4, 5};
  std::array<float, 5> received{};
  GpuArray<float> array(5);
  ASSERT_TRUE(array.is_allocated());
  array.upload(sent);
  array.download(received);
  EXPECT_EQ(sent, received);
}

}  // namespace
}  // namespace turgor
