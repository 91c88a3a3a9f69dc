// Blades divide a body into the number of components that their geometry implies.
#include <numbers>

#include <gtest/gtest.h>

#include "tests/models/lattice/block_body.hpp"
#include "tests/models/lattice/counted_elements.hpp"
#include "tests/models/lattice/ct_body.hpp"
#include "turgor/models/lattice/cutting/incision.hpp"
#include "turgor/models/lattice/lattice.hpp"

namespace turgor::lattice {
namespace {

/// A block of 96 × 80 × 24 mm under skin, fixed at its bottom.
Model block_of(double step) {
  const Int3 size{int(std::lround(0.096 / step)) + 1, int(std::lround(0.08 / step)) + 1,
                  int(std::lround(0.024 / step)) + 1};
  Block block{.size = size, .spacing = step, .is_fixed = [](Int3 p) { return p.z == 0; }};
  Params params;
  params.tissue.volume = 1;
  return block_model(block, params);
}

struct Blade {
  std::vector<Vec3d> path;  // on the skin, x and y [m]
  double depth, tilt = 0;
};

void cut(const Model& model, State& state, const Blade& blade, int index) {
  Incision incision{
      .name = "blade", .from = {}, .to = {}, .path = blade.path, .depth = blade.depth, .tilt = blade.tilt};
  for (Vec3d& p : incision.path)
    p.z = (model.anatomy.lattice.size.z - 2) * double(model.anatomy.lattice.spacing.z);
  if (incision.path.size() == 2)
    incision.from = incision.path[0], incision.to = incision.path[1], incision.path.clear();
  const Result<BladePath> path = lay_blade(model, state, incision);
  ASSERT_TRUE(path) << path.error().message;
  // In increments, as by a moving blade.
  for (const double begin : {0.0, 0.25, 0.6})
    cut_edges(model, state, *path, begin, begin == 0 ? 0.25 : begin < 0.5 ? 0.6 : 1, index);
}

std::vector<Vec3d> ellipse(Vec3d middle, double a, double b, double rotation) {
  std::vector<Vec3d> points;
  for (int n = 0; n <= 12; n++) {  // clockwise from above
    const double w = -2 * std::numbers::pi * (n % 12) / 12, x = a * std::cos(w), y = b * std::sin(w);
    points.push_back(middle + Vec3d{x * std::cos(rotation) - y * std::sin(rotation),
                                    x * std::sin(rotation) + y * std::cos(rotation), 0});
  }
  return points;
}

constexpr double kDeep = 0.03;  // deeper than the block [m]

struct Pattern {
  const char* name;
  std::vector<Blade> blades;
  int components;
};

std::vector<Pattern> patterns() {
  const Vec3d m{0.0481, 0.0397, 0};
  const auto line = [&](double x0, double y0, double x1, double y1, double depth, double tilt = 0) {
    return Blade{{m + Vec3d{x0, y0, 0}, m + Vec3d{x1, y1, 0}}, depth, tilt};
  };
  return {
      {"a T", {line(-0.025, 0.003, 0.025, 0.003, 0.01), line(0.002, -0.025, 0.002, 0.003, 0.01)}, 1},
      {"an X", {line(-0.025, -0.02, 0.025, 0.02, 0.01), line(-0.025, 0.02, 0.025, -0.02, 0.01)}, 1},
      {"a T through the block",
       {line(-0.0481, 0.0031, 0.0479, 0.0031, kDeep), line(0.0013, -0.0397, 0.0013, 0.0031, kDeep)},
       3},
      {"an X through the block",
       {line(-0.0481, -0.03, 0.0479, 0.03, kDeep), line(-0.0481, 0.03, 0.0479, -0.03, kDeep)},
       4},
      {"an oblique one through the block", {line(-0.0481, -0.011, 0.0479, -0.011, kDeep, 35)}, 2},
      {"an ellipse", {{ellipse(m, 0.02, 0.012, 0.4), 0.01, 0}}, 1},
      {"an ellipse and a cut below it",
       {{ellipse(m, 0.02, 0.012, 0.4), 0.015, 0}, line(0.03, -0.026, -0.03, -0.026, 0.014, 72)},
       2},
      {"an S",
       {{{m + Vec3d{-0.03, -0.01, 0}, m + Vec3d{-0.015, 0.012, 0}, m, m + Vec3d{0.015, -0.012, 0},
          m + Vec3d{0.03, 0.01, 0}},
         0.01,
         0}},
       1},
  };
}

// Blades leave the number of components that their geometry implies, at once and when wounds gape.
TEST(Fragments, ComponentCountMatchesGeometry) {
  for (const double size : {0.004, 0.0032})
    for (const Pattern& pattern : patterns())
      for (const bool gaping : {false, true}) {
        const Model model = block_of(size);
        State state = make_state(model);
        for (std::size_t n = 0; n < pattern.blades.size(); n++) {
          cut(model, state, pattern.blades[n], int(n));
          const bool ends_inside =
              pattern.blades[n].depth < kDeep;  // otherwise motion would reach beyond the blade's ends
          for (int frame = 0; gaping && ends_inside && frame < 6; frame++)
            step(Exec(2), model, state, {}, 1.0 / 60);
        }
        const std::string scene = std::string(pattern.name) + (gaping ? ", gaping" : "");
        EXPECT_EQ(components_of_nodes(model, state), pattern.components) << scene << ", nodes, step " << size;
        EXPECT_EQ(components_of_fragments(model, state), pattern.components)
            << scene << ", fragments, step " << size;
        EXPECT_EQ(components_of_surface(model, state), pattern.components)
            << scene << ", surface, step " << size;
      }
}

}  // namespace
}  // namespace turgor::lattice
