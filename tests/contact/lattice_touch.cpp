#include "turgor/contact/lattice_touch.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include <gtest/gtest.h>

#include "tests/contact/bonded_layer.hpp"
#include "tests/contact/pressed_lattice.hpp"
#include "tests/geometry/shapes.hpp"
#include "turgor/models/lattice/cutting/incision.hpp"
#include "turgor/models/lattice/lattice.hpp"
#include "turgor/models/lattice/model/colors.hpp"

namespace turgor::contact {
namespace {

// A sphere on springs has the force of a bonded layer and does not penetrate.
TEST(LatticeTouch, SphereOnSpringsMatchesLayer) {
  constexpr double kStep = 0.002, kRadius = 0.04;
  const Int3 size{61, 61, 41};
  Pressed block(size, kStep, 10, {Sphere{kRadius}, 0}, middle(size, kStep, 1));
  block.at[0].pose.position.z = block.top + kRadius;
  double last_ratio = 0;
  for (const double contact : {0.006, 0.008, 0.010}) {  // radius of the contact circle: 3, 4 and 5 cells
    const double depth = contact * contact / kRadius;
    block.move_to(Exec(2), middle(size, kStep, block.top + kRadius - depth), 15);
    block.move_to(Exec(2), block.at[0].pose.position, 30);
    const double layer = force_on_bonded_layer(kYoung, 0.04, kRadius, depth, block.top);
    const double ratio = block.forces[0].force.z / layer;
    std::printf("circle of %2.0f mm: %.4f N, %.3f times the layer's %.4f N; %d contacts, %.1e mm inside\n",
                contact * 1e3, block.forces[0].force.z, ratio, layer, block.forces[0].contacts,
                block.forces[0].largest_penetration * 1e3);
    EXPECT_NEAR(ratio, 1, 0.1)
        << "springs have a Poisson's ratio of 0.04 along an axis and are not isotropic";
    if (last_ratio > 0) {
      EXPECT_NEAR(ratio / last_ratio, 1, 0.05) << "the force grows with depth^1.5";
    }
    EXPECT_LT(block.forces[0].largest_penetration, 0.01 * depth) << "m";
    EXPECT_LT(std::hypot(block.forces[0].force.x, block.forces[0].force.y), 0.2 * block.forces[0].force.z);
    last_ratio = ratio;
  }
}

// A sphere on solid tissue has the force of a bonded layer with the tissue's Poisson's ratio.
TEST(LatticeTouch, SphereOnSolidMatchesLayer) {
  constexpr double kStep = 0.002, kRadius = 0.04, kContact = 0.008;  // a circle of 4 cells
  constexpr double kDepth = kContact * kContact / kRadius;
  for (const double poisson : {0.2, 0.4}) {
    const Int3 size{61, 61, 41};
    Pressed block(size, kStep, 10, {Sphere{kRadius}, 0}, middle(size, kStep, 1), false,
                  {.law = lattice::TissueLaw::kSolid, .poisson = poisson});
    block.at[0].pose.position.z = block.top + kRadius;
    block.move_to(Exec(2), middle(size, kStep, block.top + kRadius - kDepth), 10);
    block.move_to(Exec(2), block.at[0].pose.position, 30);
    const double layer = force_on_bonded_layer(kYoung, poisson, kRadius, kDepth, block.top);
    const double force = block.forces[0].force.z;
    std::printf("v %.1f: %.4f N, %.3f times the layer's %.4f N\n", poisson, force, force / layer, layer);
    EXPECT_NEAR(force, layer, 0.05 * layer) << "N, v " << poisson;
  }
}

// The force on the tool equals the reaction at the fixed nodes.
TEST(LatticeTouch, ToolForceEqualsReaction) {
  const Int3 size{21, 21, 11};
  Pressed block(size, 0.004, 40, {Sphere{0.012}, 0.5}, middle(size, 0.004, 1));
  block.at[0].pose.position.z = block.top + 0.012;
  block.move_to(Exec(2), middle(size, 0.004, block.top + 0.009), 20);
  block.move_to(Exec(2), block.at[0].pose.position, 150);
  const double forces_on_tool = block.forces[0].force.z, borne = reaction(block);
  std::printf("on the tool %.5f N, at the bottom %.5f N\n", forces_on_tool, borne);
  EXPECT_GT(forces_on_tool, 0.05);
  EXPECT_NEAR(std::abs(borne), forces_on_tool, 0.01 * forces_on_tool) << "N";
}

// The force of a plate on a column is E A d / L.
TEST(LatticeTouch, PlateOnColumnHasEAOverL) {
  const Int3 size{13, 13, 41};
  constexpr double kStep = 0.004;
  TriMesh plate = test::box_surface({0.08, 0.08, 0.02});
  for (Vec3& x : plate.vertices) x -= Vec3{0.04f, 0.04f, 0};
  Pressed block(size, kStep, 60, {mesh_shape(plate).value(), 0}, middle(size, kStep, 1));
  block.at[0].pose.position.z = block.top;
  const double length = (size.z - 1) * kStep, press = 0.02 * length, area = size.x * size.y * kStep * kStep;
  block.move_to(Exec(2), middle(size, kStep, block.top - press), 20);
  block.move_to(Exec(2), block.at[0].pose.position, 200);
  const double expected = kYoung * area * press / length;
  std::printf("%.4f N, E A d / L = %.4f N\n", block.forces[0].force.z, expected);
  EXPECT_NEAR(block.forces[0].force.z, expected, 0.1 * expected) << "N";
  EXPECT_GE(block.forces[0].contacts, (size.x - 1) * (size.y - 1));
  EXPECT_LT(norm(block.forces[0].torque), kStep * expected) << "N m: the press is centered";
}

// A holding tool moves its contacts and is pulled down; a release removes the force.
TEST(LatticeTouch, HeldToolPullsAndReleases) {
  const Int3 size{17, 17, 9};
  Pressed block(size, 0.004, 20, {Sphere{0.01}, 0.3}, middle(size, 0.004, 1));
  block.at[0].pose.position.z = block.top + 0.012;
  block.move_to(Exec(2), middle(size, 0.004, block.top + 0.008), 20);
  EXPECT_GT(block.forces[0].force.z, 0.01) << "N: the tool presses";
  block.move_to(Exec(2), middle(size, 0.004, block.top + 0.018), 60, true);
  const int held = block.forces[0].contacts;
  EXPECT_GT(held, 5);
  EXPECT_LT(block.forces[0].force.z, -0.05) << "N: the body pulls the tool down";
  for (std::size_t c = 0; c < block.touch.contacts.size(); c++) {
    const LatticeContact& contact = block.touch.contacts[c];
    if (!contact.is_held) continue;
    const Vec3d x = sample_position(block.touch, block.state.motion, contact.sample);
    EXPECT_LT(norm(x - to_world(block.at[0].pose, contact.anchor)), 2e-5)
        << "m: held contacts follow the tool";
  }
  const double pulled = block.forces[0].force.z;
  block.move_to(Exec(2), middle(size, 0.004, block.top + 0.018), 10, false);
  std::printf("%d contacts held, %.4f N; released: %.1e N\n", held, pulled, norm(block.forces[0].force));
  EXPECT_EQ(norm(block.forces[0].force), 0) << "N";
}

// A tool that starts to hold where it presses keeps its force.
TEST(LatticeTouch, HoldingKeepsForce) {
  const Int3 size{17, 17, 9};
  for (const bool with_skin : {false, true}) {
    Pressed block(size, 0.004, 10, {Sphere{0.01}, 0.3}, middle(size, 0.004, 1), with_skin);
    block.at[0].pose.position.z = block.top + 0.012;
    const std::vector<Vec3d> press = block.move_to(Exec(2), middle(size, 0.004, block.top + 0.007), 30);
    const std::vector<Vec3d> held = block.move_to(Exec(2), block.at[0].pose.position, 30, true);
    double jump = 0;
    for (std::size_t n = 1; n < held.size(); n++) jump = std::max(jump, norm(held[n] - held[n - 1]));
    std::printf("pressed %.4f N, held %.4f N at once and %.4f N later\n", press.back().z, held[0].z,
                held.back().z);
    EXPECT_LT(norm(held[0] - press.back()), 0.1 * norm(press.back())) << "N";
    EXPECT_LT(jump, 0.05 * norm(press.back())) << "N";
  }
}

// Friction stays in its cone, and the force has no jumps while the tool slides.
TEST(LatticeTouch, SlideStaysInConeWithoutJumps) {
  const Int3 size{31, 17, 9};
  constexpr double kStep = 0.004, kFriction = 0.4;
  Pressed block(size, kStep, 20, {Sphere{0.012}, kFriction}, middle(size, kStep, 1));
  const Vec3d start{0.04, 0.032, block.top + 0.009};
  block.at[0].pose.position = start + Vec3d{0, 0, 0.004};
  block.move_to(Exec(2), start, 30);
  block.move_to(Exec(2), start, 30);
  double jump = 0, least = 1, most = 0;
  bool slides = false, sticks = false;
  Vec3d last = block.forces[0].force;
  for (int n = 1; n <= 100; n++) {
    block.move_to(Exec(2), start + Vec3d{0.0004 * n, 0, 0}, 1);
    for (const lattice::NodeContact& c : block.touch.nodes) {
      const Real pressing = dot(c.force, c.normal), rubbing = norm(c.force - c.normal * pressing);
      EXPECT_GE(pressing, 0);
      EXPECT_LE(rubbing, Real(kFriction) * pressing * 1.0001f) << "N, step " << n;
    }
    const Vec3d force = block.forces[0].force;
    if (n > 10) jump = std::max(jump, norm(force - last));
    last = force;
    sticks = sticks || block.forces[0].contacts - block.forces[0].sliding > 5;
    slides = slides || (block.forces[0].contacts > 3 && block.forces[0].sliding == block.forces[0].contacts);
    if (n > 50) least = std::min(least, -force.x / force.z), most = std::max(most, -force.x / force.z);
  }
  std::printf(
      "sliding, largest jump in a step of 0.4 mm: %.4f N of %.4f N; force along / across %.3f to %.3f\n",
      jump, norm(last), least, most);
  EXPECT_TRUE(sticks) << "at first";
  EXPECT_TRUE(slides) << "in the end";
  EXPECT_LT(jump, 0.03 * norm(last)) << "N";
  EXPECT_GT(least, 0.5 * kFriction);
}

// A new cut keeps all held contacts and adds samples on its walls.
TEST(LatticeTouch, CutKeepsHeldContactsAddsWalls) {
  const Int3 size{17, 17, 9};
  Pressed block(size, 0.004, 20, {Sphere{0.01}, 0.3}, middle(size, 0.004, 1), true);
  block.at[0].pose.position.z = block.top + 0.012;
  block.move_to(Exec(2), middle(size, 0.004, block.top + 0.008), 20);
  block.move_to(Exec(2), middle(size, 0.004, block.top + 0.014), 30, true);
  const auto held = [&] {
    return std::count_if(block.touch.contacts.begin(), block.touch.contacts.end(),
                         [](const LatticeContact& c) { return c.is_held; });
  };
  const auto before = held();
  const double pulled = block.forces[0].force.z;
  const auto path = lattice::lay_blade(block.model, block.state,
                                       {.from = {0.01, 0.012, block.top}, .to = {0.055, 0.012, block.top}});
  ASSERT_TRUE(path) << path.error().message;
  ASSERT_GT(lattice::cut_edges(block.model, block.state, *path, 0, 1, 0), 20);
  update_surface(block.touch, block.model, block.state.cuts,
                 lattice::build_surface(block.model, block.state.cuts));
  const auto walls = std::count_if(block.touch.samples.begin(), block.touch.samples.end(),
                                   [](const LatticeSample& p) { return p.wall; });
  EXPECT_GT(walls, 20);
  EXPECT_GT(before, 2);
  EXPECT_EQ(held(), before);
  block.move_to(Exec(2), block.at[0].pose.position, 1, true);
  EXPECT_LT(block.forces[0].force.z, 0.7 * pulled) << "N, before the cut " << pulled;
}

// A rotated body gives the rotated force and torque.
TEST(LatticeTouch, RotatedBodyRotatesForce) {
  const Int3 size{13, 11, 9};
  Pressed plain(size, 0.004, 10, {Sphere{0.01}, 0.4}, middle(size, 0.004, 1));
  Pressed rotated(size, 0.004, 10, {Sphere{0.01}, 0.4}, middle(size, 0.004, 1));
  const Mat3d rotation{{{0.36, 0.48, -0.8}, {-0.8, 0.6, 0}, {0.48, 0.64, 0.6}}};
  const Vec3d shift{0.1, -0.3, 0.7};
  rotated.model.anatomy.grid.axes = rotation, rotated.model.anatomy.grid.origin = shift;
  const auto in_patient = [&](Vec3d x) { return shift + rotation * x; };
  const Vec3d start = middle(size, 0.004, plain.top + 0.01), end = start + Vec3d{0.003, 0.001, -0.003};
  plain.at[0].pose.position = start;
  rotated.at[0].pose = {in_patient(start), rotation};
  rotated.touch = make_lattice_touch(rotated.model, rotated.state.cuts,
                                     lattice::build_surface(rotated.model, rotated.state.cuts), rotated.at);
  for (int n = 1; n <= 10; n++) {
    plain.move_to(Exec(1), start + (end - start) * (n / 10.0), 1);
    rotated.at[0].pose = {in_patient(start + (end - start) * (n / 10.0)), rotation};
    contact::step_with_tools(Exec(1), rotated.model, rotated.state, rotated.touch, rotated.tools, rotated.at,
                             {}, kDt, rotated.forces);
  }
  const Vec3d force = rotation * plain.forces[0].force, torque = rotation * plain.forces[0].torque;
  EXPECT_GT(norm(force), 0.01) << "N";
  EXPECT_LT(norm(rotated.forces[0].force - force), 0.01 * norm(force)) << "N";
  EXPECT_LT(norm(rotated.forces[0].torque - torque), 0.01 * norm(force) * 0.01) << "N m";
}

// At rest, the residual under a contact is below 0.1 % of its force.
TEST(LatticeTouch, RestingContactHasSmallResidual) {
  const Int3 size{13, 11, 9};
  Pressed block(size, 0.004, 40, {Sphere{0.01}, 0.3}, middle(size, 0.004, 1));
  block.at[0].pose.position.z = block.top + 0.01;
  block.move_to(Exec(2), middle(size, 0.004, block.top + 0.007), 10);
  block.move_to(Exec(2), block.at[0].pose.position, 150);
  lattice::StepReport report =
      contact::step_with_tools(Exec(2), block.model, block.state, block.touch, block.tools, block.at,
                               {.measure_residual = true}, kDt, block.forces);
  std::printf("residual %.1e N, contact force %.3f N\n", report.residual.largest,
              norm(block.forces[0].force));
  EXPECT_GT(norm(block.forces[0].force), 0.03) << "N";
  EXPECT_LT(report.residual.largest, 1e-3 * norm(block.forces[0].force)) << "N";
}

// Two tools that pinch the body have opposite forces.
TEST(LatticeTouch, PinchForcesAreOpposite) {
  const Int3 size{13, 11, 9};
  Pressed block(size, 0.004, 20, {Sphere{0.008}, 0.5}, {});
  const double middle_y = 0.02;
  block.tools.push_back(block.tools[0]);
  block.forces.resize(2);
  const auto jaws = [&](double half_gap) {
    std::vector<ToolPose> poses;
    for (const double side : {-1.0, 1.0})
      poses.push_back({{{0.024 + side * (half_gap + 0.008), middle_y, block.top + 0.003}, {}}, false});
    return poses;
  };
  block.at = jaws(0.012);
  block.touch = make_lattice_touch(block.model, block.state.cuts,
                                   lattice::build_surface(block.model, block.state.cuts), block.at);
  for (int n = 1; n <= 60; n++) {
    block.at = jaws(0.012 - 0.008 * std::min(1.0, n / 30.0));
    for (ToolPose& jaw : block.at) jaw.pose.position.z -= 0.006 * std::min(1.0, n / 15.0);
    contact::step_with_tools(Exec(2), block.model, block.state, block.touch, block.tools, block.at, {}, kDt,
                             block.forces);
  }
  const Vec3d a = block.forces[0].force, b = block.forces[1].force;
  std::printf("%.4f and %.4f N across, %.4f and %.4f N up\n", a.x, b.x, a.z, b.z);
  EXPECT_LT(a.x, -0.01) << "N: pushed apart";
  EXPECT_GT(b.x, 0.01) << "N";
  EXPECT_LT(std::abs(a.x + b.x), 0.35 * b.x) << "N: Kuhn cells are not symmetric, so not exactly opposite";
}

// One, two and eight threads give the same bits in both orderings.
TEST(LatticeTouch, EqualBitsOnAnyThreads) {
  for (const lattice::Ordering ordering : {lattice::Ordering::kSlabs, lattice::Ordering::kColors}) {
    std::set<std::uint64_t> hashes;
    std::set<double> forces;
    const Int3 size{15, 13, 9};
    for (const int threads : {1, 2, 8}) {
      Pressed block(size, 0.004, 5, {Capsule{0.008, 0.01}, 0.4}, middle(size, 0.004, 1));
      block.model.params.solver.ordering = ordering;
      block.at[0].pose.position.z = block.top + 0.019;
      block.move_to(Exec(threads), middle(size, 0.004, block.top + 0.015) + Vec3d{0.004, 0.002, 0}, 12);
      hashes.insert(lattice::state_hash(block.model, block.state));
      forces.insert(norm(block.forces[0].force));
    }
    EXPECT_EQ(hashes.size(), 1u) << "ordering " << int(ordering);
    EXPECT_EQ(forces.size(), 1u);
    EXPECT_GT(*forces.begin(), 1e-3) << "N";
  }
}

// The two nodes of a surface sample have different colors.
TEST(LatticeTouch, SampleNodesDifferInColor) {
  const Int3 size{13, 11, 9};
  Pressed block(size, 0.004, 10, {Sphere{0.01}, 0.3}, middle(size, 0.004, 1));
  const lattice::BodySurface surface = lattice::build_surface(block.model, block.state.cuts);
  int between = 0;
  for (const LatticeSample& sample :
       make_lattice_touch(block.model, block.state.cuts, surface, block.at).samples) {
    if (sample.other < 0) continue;
    EXPECT_NE(lattice::color_of(slot_node(block.model.anatomy.lattice, sample.slot)),
              lattice::color_of(slot_node(block.model.anatomy.lattice, sample.other)));
    between++;
  }
  EXPECT_GT(between, 100);
}

}  // namespace
}  // namespace turgor::contact
