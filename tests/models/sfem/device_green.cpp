// The store of Green's functions by the kernels of the device, run on the CPU.
#include "turgor/models/sfem/device_green.hpp"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "tests/models/host_backend.hpp"
#include "tests/models/sfem/bodies.hpp"
#include "turgor/models/sfem/gpu_green.hpp"

namespace turgor::sfem {
namespace {

using lattice::HostBackend;
using lattice::SeededRun;
using lattice::ThreadedRun;

/// A distorted block, clamped on its side; the store has only some of its nodes.
Model distorted_block(int corners, Precision precision) {
  const Vec3d size{0.14, 0.1, 0.08};
  SolidMesh mesh = with_corners(hex_block(size, {7, 5, 5}), corners);
  distort(mesh, size, 0.002);
  Body body = block_of(std::move(mesh), {4e3, 0.4}, [](Vec3d x) { return x.x < 1e-9; });
  Model model = build(Exec(1), std::move(body), {.precision = precision, .touch_depth = 0}).value();
  EXPECT_LT(model.green.nodes.size(), model.vertex.size());
  EXPECT_TRUE(compute_green(Exec(2), model, std::size_t(2) << 30));
  return model;
}

template <class Run, class T>
std::vector<T> store_of(const Model& model, std::size_t together) {
  DeviceAllocator<HostBackend<Run>> allocator;
  DeviceGreen<HostBackend<Run>, T> device(model, allocator, together);
  std::vector<T> values(9 * model.green.nodes.size() * model.green.nodes.size());
  device.fill(values, {});
  return values;
}

template <class T>
double relative_difference(const std::vector<T>& a, const std::vector<T>& b) {
  double most = 0, largest = 0;
  for (std::size_t i = 0; i < a.size(); i++) {
    most = std::max(most, std::abs(double(a[i]) - double(b[i])));
    largest = std::max(largest, std::abs(double(b[i])));
  }
  return most / largest;
}

// Columns by the device kernels match those of the factor.
TEST(DeviceGreen, ColumnsMatchFactor) {
  for (const int corners : {4, 8}) {
    const Model model = distorted_block(corners, Precision::kDouble);
    for (const std::size_t together : {std::size_t(7), std::size_t(50), std::size_t(1024)}) {
      const std::vector<double> found = store_of<SeededRun<1>, double>(model, together);
      EXPECT_LT(relative_difference(found, model.green.double_values), 1e-12)
          << corners << " corners, " << together;
    }
    const Model single = distorted_block(corners, Precision::kSingle);
    const std::vector<float> found = store_of<SeededRun<1>, float>(single, 50);
    EXPECT_LT(relative_difference(found, single.green.single_values), 1e-7) << corners << " corners";
  }
}

// The store is symmetric and has the same bits in any order and on any number of threads.
TEST(DeviceGreen, SymmetricWithEqualBitsInAnyOrder) {
  const Model model = distorted_block(4, Precision::kSingle);
  const std::vector<float> store = store_of<SeededRun<1>, float>(model, 40);
  const std::size_t side = 3 * model.green.nodes.size();
  for (std::size_t r = 0; r < side; r++)
    for (std::size_t c = 0; c < r; c++) ASSERT_EQ(store[c * side + r], store[r * side + c]) << r << ", " << c;
  EXPECT_EQ(store, (store_of<SeededRun<2>, float>(model, 40)));
  EXPECT_EQ(store, (store_of<ThreadedRun<1>, float>(model, 40)));
  EXPECT_EQ(store, (store_of<ThreadedRun<2>, float>(model, 40)));
  EXPECT_EQ(store, (store_of<ThreadedRun<8>, float>(model, 40)));
}

// Green's functions of the GPU match those of the CPU.
TEST(GpuSfem, GreensFunctionsMatchCpu) {
  const Result<Gpu> gpu = open_gpu();
  if (!gpu) GTEST_SKIP() << gpu.error().message;
  for (const Precision precision : {Precision::kSingle, Precision::kDouble}) {
    Model model = distorted_block(8, precision);
    const Green host = model.green;
    ASSERT_TRUE(compute_green(Exec(2), model, std::size_t(2) << 30, {}, &*gpu));
    if (precision == Precision::kSingle)
      EXPECT_LT(relative_difference(model.green.single_values, host.single_values), 1e-7);
    else
      EXPECT_LT(relative_difference(model.green.double_values, host.double_values), 1e-12);
    EXPECT_TRUE(check_green(model));
  }
}

}  // namespace
}  // namespace turgor::sfem
