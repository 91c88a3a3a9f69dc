#include "turgor/models/lattice/build/surroundings.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include <gtest/gtest.h>

#include "turgor/models/lattice/build/body_nodes.hpp"
#include "turgor/models/lattice/cutting/incision.hpp"
#include "turgor/models/lattice/lattice.hpp"
#include "turgor/models/lattice/surface/surface.hpp"

namespace turgor::lattice {
namespace {

const Int3 kSize{240, 200, 60};
constexpr double kSpacing = 1e-3;  // [m]
constexpr double kBack = 120;      // back of the body, voxels along j

/// A CT of 1 mm voxels with tissue where `dense(x, y, z)`.
CtVolume painted(const std::function<bool(double, double, double)>& dense) {
  CtVolume ct{{.size = kSize, .spacing = {kSpacing, kSpacing, kSpacing}, .origin = {}, .axes = {}}, {}};
  for (int k = 0; k < kSize.z; k++)
    for (int j = 0; j < kSize.y; j++)
      for (int i = 0; i < kSize.x; i++) ct.samples.push_back(dense(i, j, k) ? 40 : kAirHu);
  return ct;
}

/// An oval body on its back, flat over 60 mm.
bool in_body(double x, double y) {
  const double u = (x - 120) / 90, v = (y - 70) / 55;
  return u * u + v * v < 1 && y < kBack;
}

BodyNodes nodes_at(const CtVolume& ct, int step) {
  Params params;
  params.block = {step, step, step};
  return classify(Exec(2), ct, nullptr, params).value();
}

/// Number of body nodes at depths [from, to) along j [mm].
std::size_t count_nodes(const BodyNodes& nodes, double from, double to) {
  std::size_t count = 0;
  for (std::size_t n = 0; n < nodes.tissue.size(); n++) {
    const double depth = double(n / std::size_t(nodes.grid.size.x) % std::size_t(nodes.grid.size.y)) *
                         nodes.grid.spacing.y * 1e3;
    count += is_body(nodes.tissue[n]) && depth >= from && depth < to;
  }
  return count;
}

struct Table {
  const char* name;
  double gap, sheet, thickness;  // distance to the back, thickness of the shell, total thickness [mm]
};

class BehindTheBody : public ::testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Surroundings, BehindTheBody, ::testing::Values(3, 6, 8, 10));

// No node lies in a table near the body.
TEST_P(BehindTheBody, NearTableHasNoNodes) {
  const CtVolume alone = painted([](double x, double y, double) { return in_body(x, y); });
  const std::size_t nodes_alone = count_nodes(nodes_at(alone, GetParam()), 0, 1e3);
  for (const Table& table : {Table{"a sheet", 2, 2, 2}, Table{"a box", 2, 2, 25}, Table{"near", 4, 2, 25},
                             Table{"a solid one", 3, 12, 12}}) {
    const auto in_table = [&](double x, double y) {
      const double depth = y - kBack - table.gap;
      const bool inside = depth >= 0 && depth < table.thickness && x > 5 && x < 235;
      return inside && (depth < table.sheet || depth >= table.thickness - table.sheet || x < 7 || x > 233);
    };
    const CtVolume ct = painted([&](double x, double y, double) { return in_body(x, y) || in_table(x, y); });
    const BodyNodes nodes = nodes_at(ct, GetParam());
    EXPECT_EQ(count_nodes(nodes, kBack + table.gap + 0.5 * GetParam(), 1e3), 0u) << table.name;
    const double remaining =
        double(count_nodes(nodes, 0, 1e3));  // some of the rim is removed with a table 2 mm away
    EXPECT_NEAR(remaining, double(nodes_alone), 0.004 * double(nodes_alone)) << table.name;
  }
}

// No node lies in a sheet that touches the body.
TEST_P(BehindTheBody, TouchingSheetHasNoNodes) {
  const CtVolume ct = painted([](double x, double y, double) {
    return in_body(x, y) || (y >= kBack && y < kBack + 2 && x > 5 && x < 235);
  });
  const BodyNodes nodes = nodes_at(ct, GetParam());
  EXPECT_EQ(count_nodes(nodes, kBack + 2, 1e3), 0u);
}

// A light pad that follows the back, and touches it here and there, leaves no ridges behind the body, and the
// back has no pits.
TEST_P(BehindTheBody, PadLeavesNoRidges) {
  const auto pad = [](double x, double y, double z) {
    const double depth = y - kBack - 2 - 2 * std::sin(x / 9) * std::cos(z / 13);
    return depth >= 0 && depth < 6 && x > 5 && x < 235;
  };
  CtVolume ct = painted([](double x, double y, double) { return in_body(x, y); });
  const std::size_t alone = count_nodes(nodes_at(ct, GetParam()), 0, 1e3);
  for (int k = 0; k < kSize.z; k++)
    for (int j = 0; j < kSize.y; j++)
      for (int i = 0; i < kSize.x; i++)
        if (ct.at(i, j, k) < -500 && pad(i, j, k)) ct.at(i, j, k) = -330;
  const BodyNodes nodes = nodes_at(ct, GetParam());
  EXPECT_EQ(count_nodes(nodes, kBack + 3 + 0.5 * GetParam(), 1e3), 0u);
  EXPECT_GE(double(count_nodes(nodes, 0, 1e3)), 0.999 * double(alone));
}

/// Distance of a point beyond the surface of the body; negative inside [mm].
double beyond_body(Vec3d at) {
  const double u = (at.x - 120) / 90, v = (at.y - 70) / 55;
  return std::max(55 * (std::sqrt(u * u + v * v) - 1), at.y - kBack);
}

/// A blurred body on the cover of a mattress: a sheet that lies on its back, and leaves it sideways.
/// `middle`: distance of the sheet's middle from the back [mm]. Voxels are as light as -400 HU, or as dense
/// as fat.
CtVolume body_on_cover(double middle) {
  CtVolume ct = painted([](double, double, double) { return false; });
  for (int k = 0; k < kSize.z; k++)
    for (int j = 0; j < kSize.y; j++)
      for (int i = 0; i < kSize.x; i++) {
        const double body = std::clamp(0.5 - beyond_body({double(i), double(j), double(k)}) / 2, 0.0, 1.0);
        const double cover = i > 5 && i < 235 ? std::max(0.0, 1 - std::abs(j - kBack - middle) / 2) : 0;
        ct.at(i, j, k) = std::int16_t(kAirHu + std::max(1040 * body, 800 * cover));
      }
  return ct;
}

// The drawn skin of a back that lies on the cover of a mattress is that of the body: the cover leaves no
// ledges.
TEST(Surroundings, CoverLeavesNoLedges) {
  const CtVolume ct = body_on_cover(2.5);
  Params params;
  params.block = {6, 6, 6};
  const Model model = build(Exec(2), ct, {}, params).value();
  const BodySurface surface = build_surface(model, make_state(model).cuts, &ct, Extent::kAll, Exec(2));
  double beyond = -1e3, within = 1e3;
  const Vec3d first = index_at(ct.grid, model.anatomy.grid.origin);
  for (int v = 0; v < surface.skin_triangles; v++) {
    const Vec3d at = first + Vec3d(surface.rest[std::size_t(surface.triangles[std::size_t(v)].x)]) / kSpacing;
    if (at.z < 1 || at.z > kSize.z - 3 || at.y < 90) continue;  // ends of the scan, and the front
    beyond = std::max(beyond, beyond_body(at)), within = std::min(within, beyond_body(at));
  }
  EXPECT_LT(beyond, 0.8);
  EXPECT_GT(within, -1.2);
}

/// Rest positions of a cut's lips by their position along the cut.
std::multimap<Real, Vec3> lips_of(const BodySurface& surface) {
  std::multimap<Real, Vec3> lips;
  for (const Lip& lip : surface.lips) lips.emplace(lip.along, surface.rest[std::size_t(lip.left)]);
  return lips;
}

// A wound on a back that lies on a mattress is measured where it is drawn: the surface around cuts has the
// lips of the whole surface.
TEST(Surroundings, WoundIsMeasuredWhereDrawn) {
  const CtVolume ct = body_on_cover(2.5);
  Params params;
  params.block = {6, 6, 6};
  const Model model = build(Exec(2), ct, {}, params).value();
  State state = make_state(model);
  const BladePath path =
      lay_blade(model, state, {.from = {0.09, 0.12, 0.03}, .to = {0.15, 0.12, 0.03}, .depth = 0.01}).value();
  cut_edges(model, state, path, 0, 1, 0);
  const auto drawn = lips_of(build_surface(model, state.cuts, &ct, Extent::kAll, Exec(2)));
  EXPECT_GT(drawn.size(), 10u);
  EXPECT_EQ(lips_of(build_surface(model, state.cuts, &ct, Extent::kCuts)), drawn);
  // without the mask the lips lie on the cover
  Model without = model;
  without.anatomy.surroundings = {};
  EXPECT_NE(lips_of(build_surface(without, state.cuts, &ct, Extent::kCuts)), drawn);
}

/// Area of the skin within a spacing of the back [m²].
double skin_of_back(const CtVolume& ct) {
  Params params;
  params.block = {4, 4, 4};
  const Model model = build(Exec(2), ct, {}, params).value();
  const Lattice& l = model.anatomy.lattice;
  double area = 0;
  for (const SkinTriangle& t : model.anatomy.skin.triangles) {
    Vec3d center;
    for (const int slot : {t.vertex.x, t.vertex.y, t.vertex.z})
      center += hadamard(Vec3d(slot_node(l, slot)), Vec3d(l.spacing)) / 3;
    if (center.y > 1e-3 * (kBack - 20) && std::abs(center.x - 0.12) < 0.02) area += double(t.area);
  }
  return area;
}

// A back that lies on a table is skin like the rest of the body, with the tension of skin.
TEST(Surroundings, BackOnTableIsSkin) {
  const auto in_table = [](double x, double y) {
    return y >= kBack + 2 && y < kBack + 27 && x > 5 && x < 235;
  };
  const double alone = skin_of_back(painted([](double x, double y, double) { return in_body(x, y); }));
  const double on_table =
      skin_of_back(painted([&](double x, double y, double) { return in_body(x, y) || in_table(x, y); }));
  EXPECT_GT(alone, 0.8 * 0.04 * 0.06) << "m²";
  EXPECT_NEAR(on_table, alone, 0.02 * alone);
}

// Next to surroundings, tissue keeps its values, and thin covers become air.
TEST(Surroundings, TissueKeepsValuesBesideThem) {
  const CtVolume ct = body_on_cover(3);
  const Surroundings beside = find_surroundings(Exec(2), ct, -449);
  EXPECT_GT(std::count(beside.mask.begin(), beside.mask.end(), kContactCell), 0);
  const CtSlab slab(ct);
  const BodyVoxels body(slab, beside, -449);
  for (int j = 0; j < kSize.y; j++)
    for (int i = 0; i < kSize.x; i++) {
      const double out = beyond_body({double(i), double(j), 30});
      if (out < -1) {
        EXPECT_EQ(body({i, j, 30}), ct.at(i, j, 30)) << i << ' ' << j;
      }
      if (out > 1.5) {
        EXPECT_LT(body({i, j, 30}), -449) << i << ' ' << j;
      }
    }
}

// Thin parts of the body, such as ears and fingers, do not count as surroundings.
TEST(Surroundings, EarsAndFingersRemain) {
  const auto finger = [](double x, double y, double z) {  // 60 mm long, 5 mm thick, at the body's front
    return std::abs(x - 120) < 2.5 && std::abs(z - 30) < 2.5 && y < 20 && y > -40;
  };
  const auto moved_body = [](double x, double y) { return in_body(x, y - 60); };
  const CtVolume ct =
      painted([&](double x, double y, double z) { return moved_body(x, y) || finger(x, y - 60, z); });
  const Surroundings beside = find_surroundings(Exec(2), ct, -449);
  EXPECT_EQ(std::count(beside.mask.begin(), beside.mask.end(), 1), 0);
}

// The vessels of a lung belong to the body.
TEST(Surroundings, LungVesselsBelongToBody) {
  const CtVolume ct = painted([](double x, double y, double z) {
    const double u = (x - 120) / 75, v = (y - 65) / 40;
    const bool in_lung = u * u + v * v < 1;
    const bool in_vessel = std::hypot(y - 65, z - 30) < 1.5;  // 150 mm long
    return in_body(x, y) && (!in_lung || in_vessel);
  });
  const Surroundings beside = find_surroundings(Exec(2), ct, -449);
  EXPECT_EQ(std::count(beside.mask.begin(), beside.mask.end(), 1), 0);
}

// One and four threads find the same surroundings.
TEST(Surroundings, EqualMaskOnAnyThreads) {
  const CtVolume ct =
      painted([](double x, double y, double) { return in_body(x, y) || (y > 123 && y < 126); });
  const Surroundings one = find_surroundings(Exec(1), ct, -449), four = find_surroundings(Exec(4), ct, -449);
  EXPECT_GT(std::count(one.mask.begin(), one.mask.end(), 1), 0);
  EXPECT_EQ(one.mask, four.mask);
  EXPECT_EQ(one.row_mask, four.row_mask);
}

}  // namespace
}  // namespace turgor::lattice
