#include "turgor/models/cloth/forces/bending.hpp"

#include "tests/models/cloth/meshes.hpp"
#include "tests/models/cloth/sheets.hpp"

namespace turgor::cloth {
namespace {

/// End of a clamped strip by the heavy elastica: θ'' = −(L − s)/c³ cos θ with θ = 0 at the clamp and θ' = 0
/// at the end, c³ = B/(ρ g). Solved by shooting with the Runge-Kutta method.
struct End {
  double reach = 0, drop = 0;  // horizontal distance from the clamp, drop below it [m]
};
End elastica_end(double length, double rigidity, double weight) {
  constexpr int kSteps = 2000;
  const double h = length / kSteps, k = weight / rigidity;
  struct Point {
    double angle, bend, drop, reach;
  };
  const auto slope = [&](double s, Point p) {
    return Point{p.bend, -k * (length - s) * std::cos(p.angle), std::sin(p.angle), std::cos(p.angle)};
  };
  const auto shot = [&](double bend) {
    Point p{0, bend, 0, 0};
    for (int n = 0; n < kSteps; n++) {
      const double s = n * h;
      const auto to = [&](Point d, double f) {
        return Point{p.angle + f * d.angle, p.bend + f * d.bend, p.drop + f * d.drop, p.reach + f * d.reach};
      };
      const Point a = slope(s, p), b = slope(s + h / 2, to(a, h / 2)), c = slope(s + h / 2, to(b, h / 2)),
                  d = slope(s + h, to(c, h));
      p = {p.angle + h / 6 * (a.angle + 2 * b.angle + 2 * c.angle + d.angle),
           p.bend + h / 6 * (a.bend + 2 * b.bend + 2 * c.bend + d.bend),
           p.drop + h / 6 * (a.drop + 2 * b.drop + 2 * c.drop + d.drop),
           p.reach + h / 6 * (a.reach + 2 * b.reach + 2 * c.reach + d.reach)};
    }
    return p;
  };
  double low = 0, high = k * length * length;
  for (int n = 0; n < 60; n++) (shot((low + high) / 2).bend < 0 ? low : high) = (low + high) / 2;
  const Point end = shot((low + high) / 2);
  return {end.reach, end.drop};
}

double elastica_drop(double length, double rigidity, double weight) {  // in multiples of the length
  return elastica_end(length, rigidity, weight).drop / length;
}

double elastica_angle(double length, double rigidity, double weight) {  // from the clamp to the end [°]
  const End end = elastica_end(length, rigidity, weight);
  return std::atan2(end.drop, end.reach) * 180 / 3.14159265358979;
}

// The reference elastica has the deflection w L⁴ / 8B of a cantilever plate for small angles.
TEST(ClothBending, ReferenceMatchesSmallDeflection) {
  EXPECT_NEAR(elastica_drop(0.1, 1, 1e-2), 1e-2 * 1e-3 / 8, 1e-9);  // w L⁴/8B
}

// Where the warp is normal to the cloth, the weaves of two triangles are opposite. With equal rigidities
// their fold resists as for any other warp.
TEST(ClothBending, OppositeWeavesBendAlike) {
  const TriMesh fold{.vertices = {{0, 0, 0}, {0, 0, 1}, {0.1f, 1, 0.4f}, {0.1f, -1, 0.4f}},
                     .triangles = {{0, 2, 1}, {0, 1, 3}}};
  const std::vector<char> no_slivers(2, 0);
  Fabric across{.law = Law::kSheet}, along{.law = Law::kSheet};
  across.direction = {1, 0, 0}, along.direction = {0, 1, 0};
  const std::vector<Spring> found = bending_weights(fold, across, no_slivers),
                            expected = bending_weights(fold, along, no_slivers);
  ASSERT_EQ(found.size(), expected.size());
  ASSERT_FALSE(found.empty());
  for (std::size_t n = 0; n < found.size(); n++)
    EXPECT_NEAR(found[n].bend, expected[n].bend, 1e-6 * std::abs(expected[n].bend)) << n;
}

// The reference elastica satisfies Peirce's formula.
TEST(ClothBending, ReferenceMatchesPeirce) {
  // For an angle of 41.5° from the clamp to the end, c is half the length: c³ ρ g = B.
  const double length = 0.1, c = 0.05;
  EXPECT_NEAR(elastica_angle(length, 1, 1 / (c * c * c)), 41.5, 0.5);
}

struct Strip {
  Pattern pattern;
  double size;      // of cells [m]
  double rigidity;  // [N·m]
  double length;    // beyond the clamp [m]
  double height = 0.02;
  bool along_weft = false;
};

/// Drop at rest of the end of a strip that is clamped at one end, in multiples of its length. The clamp holds
/// two columns of vertices, so it ends halfway between them.
double simulated_drop(const Strip& strip) {
  Params params{.fabric = {.law = Law::kSheet, .density = 0.2, .warp = 2000, .weft = 2000, .shear = 400}};
  (strip.along_weft ? params.fabric.rigidity_weft : params.fabric.rigidity_warp) = strip.rigidity;
  (strip.along_weft ? params.fabric.rigidity_warp : params.fabric.rigidity_weft) = 5 * strip.rigidity;
  if (strip.along_weft) params.fabric.direction = {0, 1, 0};
  params.damping = {10, 0};
  params.solver = {.method = Method::kConjugateGradients, .sweeps = 200};
  params.collision.self = false;
  const double cell = strip.pattern == Pattern::kTall ? strip.size / 4 : strip.size;
  const TriMesh mesh = rectangle(strip.pattern, -cell / 2, strip.length, strip.height, strip.size);
  const Model model = must_build(mesh, params);
  State state = make_state(model);
  for (const int v : vertices_between(mesh, -1, 0.6 * cell)) EXPECT_TRUE(hold(model, state, v));
  for (int n = 0; n < 200; n++) step(Exec(1), model, state, in_vacuum(), kFrame);
  double sum = 0;
  const std::vector<int> end = vertices_between(mesh, strip.length - 1e-6, 1);
  for (const int v : end) sum -= double(state.x.z[std::size_t(model.model_vertex[std::size_t(v)])]);
  return sum / double(end.size()) / strip.length;
}

// A strip over an edge hangs as Peirce's cantilever on any mesh.
TEST(ClothBending, StripMatchesPeirceCantilever) {
  const double weight = 0.2 * 9.81;
  for (const Pattern pattern : kPatterns)
    for (const double cells : {12.5, 20.5})
      for (const double c : {0.015, 0.02}) {  // [m]
        const double rigidity = weight * c * c * c, length = 0.06;
        const double expected = elastica_drop(length, rigidity, weight);
        EXPECT_NEAR(simulated_drop({pattern, length / cells, rigidity, length}) / expected, 1, 0.05)
            << name(pattern) << ", " << cells << " cells, c = " << c;
      }
}

// Warp and weft bend with their own rigidity.
TEST(ClothBending, WarpAndWeftRigidity) {
  const double weight = 0.2 * 9.81, rigidity = weight * 0.02 * 0.02 * 0.02, length = 0.06;
  for (const Pattern pattern : {Pattern::kDiagonal, Pattern::kRandom, Pattern::kEquilateral})
    EXPECT_NEAR(simulated_drop({pattern, length / 20.5, rigidity, length, 0.02, true}) /
                    elastica_drop(length, rigidity, weight),
                1, 0.05)
        << name(pattern);
}

// A sheet with a constant curvature has a constant moment on every mesh, so that vertices inside it have no
// force [patch test: Irons].
TEST(ClothBending, ConstantCurvatureIsInBalance) {
  constexpr double kLength = 0.1, kHeight = 0.08, kCell = 0.005, kRim = 0.0151;  // [m]
  for (const Pattern pattern : kPatterns) {
    const TriMesh mesh = rectangle(pattern, 0, kLength, kHeight, kCell);
    Fabric fabric{.law = Law::kSheet, .rigidity_warp = 1e-5, .rigidity_weft = 3e-5};
    const std::vector<char> no_slivers(mesh.triangles.size(), 0);
    const std::vector<Spring> springs = bending_weights(mesh, fabric, no_slivers);
    for (const Vec3d curvature : {Vec3d{1, 0, 0}, {0, 1, 0}, {0.5, 0.5, 1}}) {  // xx, yy, xy [1/m]
      const auto height = [&](int v) {
        const Vec3d x(mesh.vertices[std::size_t(v)]);
        return (curvature.x * x.x * x.x + curvature.y * x.y * x.y) / 2 + curvature.z * x.x * x.y;
      };
      std::vector<double> force(mesh.vertices.size(), 0), sizes(mesh.vertices.size(), 0);
      for (const Spring& s : springs) {
        const double f = double(s.bend) * (height(s.b) - height(s.a));
        force[std::size_t(s.a)] += f, force[std::size_t(s.b)] -= f;
        sizes[std::size_t(s.a)] += std::abs(f), sizes[std::size_t(s.b)] += std::abs(f);
      }
      double square = 0, size_square = 0;
      for (std::size_t v = 0; v < force.size(); v++) {
        const Vec3d x(mesh.vertices[v]);
        if (std::min({x.x, x.y, kLength - x.x, kHeight - x.y}) < kRim) continue;
        square += force[v] * force[v], size_square += sizes[v] * sizes[v];
      }
      ASSERT_GT(size_square, 0);
      EXPECT_LT(std::sqrt(square / size_square), 0.0028) << name(pattern);
    }
  }
}

// Rigid motion has no bending energy; twice the curvature has four times the energy.
TEST(ClothBending, EnergyIsQuadraticInCurvature) {
  for (const Pattern pattern : kPatterns) {
    Params params{.fabric = {.law = Law::kSheet,
                             .warp = 1e-6,
                             .weft = 1e-6,
                             .shear = 1e-6,
                             .rigidity_warp = 1e-3,
                             .rigidity_weft = 1e-3}};
    params.collision.self = false;
    const Model model = must_build(rectangle(pattern, 0, 0.1, 0.04, 0.005), params);
    const auto bent = [&](double curvature) {
      State state = make_state(model);
      for (std::size_t v = 0; v < std::size_t(model.count); v++) {
        const Vec3d x(model.x_rest[v]);
        const double angle = curvature * x.x;
        const Vec3d rolled =
            curvature > 0 ? Vec3d{std::sin(angle) / curvature, x.y, (1 - std::cos(angle)) / curvature} : x;
        state.x.set(v, Vec3(Vec3d{rolled.z, rolled.x, rolled.y + 0.1}));
      }
      return energy(model, state, {}).elastic;
    };
    EXPECT_LT(bent(0), 1e-8) << name(pattern);
    EXPECT_NEAR(bent(10) / bent(5), 4, 0.02) << name(pattern);
    EXPECT_NEAR(bent(5) / (1e-3 * 25 / 2 * 0.1 * 0.04), 1, 0.08)
        << name(pattern);  // the ends bend half as much
  }
}

}  // namespace
}  // namespace turgor::cloth
