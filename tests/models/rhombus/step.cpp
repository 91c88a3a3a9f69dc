#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/models/rhombus/bodies.hpp"
#include "turgor/models/rhombus/rhombus.hpp"
#include "turgor/models/rhombus/spread.hpp"
#include "turgor/models/rhombus/tissues.hpp"

namespace turgor::rhombus {
namespace {

constexpr double kTick = 1e-3;
constexpr double kRadius = 0.005;

Model model_of(Surface surface, const Params& params = {}) {
  return *build({std::move(surface.vertices), std::move(surface.triangles), {}}, params);
}

TouchForce tick(const Model& model, State& state, const TouchInput& input) {
  TouchForce force;
  solve_touches(model, state, {&input, 1}, kTick, {&force, 1});
  return force;
}

/// Input of a tip at a position, holding for grip > 0.
TouchInput tip(Vec3d position, double grip = 0, double opening = 0) {
  return {.position = position, .radius = kRadius, .grip = grip, .opening = opening};
}

double volume(const Surface& s, const State* state) {
  double sum = 0;
  for (const Int3 t : s.triangles) {
    const auto x = [&](int v) {
      return s.vertices[std::size_t(v)] + (state ? state->displacement[std::size_t(v)] : Vec3d{});
    };
    sum += dot(x(t.x), cross(x(t.y), x(t.z))) / 6;
  }
  return sum;
}

// The displacement of every vertex is the chain's shape at its geodesic distance.
TEST(RhombusStep, DentHasChainShape) {
  const Model model = model_of(test::slab(0.2, 40, 0.3));
  State state = make_state(model, 1);
  const double depth = 0.008;
  const Vec3d contact{0.0031, -0.0017, 0};
  tick(model, state, tip(contact + Vec3d{0, 0, kRadius - depth}));
  step(Exec(1), model, state);
  const ChainShape shape = shape_of_force(model.chain, force_of_depth(model.chain, depth));
  int inside = 0;
  for (std::size_t v = 0; v < model.surface.vertices.size(); v++) {
    const Vec3d x = model.surface.vertices[v], u = state.displacement[v];
    if (x.z < -1e-9) continue;
    const double distance = norm(x - contact);
    const ShapePoint expected = shape_at(shape, distance / unit_width(model.chain));
    EXPECT_NEAR(-u.z, expected.depth, 1e-9);
    EXPECT_NEAR(dot(u, (x - contact) / distance), expected.outward, 1e-9) << "outward from the axis";
    inside += expected.depth > 0;
    if (distance > shape.units * unit_width(model.chain)) {
      EXPECT_EQ(u, Vec3d{}) << "outside the boundary";
    }
  }
  EXPECT_GT(inside, 200);
}

// The deformation is continuous over the surface.
TEST(RhombusStep, DeformationIsContinuous) {
  // Finer triangles give no steeper displacement, so it is continuous.
  for (const int cells : {30, 60, 120}) {
    const Model model = model_of(test::slab(0.2, cells, 0.3));
    State state = make_state(model, 1);
    tick(model, state, tip({0.001, 0.002, kRadius - 0.01}));
    step(Exec(1), model, state);
    double steepest = 0;
    for (const Int3 t : model.surface.triangles)
      for (int i = 0; i < 3; i++) {
        const auto a = std::size_t(t[i]), b = std::size_t(t[(i + 1) % 3]);
        steepest = std::max(steepest, norm(state.displacement[a] - state.displacement[b]) /
                                          norm(model.surface.vertices[a] - model.surface.vertices[b]));
      }
    std::printf("triangles of %.1f mm: steepest %.2f\n", model.surface.mean_edge * 1e3, steepest);
    EXPECT_LT(steepest, 1);
  }
}

// Vertices move smoothly while the contact slides.
TEST(RhombusStep, SlidingTouchMovesSmoothly) {
  const Model model = model_of(test::sphere(0.06, 4));
  State state = make_state(model, 1);
  const Exec exec(1);
  std::vector<Vec3d> before;
  double largest = 0;
  for (int i = 0; i < 400; i++) {
    const double a = i * 1e-4 / 0.06;
    const Vec3d direction = normalized(Vec3d{std::cos(a), std::sin(a), 0.31});
    tick(model, state, tip(direction * (0.06 + kRadius - 0.008)));
    step(exec, model, state);
    for (std::size_t v = 0; v < before.size(); v++)
      largest = std::max(largest, norm(state.displacement[v] - before[v]));
    before = state.displacement;
  }
  std::printf("sliding 0.1 mm per picture: the fastest vertex moves %.3f mm\n", largest * 1e3);
  EXPECT_LT(largest, 3e-4);
}

// The bulge compensates the given fraction of the pressed or pulled volume.
TEST(RhombusStep, BulgeKeepsVolume) {
  for (const double fraction : {0.5, 1.0})
    for (const bool pulled : {false, true}) {
      const Model model = model_of(test::sphere(0.06, 5), {.bulge = fraction});
      State state = make_state(model, 1);
      tick(model, state, tip({0, 0, 0.06 + kRadius - 0.004}));
      if (pulled) {
        tick(model, state, tip({0, 0, 0.06 + kRadius - 0.004}, 1));
        tick(model, state, tip({0, 0, 0.06 + kRadius + 0.006}, 1));
      }
      const StepReport report = step(Exec(1), model, state);
      const double lost = volume(model.surface, nullptr) - volume(model.surface, &state);
      EXPECT_GT(pulled ? -report.pressed_volume : report.pressed_volume, 5e-8);
      EXPECT_NEAR(lost / report.pressed_volume, 1 - fraction, 1e-6);
      double highest = 0;
      for (std::size_t v = 0; v < state.displacement.size(); v++)
        highest = std::max(highest, dot(state.displacement[v], model.surface.normals[v]));
      if (!pulled) {
        EXPECT_GT(highest, 1e-5) << "the surface rises around the press";
      }
    }
}

// Held tissue follows the jaws, and its force opposes the pull.
TEST(RhombusStep, HeldTissueFollowsJaws) {
  const Model model = model_of(test::slab(0.2, 80, 0.3));
  State state = make_state(model, 1);
  const double press = 0.002;
  const Vec3d start{0.0, 0.0, kRadius - press};
  const TouchForce pressed = tick(model, state, tip(start));
  const TouchForce held = tick(model, state, tip(start, 1));
  EXPECT_TRUE(held.holding);
  EXPECT_NEAR(held.force.z, pressed.force.z, 1e-12) << "no jump while the jaws close";
  const Vec3d pull{0.004, 0.001, 0.008};
  const TouchForce force = tick(model, state, tip(start + pull, 1));
  EXPECT_LT(dot(force.force, pull), 0);
  step(Exec(1), model, state);
  double nearest = 1;
  std::size_t at = 0;
  for (std::size_t v = 0; v < model.surface.vertices.size(); v++)
    if (const double d = norm(model.surface.vertices[v]); d < nearest) nearest = d, at = v;
  const Vec3d expected = pull - Vec3d{0, 0, press};
  EXPECT_LT(norm(state.displacement[at] - expected), 0.15 * norm(expected));
}

// A release has no force jump, and the tissue returns to rest.
TEST(RhombusStep, ReleaseIsContinuous) {
  const Model model = model_of(test::slab(0.2, 40, 0.3));
  State state = make_state(model, 1);
  const Vec3d start{0, 0, kRadius - 0.002};
  tick(model, state, tip(start));
  tick(model, state, tip(start, 1));
  double largest = 0;
  Vec3d before = tick(model, state, tip(start, 1)).force;
  for (int i = 1; i <= 2000; i++) {  // 10 mm out, then the jaws open over a second
    const double pulled = std::min(i, 1000) * 1e-5, grip = i > 1000 ? 1 - (i - 1000) * 1e-3 : 1;
    const Vec3d force = tick(model, state, tip(start + Vec3d{0, 0, pulled}, grip)).force;
    largest = std::max(largest, norm(force - before));
    before = force;
  }
  std::printf("pulling 10 mm and releasing: largest jump per tick %.2e N\n", largest);
  EXPECT_LT(largest, 1e-3);
  EXPECT_EQ(before, Vec3d{});
  EXPECT_EQ(step(Exec(1), model, state).largest_displacement, 0);
}

// Jaws that close in the air hold nothing until they have opened again.
TEST(RhombusStep, JawsClosedInAirHoldNothing) {
  const Model model = model_of(test::slab(0.2, 40, 0.3));
  State state = make_state(model, 1);
  EXPECT_FALSE(tick(model, state, tip({0, 0, 0.02}, 1)).holding);
  EXPECT_FALSE(tick(model, state, tip({0, 0, kRadius - 0.003}, 1)).holding)
      << "still closed: the jaws only press";
  tick(model, state, tip({0, 0, kRadius - 0.003}, 0));
  EXPECT_TRUE(tick(model, state, tip({0, 0, kRadius - 0.003}, 0.5)).holding);
}

// Closing jaws raise a fold between them.
TEST(RhombusStep, ClosingJawsRaiseFold) {
  const Model model = model_of(test::slab(0.1, 100, 0.3));
  State state = make_state(model, 1);
  const Vec3d start{0, 0, kRadius - 0.001};
  tick(model, state, tip(start, 0, 0.012));
  tick(model, state, tip(start, 0.01, 0.012));
  const TouchForce closed = tick(model, state, tip(start, 1, 0.002));
  EXPECT_GT(closed.squeeze, 0);
  step(Exec(1), model, state);
  double widest = 0, highest = -1;
  for (std::size_t v = 0; v < model.surface.vertices.size(); v++) {
    const Vec3d x = model.surface.vertices[v], now = x + state.displacement[v];
    if (x.z < -1e-9 || norm(x) > 0.0055) continue;
    widest = std::max(widest, std::abs(now.x)), highest = std::max(highest, now.z);
  }
  EXPECT_LT(widest, 0.0025) << "tissue 12 mm wide is between the jaws";
  EXPECT_GT(highest, 0.002) << "and rises";
}

// One, two and eight threads give the same bits.
TEST(RhombusStep, EqualBitsOnAnyThreads) {
  std::uint64_t first = 0;
  for (const int threads : {1, 2, 8}) {
    const Exec exec(threads);
    const Model model = model_of(test::sphere(0.06, 5), {.bulge = 0.8});
    State state = make_state(model, 2);
    for (int i = 0; i < 20; i++) {
      const TouchInput inputs[2] = {tip({0.001 * i, 0, 0.06}), tip({0, 0.061, 0.0007 * i}, i > 4 ? 1 : 0)};
      TouchForce forces[2];
      solve_touches(model, state, inputs, kTick, forces);
      step(exec, model, state);
    }
    if (threads == 1) first = state_hash(state);
    EXPECT_EQ(state_hash(state), first);
  }
}

// Invalid surfaces and parameters are rejected with a message.
TEST(RhombusStep, RejectsInvalidBodies) {
  const Surface good = test::sphere(0.05, 2);
  const auto message = [&](Body body, const Params& params = {}) {
    const Result<Model> model = build(std::move(body), params);
    return model ? std::string("built") : model.error().message;
  };
  const Body body{good.vertices, good.triangles, {}};
  EXPECT_EQ(message(body), "built");
  Body open = body;
  open.triangles.pop_back();
  EXPECT_NE(message(open).find("the surface is open: 3 edges have a triangle on one side only"),
            std::string::npos)
      << message(open);
  Body isolated = body;
  isolated.vertices.push_back({1, 2, 3});
  EXPECT_EQ(message(isolated), "1 vertices belong to no triangle, the first of them is vertex 162");
  Body crowded = body;
  for (const Int3 t : {Int3{0, 1, 2}, Int3{0, 2, 1}, Int3{0, 1, 2}, Int3{0, 2, 1}})
    crowded.triangles.push_back(t);
  EXPECT_NE(message(crowded), "built");
  Body turned = body;
  std::swap(turned.triangles[0].x, turned.triangles[0].y);
  EXPECT_NE(message(turned).find("have the same direction"), std::string::npos);
  Body inside_out = body;
  for (Int3& t : inside_out.triangles) std::swap(t.x, t.y);
  EXPECT_NE(message(inside_out).find("inside out"), std::string::npos);
  Body missing = body;
  missing.triangles[5].z = 162;
  EXPECT_EQ(message(missing), "triangle 5: expected vertices from 0 to 161, found 162");
  Body not_finite = body;
  not_finite.vertices[7].y = std::nan("");
  EXPECT_EQ(message(not_finite), "vertex 7: its position is not finite");
  EXPECT_EQ(message({}), "the surface has no triangles");
  Body soft = body;
  soft.stiffness.assign(162, 1.0), soft.stiffness[3] = 0;
  EXPECT_EQ(message(soft), "stiffness of vertex 3: expected a number above 0, found 0");
  soft.stiffness.resize(10);
  EXPECT_EQ(message(soft), "stiffness: expected one number for each of the 162 vertices, found 10");
  EXPECT_EQ(message(body, {.bulge = 1.5}), "bulge: expected a fraction from 0 to 1, found 1.5");
  EXPECT_EQ(message(body, {.viscosity = one_pair(1, 0)}), "relaxation time: expected more than 0 s, found 0");
  EXPECT_NE(message(body, {.chain = {.angle = 2}}), "built");
}

// ------------------------------------------------------------ distributed loads

constexpr double kYoung = 4e3, kContactModulus = kYoung / 0.75;  // of incompressible tissue [Pa]

/// A load of 1 kPa on a circle of the top, distributed by the area of each vertex, and its displacements.
struct Pressed {
  Model model;
  std::vector<Load> loads;
  double radius = 0;  // of a circle with the loaded area [m]
  std::vector<Vec3d> moved;
};
Pressed press_circle(int cells, double radius, Vec3d direction, double stiffness = 1) {
  constexpr double kPressure = 1e3;
  Surface surface = test::slab(0.3, cells, 0.3);
  std::vector<double> map(stiffness == 1 ? 0 : surface.vertices.size(), stiffness);
  Params params;
  params.chain = chain_of_modulus(kYoung);
  Pressed made{
      *build({std::move(surface.vertices), std::move(surface.triangles), std::move(map)}, params), {}, 0, {}};
  double area = 0;
  for (std::size_t v = 0; v < made.model.surface.vertices.size(); v++) {
    const Vec3d x = made.model.surface.vertices[v];
    if (x.z < -1e-9 || std::hypot(x.x, x.y) > radius) continue;
    made.loads.push_back({int(v), direction * (kPressure * made.model.area[v])});
    area += made.model.area[v];
  }
  made.radius = std::sqrt(area / std::numbers::pi);
  displacements_of(Exec(2), made.model, made.loads, made.moved);
  return made;
}

Vec3d displacement_at(const Pressed& pressed, Vec3d position) {
  const TrianglePoint at = nearest_point(pressed.model.tree, position);
  const Int3 t = pressed.model.surface.triangles[std::size_t(at.triangle)];
  Vec3d sum;
  for (int k = 0; k < 3; k++) sum += pressed.moved[std::size_t(t[k])] * at.weights[k];
  return sum;
}

// Uniform pressure on a circle sinks as in Love's half space, on any mesh.
TEST(RhombusStep, PressureOnCircleMatchesLove) {
  for (const auto& [cells, radius] : {std::pair{60, 0.03}, {100, 0.03}, {100, 0.02}}) {
    const Pressed pressed = press_circle(cells, radius, {0, 0, -1});
    const double a = pressed.radius, middle = 2 * 1e3 * a / kContactModulus;
    EXPECT_NEAR(-displacement_at(pressed, {}).z, middle, 0.03 * middle) << cells << ": 2 p a / E*";
    double edge = 0;
    for (int k = 0; k < 16; k++)
      edge -= displacement_at(pressed, {a * std::cos(k * 0.3927), a * std::sin(k * 0.3927), 0}).z / 16;
    EXPECT_NEAR(edge, middle * 2 / std::numbers::pi, 0.03 * middle) << cells << ": 4 p a / (pi E*)";
    EXPECT_NEAR(-displacement_at(pressed, {3 * a, 0, 0}).z, middle / 6 * 1.014, 0.01 * middle)
        << cells << ": P / (pi E* r), slightly more since the circle is wide";
    EXPECT_NEAR(displacement_at(pressed, {0, 2 * a, 0}).y, 0, 0.01 * middle) << "incompressible tissue";
  }
}

// Uniform shear moves the center of a circle by 3 q a / E*, minus the softening of each vertex.
TEST(RhombusStep, ShearOnCircleMatchesHalfSpace) {
  for (const int cells : {60, 100, 150}) {
    const Pressed pressed = press_circle(cells, 0.03, {0.6, 0.8, 0});
    const double expected = 3 * 1e3 * pressed.radius / kContactModulus, cell = 0.3 / cells;
    const double softened = 3 * std::numbers::pi / 8 * std::sqrt(cell * cell / std::numbers::pi);
    const Vec3d middle = displacement_at(pressed, {}), direction{0.6, 0.8, 0};
    EXPECT_NEAR(dot(middle, direction) / expected, 1 - 2 * softened / (3 * pressed.radius), 0.01) << cells;
    EXPECT_NEAR(norm(middle - direction * dot(middle, direction)), 0, 0.01 * expected) << cells;
  }
}

// Twice the stiffness halves the displacement; work is reciprocal (Betti) for varying stiffness.
TEST(RhombusStep, StiffnessScalesAndWorkIsReciprocal) {
  const Pressed soft = press_circle(40, 0.03, {0, 0, -1}), hard = press_circle(40, 0.03, {0, 0, -1}, 2);
  EXPECT_NEAR(displacement_at(hard, {}).z, 0.5 * displacement_at(soft, {}).z,
              1e-6 * norm(displacement_at(soft, {})));
  Surface ball = test::sphere(0.05, 3);
  std::vector<double> map;
  for (const Vec3d x : ball.vertices) map.push_back(1 + 10 * std::abs(x.x));
  const Model model = *build({std::move(ball.vertices), std::move(ball.triangles), std::move(map)}, Params());
  const Load first{7, {0.1, 0.2, -0.3}}, second{401, {-0.2, 0.05, 0.1}};
  std::vector<Vec3d> by_first, by_second;
  displacements_of(Exec(1), model, {&first, 1}, by_first);
  displacements_of(Exec(1), model, {&second, 1}, by_second);
  const double work = dot(by_first[401], second.force);
  EXPECT_NEAR(dot(by_second[7], first.force), work, 1e-5 * std::abs(work)) << "J, Betti";
  const double most = farthest_move(Exec(1), model, {&first, 1});
  EXPECT_NEAR(most, norm(by_first[7]), 1e-5 * most);
}

}  // namespace
}  // namespace turgor::rhombus
