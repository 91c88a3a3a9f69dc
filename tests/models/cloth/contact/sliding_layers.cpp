// Layers that slide on each other as Coulomb's law predicts, on meshes that are not aligned.
#include "tests/models/cloth/meshes.hpp"
#include "tests/models/cloth/sheets.hpp"
#include "turgor/models/cloth/build/large.hpp"
#include "turgor/models/cloth/contact/contact_kernels.hpp"

namespace turgor::cloth {
namespace {

constexpr double kSlope = 3.14159265358979 / 4;  // of the held sheet [rad]

struct Slide {
  Pattern lower, upper;
  double thickness, friction;  // [m], Coulomb's coefficient
  Method method = Method::kTwoLevel;
};

/// A held sheet and a smaller one on it. At rest they are apart, so that they count as two layers.
struct Layers {
  Model model;
  State state;
  std::vector<std::size_t> upper;  // vertices of the upper sheet
};
Layers layers(const Slide& slide) {
  TriMesh mesh = rectangle(slide.lower, 0, 0.42, 0.1, 0.0061);
  const int held = int(mesh.vertices.size());
  const TriMesh other = rectangle(slide.upper, 0.0213, 0.0813, 0.055, 0.006);
  for (const Vec3 x : other.vertices) mesh.vertices.push_back(x + Vec3{0, 0.021f, 0.05f});
  for (const Int3 t : other.triangles) mesh.triangles.push_back(t + Int3{held, held, held});
  Params params{.fabric = {.law = Law::kSheet}, .solver = {.method = slide.method}};
  if (slide.method == Method::kTwoLevel) params.solver.sweeps = 200;
  params.damping.motion = 0;
  params.collision.thickness = slide.thickness, params.collision.friction = slide.friction;
  Layers result{.model = must_build(mesh, params), .state = {}, .upper = {}};
  result.state = make_state(result.model);
  for (int v = 0; v < int(mesh.vertices.size()); v++) {
    if (v < held) {
      EXPECT_TRUE(hold(result.model, result.state, v));
      continue;
    }
    result.upper.push_back(std::size_t(result.model.model_vertex[std::size_t(v)]));
    result.state.x.z[result.upper.back()] = Real(1.02 * slide.thickness);
  }
  return result;
}

/// Mean velocity of the upper sheet down the slope [m/s].
double speed(const Layers& layers) {
  double momentum = 0, mass = 0;
  for (const std::size_t v : layers.upper)
    mass += double(layers.model.mass[v]),
        momentum += double(layers.model.mass[v]) * double(layers.state.v.x[v]);
  return momentum / mass;
}

/// Acceleration of the upper sheet between frames 6 and 18, by that of Coulomb's law.
double relative_acceleration(const Slide& slide) {
  constexpr int kSettled = 6, kEnd = 18;
  Layers sheets = layers(slide);
  Inputs inputs = in_vacuum();
  inputs.gravity = Vec3d{std::sin(kSlope), 0, -std::cos(kSlope)} * 9.81;
  double before = 0;
  for (int n = 1; n <= kEnd; n++) {
    EXPECT_TRUE(step(Exec(2), sheets.model, sheets.state, inputs, kFrame).finite);
    if (n == kSettled) before = speed(sheets);
  }
  EXPECT_EQ(self_distance(Exec(2), sheets.model, sheets.state).crossings, 0);
  double lowest = 1, highest = 0;
  for (const std::size_t v : sheets.upper)
    lowest = std::min(lowest, double(sheets.state.x.z[v])),
    highest = std::max(highest, double(sheets.state.x.z[v]));
  if (slide.method == Method::kTwoLevel) {  // sweeps carry fast layers less well
    EXPECT_GT(lowest, 0.9 * slide.thickness) << "m above the held sheet";
    EXPECT_LT(highest, slide.thickness + 0.003) << "the layer stays flat";
  }
  const double expected = 9.81 * (std::sin(kSlope) - slide.friction * std::cos(kSlope));
  return (speed(sheets) - before) / ((kEnd - kSettled) * kFrame) / expected;
}

/// Mean of five slides whose thickness differs by 0.001 %. Friction on random triangles amplifies roundings:
/// single slides differ by 3 % (standard deviation) from their mean of 0.90.
double mean_acceleration(Slide slide) {
  const double thickness = slide.thickness;
  double sum = 0;
  for (int n = -2; n <= 2; n++) {
    slide.thickness = thickness * (1 + 1e-5 * n);
    sum += relative_acceleration(slide);
  }
  return sum / 5;
}

// A layer slides down a held one with Coulomb's acceleration, at any thickness and on any mesh.
TEST(ClothSlidingLayers, FollowCoulomb) {
  for (const auto& [lower, upper, thickness] :
       {std::tuple{Pattern::kDiagonal, Pattern::kRandom, 0.001},
        std::tuple{Pattern::kRandom, Pattern::kEquilateral, 0.0032}}) {
    const std::string what = name(upper) + " on " + name(lower);
    EXPECT_NEAR(relative_acceleration({lower, upper, thickness, 0}), 1, 0.1) << what;
    EXPECT_NEAR(mean_acceleration({lower, upper, thickness, 0.3}), 1, 0.15) << what;
  }
}

// The same with sweeps, whose contacts follow the solution.
TEST(ClothSlidingLayers, FollowCoulombWithSweeps) {
  constexpr Method kSweeps = Method::kChebyshev;
  EXPECT_NEAR(relative_acceleration({Pattern::kDiagonal, Pattern::kRandom, 0.0032, 0, kSweeps}), 1, 0.1);
  EXPECT_NEAR(relative_acceleration({Pattern::kRandom, Pattern::kEquilateral, 0.002, 0.3, kSweeps}), 1, 0.15);
}

/// Two triangles that are folded at their common edge 0 1 by `fold` [rad]: the corners 2 and 3 sink.
TriMesh ridge(double fold) {
  const float c = float(std::cos(fold)), s = float(std::sin(fold));
  return {.vertices = {{0, -1, 0}, {0, 1, 0}, {-c, 0, -s}, {c, 0, -s}}, .triangles = {{0, 1, 2}, {1, 0, 3}}};
}

// The normal cone of an edge holds the directions between the normals of its triangles.
TEST(ClothNormalCones, EdgeHasDirectionsBetweenNormals) {
  for (const double fold : {0.0, 0.1, 0.7}) {
    const TriMesh mesh = ridge(fold);
    Vectors x;
    x.resize(16);
    for (std::size_t v = 0; v < 4; v++) x.set(v, mesh.vertices[v]);
    const LargePrimitives large = find_large_primitives(mesh, {}, 0.1);
    ASSERT_EQ(large.edges.size(), 5u);
    EXPECT_EQ(large.edges[0], (std::array<int, 2>{0, 1}));
    EXPECT_EQ(large.facing[0], (std::array<int, 2>{2, 3}));
    EXPECT_EQ(large.across[0], (Int3{-1, -1, 3}));
    const ConesView cones{view(std::as_const(x)), large.stars.begin.data(), large.stars.item.data()};
    for (double angle = -3.1; angle < 3.1; angle += 0.04) {
      const Vec3 direction(Vec3d{std::sin(angle), 0, std::cos(angle)});
      if (std::abs(std::abs(angle) - fold) < 0.01) continue;
      bool has = true;
      for (const int corner : large.facing[0])
        has = has && cones.edge_has({}, {0, 2, 0}, corner, direction, kConeMargin);
      EXPECT_EQ(has, std::abs(angle) < fold) << angle << " of " << fold;
      EXPECT_TRUE(cones.edge_has({}, {0, 2, 0}, -1, direction, kConeMargin)) << "no triangle";
    }
  }
}

// A vertex has the directions from which it is nearest; the projection of another one is among them.
TEST(ClothNormalCones, VertexHasWhereItIsNearest) {
  const Model model = must_build(flat_sheet(5), {.collision = {.thickness = 0.004}});
  State state = make_state(model);
  const auto top = std::size_t(model.model_vertex[12]);
  for (const double height : {0.0, 0.003, 0.02, -0.01}) {
    state.x.z[top] = Real(height);
    const ConesView cones = cones_view(model, state);
    RandomNumbers next{3};
    for (int n = 0; n < 200; n++) {
      const double dx = next(), dy = next(), dz = next();
      const Vec3d direction = normalized(Vec3d{dx, dy, dz});
      // no neighbor is nearer to a point far away in this direction
      double steepest = -1;
      for (int v = 0; v < model.count; v++)
        if (const Vec3d side(state.x[std::size_t(v)] - state.x[top]);
            std::size_t(v) != top && norm(side) < 0.026)
          steepest = std::max(steepest, dot(direction, normalized(side)));
      const Vec3 wanted(direction);
      if (std::abs(steepest) < 0.01) continue;
      if (steepest < 0) {
        EXPECT_TRUE(cones.vertex_has(int(top), wanted)) << height;
      }
      if (height == 0 && !cones.vertex_has(int(top), wanted)) {
        const Vec3 projected = cones.projected(int(top), wanted);
        EXPECT_LT(std::hypot(projected.x, projected.y), 1e-5f) << "a flat sheet has its normal";
        EXPECT_NEAR(projected.z, wanted.z, 1e-5f);
      }
    }
    EXPECT_EQ(cones.vertex_has(int(top), {0, 0, 1}), height >= 0);
    EXPECT_EQ(cones.vertex_has(int(top), {0, 0, -1}), height <= 0);
  }
}

}  // namespace
}  // namespace turgor::cloth
