// Needles that bend, against beams on elastic foundations, and bevels against an independent integration.
#include <Eigen/Sparse>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "tests/allocations.hpp"
#include "turgor/contact/needle_touch.hpp"
#include "turgor/geometry/hex_block.hpp"

namespace turgor::contact {
namespace {

constexpr double kBendYoung = 4e3, kBendPoisson = 0.45;

sfem::InnerGreen bend_block(Vec3d size, Int3 count, int threads = 2) {
  sfem::Body body;
  body.mesh = hex_block(size, count);
  for (const Vec3d x : body.mesh.vertices) body.fixed.push_back(x.z < 1e-9);
  body.materials = {{kBendYoung, kBendPoisson}};
  sfem::Model model = *sfem::build(Exec(threads), std::move(body), {});
  EXPECT_TRUE(sfem::factorize(Exec(threads), model));
  std::vector<int> all(element_count(model.body.mesh));
  for (std::size_t e = 0; e < all.size(); e++) all[e] = int(e);
  return sfem::make_inner_green(Exec(threads), model, all);
}

constexpr double kColumnWidth = 0.04, kColumnHeight = 0.1, kLayer = 0.002;

/// Column of flat elements without compliance between its points: the tissue is a bed of springs D, the same
/// at every point in its middle.
const sfem::InnerGreen& spring_bed() {
  static const sfem::InnerGreen bed = [] {
    sfem::InnerGreen inner =
        bend_block({kColumnWidth, kColumnWidth, kColumnHeight}, {1, 1, int(kColumnHeight / kLayer + 0.5)});
    constexpr float kAlmostRigid = 1e-5F;  // [m/N]
    const std::size_t count = inner.vertices.size();
    std::fill(inner.green.begin(), inner.green.end(), 0.0F);
    for (std::size_t v = 0; v < count; v++)
      for (const std::size_t axis : {0u, 4u, 8u}) inner.green[9 * (v * count + v) + axis] = kAlmostRigid;
    return inner;
  }();
  return bed;
}

/// Stiffness of the bed across a shaft, per length [N/m²]: docs/needle.md, for a point at a quarter of a
/// layer.
double bed_stiffness(const Needle& needle) {
  const double squares = 0.25 * (0.75 * 0.75 + 0.25 * 0.25);
  const double size = std::cbrt(kColumnWidth * kColumnWidth * kLayer);
  const double log = 0.27 - 3.75 * squares + std::log(size / (needle.diameter / 2));
  const double shear = kBendYoung / (2 * (1 + kBendPoisson));
  return 8 * std::numbers::pi * shear * (1 - kBendPoisson) / ((3 - 4 * kBendPoisson) * log);
}

/// Needle that a hand holds at the end of its shaft.
struct BentInsertion {
  const sfem::InnerGreen& inner;
  Needle needle;
  Pose pose;
  NeedleState state;

