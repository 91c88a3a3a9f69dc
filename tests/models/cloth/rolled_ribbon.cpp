// A ribbon rolled up by its ends is a circular arc: there the curvature is uniform, so no force acts on the
// ends and both feel the moment B κ.
#include "tests/models/cloth/meshes.hpp"
#include "tests/models/cloth/sheets.hpp"

namespace turgor::cloth {
namespace {

constexpr double kRibbonLength = 0.12, kRibbonWidth = 0.02, kRigidity = 2e-5;  // [m], [m], [N·m]

/// Position of the point s, y of the ribbon on an arc that turns by `turn` in all.
Vec3d on_arc(double s, double y, double turn) {
  const double curvature = turn / kRibbonLength, angle = curvature * s;
  return {std::sin(angle) / curvature, y, (1 - std::cos(angle)) / curvature};
}

/// A ribbon whose clamped ends were turned toward each other by `turn` in four seconds and then rested.
struct Rolled {
  TriMesh mesh;
  Model model;
  State state;
};
Rolled roll_up(Pattern pattern, double size, double turn) {
  Params params = {.fabric = {.law = Law::kSheet,
                              .density = 0.2,
                              .warp = 2000,
                              .weft = 2000,
                              .shear = 400,
                              .rigidity_warp = kRigidity,
                              .rigidity_weft = kRigidity}};
  params.damping = {10, 0};
  params.solver = {.method = Method::kTwoLevel, .sweeps = 400, .tolerance = 1e-4};
  params.collision.self = false;
  Rolled ribbon{rectangle(pattern, 0, kRibbonLength, kRibbonWidth, size), {}, {}};
  ribbon.model = must_build(ribbon.mesh, params);
  ribbon.state = make_state(ribbon.model);
  // two columns at each end are clamped; the ends move along the arcs of growing curvature
  const double column = pattern == Pattern::kTall ? size / 4 : size;
  std::vector<int> clamped = vertices_between(ribbon.mesh, -1, 1.1 * column);
  for (const int v : vertices_between(ribbon.mesh, kRibbonLength - 1.1 * column, 1)) clamped.push_back(v);
  for (const int v : clamped) EXPECT_TRUE(hold(ribbon.model, ribbon.state, v));
  for (int n = 1; n <= 300; n++) {
    const double now = turn * std::min(1.0, n / 240.0);
    for (const int v : clamped) {
      const Vec3d rest(ribbon.mesh.vertices[std::size_t(v)]);
      EXPECT_TRUE(move_hold(ribbon.model, ribbon.state, v, Vec3(on_arc(rest.x, rest.y, now))));
    }
    step(Exec(1), ribbon.model, ribbon.state, in_vacuum(0), kFrame);
  }
  return ribbon;
}

// Energy and shape of a ribbon rolled up by three quarters of a circle, on every mesh. The energy is a little
// small because hinges at the ends bend half as much.
TEST(ClothRibbon, RollsUpToAnArc) {
  const double turn = 1.5 * 3.14159265358979, curvature = turn / kRibbonLength;
  const double energy_of_arc = kRigidity / 2 * curvature * curvature * kRibbonLength * kRibbonWidth;
  for (const Pattern pattern : kPatterns) {
    if (pattern == Pattern::kEquilateral) continue;  // its ends are not straight
    const Rolled ribbon = roll_up(pattern, 0.006, turn);
    EXPECT_NEAR(energy(ribbon.model, ribbon.state, {}).elastic / energy_of_arc, 1, 0.03) << name(pattern);
    double farthest = 0;
    for (std::size_t v = 0; v < ribbon.mesh.vertices.size(); v++) {
      const Vec3d rest(ribbon.mesh.vertices[v]), x(ribbon.state.x[std::size_t(ribbon.model.model_vertex[v])]);
      farthest = std::max(farthest, norm(x - on_arc(rest.x, rest.y, turn)));
    }
    EXPECT_LT(farthest, 0.02 / curvature) << name(pattern);
  }
}

}  // namespace
}  // namespace turgor::cloth
