#include "turgor/models/lattice/build/skin.hpp"

#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include <gtest/gtest.h>

#include "tests/models/lattice/block_body.hpp"
#include "turgor/models/lattice/cutting/incision.hpp"
#include "turgor/models/lattice/lattice.hpp"
#include "turgor/models/lattice/model/colors.hpp"

namespace turgor::lattice {
namespace {

const Exec kExec(2);

/// A body from a shape: tissue inside, air elsewhere; nodes 1 mm apart, the grid centered at the origin.
BodyNodes shape_nodes(Int3 size, const std::function<bool(Vec3d)>& inside) {
  BodyNodes nodes;
  nodes.grid = {.size = size, .spacing = {1e-3, 1e-3, 1e-3}};
  nodes.grid.origin = hadamard(Vec3d(size) - Vec3d{1, 1, 1}, nodes.grid.spacing) * -0.5;
  for (int k = 0; k < size.z; k++)
    for (int j = 0; j < size.y; j++)
      for (int i = 0; i < size.x; i++) {
        const bool body = inside(point_at(nodes.grid, Vec3d(Int3{i, j, k})));
        nodes.hu.push_back(body ? 40 : kAirHu);
        nodes.tissue.push_back(body ? Tissue::kMuscle : Tissue::kOutside);
        nodes.young.push_back(body ? 5e3f : 0);
        nodes.fixed.push_back(0);
      }
  return nodes;
}

// The skin of a ball is closed and faces outward.
TEST(LatticeSkin, BallSkinIsClosedAndOutward) {
  const BodyNodes nodes = shape_nodes({31, 31, 31}, [](Vec3d p) { return norm(p) < 0.0102; });
  const Model model = assemble(kExec, nodes, nullptr, {}).value();
  std::map<std::pair<int, int>, int> edges;  // directed
  double six_volumes = 0;
  for (const SkinTriangle& t : model.anatomy.skin.triangles) {
    Vec3d x[3];
    for (int c = 0; c < 3; c++) {
      edges[{t.vertex[c], t.vertex[(c + 1) % 3]}]++;
      x[c] = point_at(model.anatomy.grid, Vec3d(slot_node(model.anatomy.lattice, t.vertex[c])));
    }
    six_volumes += dot(x[0], cross(x[1], x[2]));
  }
  for (const auto& [edge, count] : edges)
    EXPECT_EQ(count, (edges[{edge.second, edge.first}])) << "every edge is shared";
  const double ball = 4.0 / 3 * M_PI * std::pow(0.0102, 3);
  EXPECT_GT(six_volumes / 6, 0.7 * ball) << "positive: outward; smaller than the ball by up to a cell";
  EXPECT_LT(six_volumes / 6, ball);
}

/// Area of the skin, and the sum of the prestress forces that balance its tension.
struct SkinSums {
  double area = 0, pull = 0;
};
SkinSums sums_of(const Model& model) {
  SkinSums sums;
  for (const SkinTriangle& t : model.anatomy.skin.triangles) sums.area += double(t.area);
  for (const Vec3 f : model.prestress_force) sums.pull += norm(Vec3d(f));
  return sums;
}

// A ball's skin has the area of a sphere and Laplace's pressure, in spite of the staircase of the lattice.
TEST(LatticeSkin, BallAreaAndLaplacePressure) {
  for (const double radius : {0.0102, 0.0147, 0.0206}) {
    const int size = 2 * int(radius / 1e-3) + 9;
    const BodyNodes nodes = shape_nodes({size, size, size}, [&](Vec3d p) { return norm(p) < radius; });
    const Model model = assemble(kExec, nodes, nullptr, {}).value();
    double mean = 0, corners = 0;  // mean distance of the skin's nodes from the center [m]
    for (const SkinTriangle& t : model.anatomy.skin.triangles)
      for (int c = 0; c < 3; c++)
        mean += norm(point_at(model.anatomy.grid, Vec3d(slot_node(model.anatomy.lattice, t.vertex[c])))),
            corners++;
    mean /= corners;
    const SkinSums sums = sums_of(model);
    const double tension = model.params.skin.tension_along, area = 4 * M_PI * mean * mean;
    EXPECT_NEAR(sums.area, area, 0.04 * area) << "m², radius " << radius;
    EXPECT_NEAR(sums.pull, 2 * tension / mean * area, 0.08 * 2 * tension / mean * area) << "N: 2 T / r";
  }
}

// The skin of an oblique plane has hardly any prestress force.
TEST(LatticeSkin, ObliquePlaneHasSmallPrestress) {
  // Reference: a staircase surface, on which every edge pulls with T per length, up and down each step.
  for (const Vec3d normal : {Vec3d{0, 0.1, 1}, Vec3d{0.2, 0, 1}, Vec3d{0.3, 0.25, 1}}) {
    const BodyNodes nodes =
        shape_nodes({49, 49, 25}, [&](Vec3d p) { return dot(p, normal) < 1e-5 && p.z > -0.0115; });
    const Model model = assemble(kExec, nodes, nullptr, {}).value();
    double pull = 0, area = 0;
    for (std::size_t n = 0; n < model.anatomy.skin.nodes.size(); n++) {
      const Int3 p = slot_node(model.anatomy.lattice, model.anatomy.skin.nodes[n]);
      if (std::min(p.x, p.y) < 12 || std::max(p.x, p.y) > 36 || p.z < 4) continue;
      pull += norm(Vec3d(model.prestress_force[n])), area += 1e-6;
    }
    const double stairs =
        2 * model.params.skin.tension_along * (std::abs(normal.x) + std::abs(normal.y)) / 1e-3 * area;  // N
    EXPECT_GT(area, 4e-4);
    EXPECT_LT(pull, 0.1 * stairs) << "N, of " << stairs;
  }
}

void expect_batches_without_shared_nodes(const Skin& skin) {
  ASSERT_EQ(std::size_t(skin.batch_begin.back()), skin.triangles.size());
  ASSERT_EQ(std::size_t(skin.layer_begin.back()) + 1, skin.batch_begin.size());
  for (std::size_t b = 0; b + 1 < skin.batch_begin.size(); b++) {
    EXPECT_LE(skin.batch_begin[b + 1] - skin.batch_begin[b], kSkinLanes);
    std::set<int> seen;
    for (int t = skin.batch_begin[b]; t < skin.batch_begin[b + 1]; t++)
      for (int c = 0; c < 3; c++)
        EXPECT_TRUE(seen.insert(skin.triangles[std::size_t(t)].vertex[c]).second) << "batch " << b;
  }
}

// Batches have every triangle once, and no two triangles of a batch share a node.
TEST(LatticeSkin, BatchesShareNoNodes) {
  const BodyNodes nodes =
      shape_nodes({41, 37, 31}, [](Vec3d p) { return norm(p) < 0.0142 && std::abs(p.x) > 0.001; });
  const Model model = assemble(kExec, nodes, nullptr, {}).value();
  const Skin& skin = model.anatomy.skin;
  expect_batches_without_shared_nodes(skin);
  EXPECT_GT(double(skin.triangles.size()) / double(skin.batch_begin.size() - 1), 0.7 * kSkinLanes)
      << "mean fill";
}

// Groups of a color have the skin of cells without common nodes; all groups together have every triangle
// once.
TEST(LatticeSkin, ColorGroupsShareNoNodes) {
  const BodyNodes nodes =
      shape_nodes({42, 37, 31}, [](Vec3d p) { return norm(p) < 0.0142 && std::abs(p.x) > 0.001; });
  Params params;
  params.skin.law = SkinLaw::kArea;
  params.solver = {.method = Method::kPbd, .ordering = Ordering::kColors};
  const Model model = assemble(kExec, nodes, nullptr, params).value();
  const Skin& skin = model.anatomy.skin;
  expect_batches_without_shared_nodes(skin);
  ASSERT_EQ(skin.layer_begin.size(), std::size_t(4 * (model.anatomy.lattice.size.z - 1) + 1));
  for (int group = 0; group < 4 * (model.anatomy.lattice.size.z - 1); group++) {
    std::map<int, Int3> cell_of_node;
    const int first = skin.batch_begin[std::size_t(skin.layer_begin[std::size_t(group)])],
              end = skin.batch_begin[std::size_t(skin.layer_begin[std::size_t(group) + 1])];
    for (int t = first; t < end; t++) {
      const Int3 v = skin.triangles[std::size_t(t)].vertex;
      Int3 cell = model.anatomy.lattice.size - Int3{2, 2, 2};
      for (int c = 0; c < 3; c++) cell = min(cell, slot_node(model.anatomy.lattice, v[c]));
      EXPECT_EQ(color_of(cell), (group & 3) | (group / 4 & 1) << 2);
      for (int c = 0; c < 3; c++)
        EXPECT_EQ(cell_of_node.emplace(v[c], cell).first->second, cell) << "node " << v[c] << " of two cells";
    }
  }
  const Model slabs = assemble(kExec, nodes, nullptr, {}).value();
  const auto sorted = [](const Skin& of) {
    std::set<std::set<int>> all;
    for (const SkinTriangle& t : of.triangles) all.insert({t.vertex.x, t.vertex.y, t.vertex.z});
    return all;
  };
  EXPECT_EQ(skin.triangles.size(), slabs.anatomy.skin.triangles.size());
  EXPECT_EQ(sorted(skin), sorted(slabs.anatomy.skin));
}

// A sheet one node thick has one layer of skin.
TEST(LatticeSkin, ThinSheetIsCoveredOnce) {
  const BodyNodes nodes = shape_nodes({9, 9, 5}, [](Vec3d p) { return std::abs(p.z) < 1e-4; });
  const Model model = assemble(kExec, nodes, nullptr, {}).value();
  std::set<std::set<int>> seen;
  for (const SkinTriangle& t : model.anatomy.skin.triangles)
    EXPECT_TRUE(seen.insert({t.vertex.x, t.vertex.y, t.vertex.z}).second);
  EXPECT_EQ(model.anatomy.skin.triangles.size(), 2u * 8 * 8);
}

// A body under tense skin is at rest in the shape of the CT.
TEST(LatticeSkin, TenseBodyStartsAtRest) {
  for (const SkinLaw law : {SkinLaw::kArea, SkinLaw::kFiber, SkinLaw::kExponential}) {
    Params params;
    params.skin.law = law;
    params.skin.tension_along = params.skin.tension_across =
        5;  // the most that a centimeter of soft tissue carries
    const BodyNodes nodes = shape_nodes({31, 31, 31}, [](Vec3d p) { return norm(p) < 0.0102; });
    const Model model = assemble(kExec, nodes, nullptr, params).value();
    State state = make_state(model);
    for (int n = 0; n < 10; n++)
      EXPECT_LT(step(kExec, model, state, {}, 1.0 / 60).largest_speed, 1e-7) << "m/s";
  }
}

// The fiber frame of every triangle is orthonormal at rest.
TEST(LatticeSkin, FiberFrameIsOrthonormal) {
  Params params;
  params.skin.direction = {0.6, 0.8, 0.3};
  const BodyNodes nodes = shape_nodes({31, 31, 31}, [](Vec3d p) { return norm(p) < 0.0102; });
  const Model model = assemble(kExec, nodes, nullptr, params).value();
  for (const SkinTriangle& t : model.anatomy.skin.triangles) {
    Vec3d along, across;
    for (int c = 0; c < 3; c++) {
      const Vec3d x = c == 0 ? Vec3d{} : Vec3d(c == 1 ? t.edge1 : t.edge2);
      along += x * double(t.along[c]);
      across += x * double(t.across[c]);
    }
    EXPECT_NEAR(norm(along), 1, 1e-3);
    EXPECT_NEAR(norm(across), 1, 1e-3);
    EXPECT_NEAR(dot(along, across), 0, 1e-3);
    EXPECT_GE(dot(along, params.skin.direction), -1e-3)
        << "`along` is the direction projected on the triangle";
  }
}

// A field of tension lines sets the direction of the fibers.
TEST(LatticeSkin, LineFieldSetsFibers) {
  const BodyNodes nodes = shape_nodes({9, 9, 5}, [](Vec3d p) { return p.z < 1e-4; });
  VectorVolume lines{{.size = {2, 1, 1}, .spacing = {4e-3, 1, 1}, .origin = {-2e-3, 0, 0}},
                     {{1, 0, 0}, {0, 1, 0}}};
  const Model model = assemble(kExec, nodes, &lines, {}).value();
  for (const SkinTriangle& t : model.anatomy.skin.triangles) {
    Vec3d along, center;
    for (int c = 0; c < 3; c++) {
      const Vec3d x(rest_position(model.anatomy.lattice, slot_node(model.anatomy.lattice, t.vertex[c])));
      along += x * double(t.along[c]);
      center += point_at(model.anatomy.grid, Vec3d(slot_node(model.anatomy.lattice, t.vertex[c]))) / 3;
    }
    EXPECT_NEAR(std::abs(center.x < 0 ? along.x : along.y), 1, 1e-3) << "at x = " << center.x;
  }
}

/// Force per length between the two halves of a flat sheet of skin, across the x axis or the y axis [N/m]. It
/// follows from energies alone, as the work of a small stretch.
double tension_of(const SkinParams& skin, bool along_x, double field_turn) {
  constexpr int kN = 13;
  constexpr double kStep = 0.002, kStretch = 2e-3;
  Params params;
  params.skin = skin;
  params.skin.direction = {std::cos(field_turn), std::sin(field_turn), 0};
  const Model model = block_model({.size = {kN, kN, 1}, .spacing = kStep, .young = 1e-3}, params);
  double energies[2];
  for (const int side : {0, 1}) {
    State state = make_state(model);
    for (int j = 0; j < kN; j++)
      for (int i = 0; i < kN; i++) {
        const Real shift = Real((side ? kStretch : -kStretch) * kStep * (along_x ? i : j));
        state.motion.u.set(std::size_t(node_slot(model.anatomy.lattice, i, j, 0)),
                           along_x ? Vec3{shift, 0, 0} : Vec3{0, shift, 0});
      }
    energies[side] = energy(kExec, model, state);
  }
  double pull = 0;  // subtracts the work of the tissue's prestress
  for (std::size_t at = 0; at < model.prestress_force.size(); at++) {
    const Int3 p = slot_node(model.anatomy.lattice, model.anatomy.skin.nodes[at]);
    pull += double(along_x ? model.prestress_force[at].x : model.prestress_force[at].y) * kStep *
            (along_x ? p.x : p.y);
  }
  const double side = (kN - 1) * kStep;
  return ((energies[1] - energies[0]) / (2 * kStretch) - pull) / (side * side);
}

// The skin has the requested tension in the CT, for both laws.
TEST(LatticeSkin, HasRequestedTension) {
  for (const double amplification : {0.0, 0.5, 1.0, 2.0, 8.0})
    for (const auto& [along, across] : {std::pair{45.0, 45.0}, {60.0, 30.0}, {10.0, 150.0}, {0.0, 20.0}}) {
      const SkinParams fiber{
          .tension_along = along, .tension_across = across, .amplification = amplification};
      EXPECT_NEAR(tension_of(fiber, true, 0), along, 0.002 * along + 0.01)
          << "N/m, amplification " << amplification;
      EXPECT_NEAR(tension_of(fiber, false, 0), across, 0.002 * across + 0.01);
      EXPECT_NEAR(tension_of(fiber, true, std::numbers::pi / 2), across, 0.002 * across + 0.01)
          << "lines along y";
      SkinParams exponential = fiber;
      exponential.law = SkinLaw::kExponential, exponential.stiffening = 8;
      EXPECT_NEAR(tension_of(exponential, true, 0), along, 0.004 * along + 0.02) << "N/m, exponential law";
      EXPECT_NEAR(tension_of(exponential, false, 0), across, 0.004 * across + 0.02);
      EXPECT_NEAR(tension_of(exponential, true, std::numbers::pi / 2), across, 0.004 * across + 0.02);
      SkinParams area = fiber;
      area.law = SkinLaw::kArea;
      const double mean = (along + across) / 2;
      EXPECT_NEAR(tension_of(area, true, 0), mean, 0.002 * mean + 0.01) << "N/m, area law";
      EXPECT_NEAR(tension_of(area, false, 0), mean, 0.002 * mean + 0.01);
    }
}

// A sheet under tension T with a slit of length 2a opens to an ellipse of width 4 T a / E, with E the modulus
// of the membrane. For an orthotropic membrane without transverse contraction, E is K / √((1 + K/2G) / 2).
// [Westergaard 1939; Sih, Paris, Irwin 1965]
// A slit in a tense sheet opens as a crack in an elastic plane.
TEST(LatticeSkin, SlitOpensAsElasticCrack) {
  constexpr int kN = 91;
  constexpr double kStep = 0.001, kTension = 6, kStiffness = 300, kShear = 100;
  Block block{.size = {kN, kN, 1}, .spacing = kStep, .young = 0.5};
  block.is_fixed = [](Int3 p) { return p.x == 0 || p.y == 0 || p.x == kN - 1 || p.y == kN - 1; };
  Params params;
  params.skin = {.tension_along = kTension,
                 .tension_across = kTension,
                 .stiffness = kStiffness,
                 .shear = kShear,
                 .amplification = 0};
  params.solver = {.sweeps = 40, .damping = 0};
  const Model model = block_model(block, params);
  for (const int half_length : {6, 9, 12}) {
    State state = make_state(model);
    const double a = half_length * kStep, middle = (kN - 1) / 2 * kStep, y = middle + 0.5 * kStep;
    const BladePath path =
        lay_blade(model, state, {.from = {middle - a, y, 0}, .to = {middle + a, y, 0}, .depth = 0.002})
            .value();
    ASSERT_GT(cut_edges(model, state, path, 0, 1, 0), half_length);
    for (int n = 0; n < 30; n++) step(kExec, model, state, {}, 0.1);  // long steps: inertia does not matter
    const Wound wound = measure_wound(model, state, path, 0);
    const double expected = 4 * kTension * a / kStiffness * std::sqrt((1 + kStiffness / (2 * kShear)) / 2);
    EXPECT_NEAR(wound.gape_max, expected, 0.12 * expected) << "half length " << a << " m";
    for (const GapePoint& point : wound.profile) {
      const double x = (point.along - a) / a;
      if (std::abs(x) > 0.85) continue;  // the lattice is too coarse at the ends of the slit
      EXPECT_NEAR(point.gape, wound.gape_max * std::sqrt(1 - x * x), 0.12 * wound.gape_max) << "at " << x;
    }
  }
}

}  // namespace
}  // namespace turgor::lattice