  BentInsertion(const sfem::InnerGreen& green, const Needle& shape, Vec3d entry)
      : inner(green),
        needle(shape),
        pose{entry + Vec3d{0, 0, 0.001}, {}},
        state(make_needle_state(green, shape)) {}
  ToolReading tick() { return tick_needle(inner, needle, {}, pose, 1, state); }
  void move_by(double down, double step = 5e-5) {
    const int ticks = std::max(1, int(std::lround(std::abs(down) / step)));
    for (int i = 0; i < ticks; i++) pose.position += pose.axes.column[2] * (-down / ticks), tick();
  }
  Vec3d tip() const { return pose.position + state.reading.deflection; }
  Vec3d hub() const { return pose.position + pose.axes.column[2] * needle.length; }
  Vec3d torque_at_hub(const ToolReading& r) const { return r.torque + cross(pose.position - hub(), r.force); }
  double energy_error() const {
    const NeedleWork& w = state.work;
    return (w.cutting + w.friction + w.spreading + w.elastic - w.hand) / w.hand;
  }
};

constexpr Vec3d kBedEntry{kColumnWidth / 2, kColumnWidth / 2, kColumnHeight};

// A force on the tip, or between two nodes, bends the shaft as a cantilever: P L³/(3 EI), P b² (3 L − b)/(6
// EI).
TEST(NeedleBend, LoadBendsCantilever) {
  const Needle needle{.length = 0.13, .bending = 2.3e-3};
  BeamMatrix factor = beam_stiffness(needle);
  factorize(factor);
  const double length = needle.length, force = 0.17;
  for (const double behind : {0.0, 0.0317, 0.1}) {
    NeedleBeam beam;
    add_load(beam_shape(needle, behind), {force, -2 * force, 0}, beam);
    const NeedleBeam load = beam;
    solve(factor, beam);
    const double b = length - behind, expected = force * b * b * (3 * length - b) / (6 * needle.bending);
    EXPECT_NEAR(at_tip(beam).x / expected, 1, 1e-9);
    EXPECT_NEAR(at_tip(beam).y / expected, -2, 1e-9);
    EXPECT_NEAR(deflection_slope(beam, beam_shape(needle, 0)).x / (-force * b * b / (2 * needle.bending)), 1,
                1e-9);
    // energy = ½ load · deflection
    double work = 0;
    for (std::size_t i = 0; i < kBeamUnknowns; i++)
      work += 0.5 * (load.x[i] * beam.x[i] + load.y[i] * beam.y[i]);
    EXPECT_NEAR(beam_energy(needle, beam) / work, 1, 1e-9);
  }
}

/// Beam with a free length above a semi-infinite bed (Winkler, Hetényi): y = e^{−βz} (A cos βz + B sin βz) in
/// the bed, a cubic above it; the hand displaces and turns its upper end. Force and moment there.
struct HandLoad {
  double force = 0, moment = 0;
};
HandLoad hand_load(double bending, double bed, double above, double moved, double turned) {
  const double b = std::pow(bed / (4 * bending), 0.25), e = above;
  // derivatives at the surface as rows of A and B
  const Eigen::RowVector2d y(1, 0), dy(-b, b), ddy(0, -2 * b * b), dddy(2 * b * b * b, 2 * b * b * b);
  Eigen::Matrix2d m;
  m.row(0) = y - e * dy + e * e / 2 * ddy - e * e * e / 6 * dddy;
  m.row(1) = dy - e * ddy + e * e / 2 * dddy;
  const Eigen::Vector2d ab = m.inverse() * Eigen::Vector2d(moved, turned);
  return {bending * dddy.dot(ab), bending * (ddy - e * dddy).dot(ab)};
}

// A hand that moves or tilts an inserted needle feels the force and the moment of a beam on an elastic
// foundation.
TEST(NeedleBend, ShaftIsBeamOnElasticFoundation) {
  struct Case {
    double diameter, bending;
  };
  for (const Case c : {Case{0.0006, 4e-5}, {0.001, 9e-5}}) {
    const Needle needle{.length = 0.1,
                        .diameter = c.diameter,
                        .toughness = 0.1,
                        .entry_toughness = 0.1,
                        .friction = 1e-5,
                        .spreading = 0,
                        .bending = c.bending};
    const double bed = bed_stiffness(needle);
    for (const bool tilts : {false, true}) {
      BentInsertion insertion(spring_bed(), needle, kBedEntry);
      insertion.move_by(0.071);
      const double inserted = insertion.state.inserted;
      EXPECT_NEAR(inserted, 0.07, 1e-4);
      ToolReading before = insertion.tick();
      const Vec3d hub = insertion.hub(), torque = insertion.torque_at_hub(before);
      constexpr double kMove = 1e-4, kTilt = 2e-3;
      if (tilts) {
        const Vec3d z{std::sin(kTilt), 0, std::cos(kTilt)};
        insertion.pose = {hub - z * needle.length, {{{z.z, 0, -z.x}, {0, 1, 0}, z}}};
      } else {
        insertion.pose.position.x += kMove;
      }
      for (int i = 0; i < 5; i++) insertion.tick();
      const ToolReading after = insertion.tick();
      // z into the bed is down, so that a slope dx/dz is positive when the tip is toward x
      const HandLoad expected = hand_load(needle.bending, bed, needle.length - inserted, tilts ? 0 : kMove,
                                          tilts ? -std::tan(kTilt) : 0);
      EXPECT_NEAR((after.force - before.force).x / -expected.force, 1, 0.02) << c.bending << ' ' << tilts;
      EXPECT_NEAR(std::abs((insertion.torque_at_hub(after) - torque).y / expected.moment), 1, 0.02)
          << c.bending << ' ' << tilts;
    }
  }
}

/// Insertion of a beveled needle by finite differences: the track is laid beside the tip, and the shaft is a
/// beam on springs to its track. Returns the deflection of the tip at every depth.
std::vector<double> integrated_path(const Needle& needle, double bed, double depth) {
  constexpr double kStep = 2.5e-4;
  const int nodes = int(std::lround(needle.length / kStep)), steps = int(std::lround(depth / kStep));
  std::vector<double> track(std::size_t(steps) + 1, 0.0), tip{0.0};
  const double side = needle.diameter / 2 * std::cos(needle.bevel * std::numbers::pi / 180),
               face = needle.diameter / std::tan(needle.bevel * std::numbers::pi / 180);
  for (int n = 1; n <= steps; n++) {
    std::vector<Eigen::Triplet<double>> entries;
    Eigen::VectorXd rhs = Eigen::VectorXd::Zero(nodes + 1);
    // curvature at every node but the tip; the clamp continues without deflection
    for (int j = 1; j <= nodes; j++) {
      const std::array<double, 3> weight{1, -2, 1};
      for (int a = 0; a < 3; a++)
        for (int b = 0; b < 3; b++)
          if (j - 1 + a <= nodes && j - 1 + b <= nodes)
            entries.emplace_back(
                j - 1 + a, j - 1 + b,
                needle.bending / (kStep * kStep * kStep) * weight[std::size_t(a)] * weight[std::size_t(b)]);
    }
    // springs to the track; at the tip it is laid beside it, so that the spring there has that length
    const double beside = side * std::min(1.0, n * kStep / face);
    rhs[0] = bed * kStep / 2 * beside;
    for (int j = 1; j <= n && j <= nodes; j++) {
      const double spring = bed * kStep * (j == n ? 0.5 : 1);
      entries.emplace_back(j, j, spring);
      rhs[j] += spring * track[std::size_t(n - j)];
    }
    entries.emplace_back(nodes, nodes, 1e12);
    Eigen::SparseMatrix<double> matrix(nodes + 1, nodes + 1);
    matrix.setFromTriplets(entries.begin(), entries.end());
    const Eigen::VectorXd y = Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(matrix).solve(rhs);
    tip.push_back(y[0]);
    track[std::size_t(n)] = y[0] + beside;
  }
  return tip;
}

Needle beveled(double bevel, double toward) {
  return {.length = 0.1,
          .diameter = 0.0005,
          .toughness = 0.1,
          .entry_toughness = 0.1,
          .friction = 1e-5,
          .spreading = 0,
          .bending = 6e-5,
          .bevel = bevel,
          .bevel_toward = toward};
}

// A beveled needle curves in a homogeneous block as an independent integration says; where it has become
// steady the curvature of its path is δ √(k/EI).
TEST(NeedleBend, BevelCurvesAsIntegrated) {
  Needle needle = beveled(6, 0);
  needle.diameter = 0.0002, needle.bending = 2e-5, needle.spacing = 0.0005;
  const double bed = bed_stiffness(needle);
  const std::vector<double> expected = integrated_path(needle, bed, 0.085);
  BentInsertion insertion(spring_bed(), needle, kBedEntry);
  insertion.move_by(0.001);
  std::vector<double> found;
  for (std::size_t n = 0; n < expected.size(); n++) {
    if (n > 0) insertion.move_by(2.5e-4, 2.5e-5);
    found.push_back(insertion.tip().x - kBedEntry.x);
    if (n >= 200) {
      EXPECT_NEAR(found[n] / expected[n], 1, 0.03) << n;
    }
  }
  EXPECT_GT(found.back(), 1e-3);
  // curvature of the last 20 mm, from a parabola
  const std::size_t n = found.size() - 1, h = 40;
  const double curvature = (found[n] - 2 * found[n - h] + found[n - 2 * h]) / (0.01 * 0.01);
  EXPECT_NEAR(curvature / (bevel_offset(needle) * std::sqrt(bed / needle.bending)), 1, 0.02);
}

// Turned by half a turn, the bevel mirrors the path; by a quarter, the path turns.
TEST(NeedleBend, TurnedBevelMirrorsPath) {
  const auto path = [](double toward) {
    BentInsertion insertion(spring_bed(), beveled(40, toward), kBedEntry);
    insertion.move_by(0.051);
    return insertion.tip() - kBedEntry;
  };
  const Vec3d one = path(0), half = path(180), quarter = path(90);
  EXPECT_GT(one.x, 3e-4);
  EXPECT_NEAR(half.x, -one.x, 1e-5 * one.x);
  EXPECT_NEAR(quarter.y, one.x, 1e-5 * one.x);
  EXPECT_NEAR(quarter.x, 0, 1e-5 * one.x);
}

// A very stiff shaft without a bevel has the force of a rigid one along itself. Across, a rigid needle also
// holds the end of the crack.
TEST(NeedleBend, StiffShaftIsRigid) {
  const sfem::InnerGreen block = bend_block({0.06, 0.06, 0.05}, {6, 6, 5});
  std::array<Vec3d, 2> forces;
  for (const bool bends : {false, true}) {
    BentInsertion insertion(block, {.bending = bends ? 1e4 : 0}, {0.031, 0.028, 0.05});
    insertion.move_by(0.03);
    forces[bends] = insertion.state.force;
    EXPECT_LT(norm(insertion.state.reading.deflection), 1e-8);
  }
  EXPECT_NEAR(forces[1].z, forces[0].z, 0.01 * forces[0].z);
}

// Insertion with a bevel, tilting, moving in a circle and withdrawal: the hand's work is accounted for, and a
// closed loop in the tissue gives nothing to the hand.
TEST(NeedleBend, HandGainsNoEnergy) {
  const sfem::InnerGreen block = bend_block({0.06, 0.06, 0.05}, {6, 6, 5});
  for (const double diameter : {0.0004, 0.001}) {
    const Needle needle{.diameter = diameter,
                        .bending = bending_stiffness(diameter, kSteel),
                        .bevel = 30,
                        .bevel_toward = 70};
    BentInsertion insertion(block, needle, {0.031, 0.028, 0.05});
    insertion.move_by(0.03);
    EXPECT_NEAR(insertion.energy_error(), 0, 0.02) << diameter;
    // loops of the hand: a circle, a tilt, and a stroke along with both
    const Pose start = insertion.pose;
    for (int loop = 0; loop < 3; loop++) {
      const double before = insertion.state.work.hand;
      for (int i = 1; i <= 400; i++) {
        const double a = 2 * std::numbers::pi * i / 400, tilt = loop > 0 ? 0.03 * std::sin(a) : 0;
        const Vec3d z{std::sin(tilt), 0, std::cos(tilt)};
        insertion.pose = {start.position + Vec3d{5e-4 * std::sin(a), loop < 2 ? 5e-4 * (1 - std::cos(a)) : 0,
                                                 loop == 2 ? 1e-3 * (1 - std::cos(a)) : 0},
                          {{{z.z, 0, -z.x}, {0, 1, 0}, z}}};
        insertion.tick();
      }
      EXPECT_GT(insertion.state.work.hand - before, -1e-3 * insertion.state.work.hand)
          << diameter << ' ' << loop;
    }
    insertion.pose = start;
    insertion.move_by(-0.032);
    EXPECT_EQ(insertion.state.phase, NeedlePhase::kOutside);
    EXPECT_EQ(insertion.state.beam.x[0], 0);
    EXPECT_NEAR(insertion.energy_error(), 0, 0.03) << diameter;
  }
}

// The same bits on any number of threads, and no allocation in a tick.
TEST(NeedleBend, TicksAllocateNothingAndKeepBits) {
  std::array<Vec3d, 2> tips;
  for (int n = 0; n < 2; n++) {
    const sfem::InnerGreen block = bend_block({0.06, 0.06, 0.05}, {6, 6, 5}, n == 0 ? 1 : 8);
    Needle needle = beveled(30, 40);
    BentInsertion insertion(block, needle, {0.031, 0.028, 0.05});
    EXPECT_EQ(test::allocations_of([&] {
                insertion.move_by(0.03, 2e-4);
                insertion.move_by(-0.01, 2e-4);
                insertion.move_by(0.015, 2e-4);
              }),
              0u);
    tips[std::size_t(n)] = insertion.tip();
  }
  EXPECT_EQ(tips[0], tips[1]);
}

}  // namespace
}  // namespace turgor::contact
