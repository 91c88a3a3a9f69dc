// Blades that meet at a point, and blades that end apart.
#include <cmath>
#include <list>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/models/lattice/block_body.hpp"
#include "tests/models/lattice/counted_elements.hpp"
#include "turgor/models/lattice/cutting/incision.hpp"
#include "turgor/models/lattice/lattice.hpp"

namespace turgor::lattice {
namespace {

constexpr double kDeep = 0.03;  // deeper than the block [m]

/// A block of 64 × 64 × 16 mm under skin, fixed at its bottom.
Model block_of(double step) {
  const Int3 size{int(std::lround(0.064 / step)) + 1, int(std::lround(0.064 / step)) + 1,
                  int(std::lround(0.016 / step)) + 1};
  Params params;
  params.tissue.law = TissueLaw::kSolid, params.tissue.poisson = 0.45;
  return block_model({.size = size, .spacing = step, .is_fixed = [](Int3 p) { return p.z == 0; }}, params);
}

/// Incisions and their blade paths, with stable addresses.
struct Laid {
  std::list<Incision> drawn;
  std::list<BladePath> paths;
};

void cut(const Model& model, State& state, std::vector<Vec3d> points, Laid& laid) {
  for (Vec3d& p : points) p.z = (model.anatomy.lattice.size.z - 2) * double(model.anatomy.lattice.spacing.z);
  Incision incision{.name = "blade", .from = {}, .to = {}, .path = points, .depth = kDeep};
  if (points.size() == 2) incision.from = points[0], incision.to = points[1], incision.path.clear();
  std::vector<LaidBlade> before;
  for (auto [d, p] = std::pair(laid.drawn.begin(), laid.paths.begin()); p != laid.paths.end(); ++d, ++p)
    before.push_back({*d, *p});
  const Result<BladePath> path = lay_blade(model, state, incision, nullptr, before);
  ASSERT_TRUE(path) << path.error().message;
  cut_edges(model, state, *path, 0, 1, int(before.size()));
  laid.drawn.push_back(incision), laid.paths.push_back(*path);
}

/// Blades, each by its points around a center.
struct Drawing {
  const char* name;
  std::vector<std::vector<Vec3d>> blades;
  int components;  // components if all ends meet
};
std::vector<Vec3d> arc(double a, double b, double from, double to) {
  std::vector<Vec3d> points;
  for (int n = 0; n <= 8; n++) {
    const double w = (from + (to - from) * n / 8) * std::numbers::pi;
    points.push_back({a * std::cos(w), b * std::sin(w), 0});
  }
  return points;
}
std::vector<Drawing> drawings() {
  const Vec3d a{-0.019, -0.012, 0}, b{0.021, -0.009, 0}, c{0.003, 0.02, 0}, o{0.001, -0.002, 0};
  const Vec3d tip{0.021, 0.004, 0};
  return {
      {"a triangle", {{a, b}, {b, c}, {c, a}}, 2},
      {"a triangle, one blade reversed", {{a, b}, {c, b}, {c, a}}, 2},
      {"a slender triangle", {{a, b}, {b, tip}, {tip, a}}, 2},
      {"a triangle and a T in it", {{a, b}, {b, c}, {c, a}, {c, (a + b) * 0.5}}, 3},
      {"a Y in a triangle", {{a, b}, {b, c}, {c, a}, {a, o}, {b, o}, {c, o}}, 4},
      {"an ellipse of two arcs", {arc(0.022, 0.012, 0, 1), arc(0.022, 0.012, 1, 2)}, 2},
      {"an ellipse of two opposed arcs", {arc(0.022, 0.012, 0, 1), arc(0.022, 0.012, 2, 1)}, 2},
      {"a lens", {arc(0.022, 0.008, 0, 1), {{-0.022, 0, 0}, {0.022, 0, 0}}}, 2},
  };
}

/// Parameters of a drawing: cell size, rotation in the block, extension of the blade ends in cells, and
/// frames between the cuts.
struct Cutting {
  double step, rotation, extension;
  int frames;
};
void expect_components(const Drawing& drawing, const Cutting& cutting, int components) {
  const double cs = std::cos(cutting.rotation), sn = std::sin(cutting.rotation), h = cutting.step;
  const Vec3d middle = Vec3d{0.032, 0.032, 0} + Vec3d{sn, cs * sn, 0} * (0.4 * h);  // a node if not rotated
  const Model model = block_of(h);
  State state = make_state(model);
  Laid laid;
  for (std::vector<Vec3d> points : drawing.blades) {
    points.front() += normalized(points[0] - points[1]) * (cutting.extension * h);
    points.back() += normalized(points.back() - points[points.size() - 2]) * (cutting.extension * h);
    for (Vec3d& p : points) p = middle + Vec3d{p.x * cs - p.y * sn, p.x * sn + p.y * cs, 0};
    cut(model, state, points, laid);
    for (int frame = 0; frame < cutting.frames; frame++) step(Exec(2), model, state, {}, 1.0 / 60);
  }
  const std::string scene = std::string(drawing.name) + ", step " + std::to_string(h) + ", rotated by " +
                            std::to_string(cutting.rotation) + ", ends extended by " +
                            std::to_string(cutting.extension);
  EXPECT_EQ(components_of_fragments(model, state), components) << scene;
  // At least: a small component may be drawn as a bubble in the fragment that it was merged into.
  EXPECT_GE(components_of_surface(model, state), components) << scene;
}

// Blades that meet at a point leave no bridge while wounds gape.
TEST(MeetingBlades, GapingWoundsLeaveNoBridge) {
  for (const Drawing& drawing : drawings())
    for (const Cutting cutting : {Cutting{0.004, 0.3, 0, 6}, {0.004, 0.9, 0, 6}, {0.003, 1.5, 0, 4}})
      expect_components(drawing, cutting, drawing.components);
}

// Blades that meet or cross by less than a cell leave no bridge and no small component.
TEST(MeetingBlades, SmallOverlapLeavesNoBridge) {
  for (const Drawing& drawing : drawings())
    for (const double extension : {0.0, 0.3})
      for (const Cutting cutting : {Cutting{0.004, 0, extension, 0}, {0.004, 2.1, extension, 0}})
        expect_components(drawing, cutting, drawing.components);
}

// Blades that end apart leave a bridge.
TEST(MeetingBlades, GapLeavesBridge) {
  for (const Drawing& drawing : drawings())
    for (const Cutting cutting : {Cutting{0.004, 0.6, -0.6, 0}, {0.003, 1.8, -0.6, 0}})
      expect_components(drawing, cutting, 1);
}

}  // namespace
}  // namespace turgor::lattice
