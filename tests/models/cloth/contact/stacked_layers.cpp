// Layers of cloth that fall on a table and on each other, with different meshes, turned against each other.
#include "tests/models/cloth/stack.hpp"
#include "turgor/models/cloth/contact/contact.hpp"

namespace turgor::cloth {
namespace {

constexpr double kStackGap = 0.008;  // [m]
constexpr int kStackSide = 6;        // vertices

struct FallingStack : Stack {
  std::vector<int> layer = {};  // of each vertex of the model
};
FallingStack falling_stack(int layers) {
  FallingStack stack{make_stack(layers, kStackSide, kStackGap, Method::kTwoLevel)};
  constexpr int kVertices = kStackSide * kStackSide;
  stack.layer.resize(std::size_t(layers * kVertices));
  for (int v = 0; v < layers * kVertices; v++)
    stack.layer[std::size_t(stack.model.model_vertex[std::size_t(v)])] = v / kVertices;
  return stack;
}

/// Mean height of each layer [m].
std::vector<double> layer_heights(const FallingStack& stack) {
  std::vector<double> sum, count;
  for (std::size_t v = 0; v < stack.layer.size(); v++) {
    const auto layer = std::size_t(stack.layer[v]);
    sum.resize(std::max(sum.size(), layer + 1)), count.resize(sum.size());
    sum[layer] += double(stack.state.x.z[v]), count[layer]++;
  }
  for (std::size_t n = 0; n < sum.size(); n++) sum[n] /= count[n];
  return sum;
}

// Layers come to rest in their order, a thickness apart. The table bears the weight of all, no layer sinks
// into it, and no impact zone is needed, however many layers land on each other in a step.
TEST(ClothStack, LayersRestOnEachOther) {
  for (const int layers : {2, 5, 10, 24}) {
    FallingStack stack = falling_stack(layers);
    const int frames = 60 + layers;
    double load = 0, lowest = 1;
    int in_impact_zone = 0;
    for (int n = 0; n < frames; n++) {
      const StepReport report = step(Exec(1), stack.model, stack.state, stack.inputs, kFrame);
      ASSERT_TRUE(report.finite) << layers << " layers, frame " << n;
      in_impact_zone += report.in_impact_zone;
      if (n >= frames - 20) load += obstacle_load(stack.state, 0, {}).impulse.z / kFrame / 20;
      for (int v = 0; v < stack.model.count; v++)
        lowest = std::min(lowest, double(stack.state.x.z[std::size_t(v)]));
    }
    EXPECT_EQ(in_impact_zone, 0) << layers << " layers";
    EXPECT_NEAR(load / (stack.model.total_mass * -9.81), 1, 0.01) << layers << " layers";
    EXPECT_GT(lowest, 0.35 * kStackThickness) << layers << " layers: in the table";
    EXPECT_EQ(self_distance(Exec(1), stack.model, stack.state).crossings, 0) << layers << " layers";
    const std::vector<double> heights = layer_heights(stack);
    for (std::size_t n = 0; n < heights.size(); n++)
      EXPECT_NEAR(heights[n] / kStackThickness, 0.5 + double(n), 0.1 + 0.05 * double(n))
          << "layer " << n << " of " << layers;
  }
}

// The collisions that become contacts are the same with any number of threads.
TEST(ClothStack, SameBitsOnAnyThreads) {
  std::vector<Vectors> ends;
  for (const int threads : {1, 2, 8}) {
    FallingStack stack = falling_stack(12);
    for (int n = 0; n < 15; n++) step(Exec(threads), stack.model, stack.state, stack.inputs, kFrame);
    ends.push_back(stack.state.x);
  }
  for (std::size_t v = 0; v < ends[0].size(); v++) {
    EXPECT_EQ(ends[0][v], ends[1][v]) << v;
    EXPECT_EQ(ends[0][v], ends[2][v]) << v;
  }
}

}  // namespace
}  // namespace turgor::cloth
