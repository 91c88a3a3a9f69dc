// Sheets on obstacles by the loops that a GPU runs, in any order, against steps of the CPU.
#include "turgor/models/cloth/device/device_obstacles.hpp"

#include <functional>
#include <numbers>
#include <set>

#include "tests/models/cloth/meshes.hpp"
#include "tests/models/cloth/on_host.hpp"
#include "turgor/contact/cloth_obstacle.hpp"
#include "turgor/geometry/ball_mesh.hpp"

namespace turgor::cloth {
namespace {

using contact::Shape;
using ObstaclesAt = std::function<std::vector<Obstacle>(int frame)>;

struct Fall {
  Model model;
  ObstaclesAt obstacles;
  Vec3d gravity{0, 0, -9.81};
};

struct Lay {
  State state, early;  // at the end, and after three steps
  std::vector<ObstacleLoad> load, early_load;
  int contacts = 0, between = 0;  // most of a step, and those of triangles
};

std::vector<ObstacleLoad> loads(const State& state, std::size_t count) {
  std::vector<ObstacleLoad> all;
  for (std::size_t o = 0; o < count; o++) all.push_back(obstacle_load(state, int(o), {0.1, 0, 0}));
  return all;
}

/// On the CPU, or where `put` says, thrown about a little.
Lay fall(const Fall& f, int steps, Put put = nullptr) {
  DeviceState state = make_state(f.model);
  shake(f.model, state.change().v, 0.2);
  if (put) state.step_on(put(f.model));
  EXPECT_TRUE(state.hold(f.model, 0));
  Lay lay;
  for (int n = 0; n < steps; n++) {
    Inputs inputs{.gravity = f.gravity, .obstacles = f.obstacles(n)};
    inputs.air.velocity = {1, 2, -1};
    EXPECT_TRUE(state.step(Exec(1), f.model, inputs, kFrame).finite) << n;
    const std::vector<Contact>& list = state->contacts.list;
    lay.contacts = std::max(lay.contacts, int(list.size()));
    lay.between = std::max(
        lay.between,
        int(std::count_if(list.begin(), list.end(), [](const Contact& c) { return c.vertex[2] >= 0; })));
    if (n == 2) lay.early = *state, lay.early_load = loads(state, inputs.obstacles.size());
    if (n + 1 == steps) lay.load = loads(state, inputs.obstacles.size());
  }
  lay.state = *state;
  return lay;
}

/// Returns what the CPU did.
Lay expect_falls_like_the_cpu_s(const Fall& f, int steps = 10) {
  const Lay here = fall(f, steps);
  EXPECT_GT(here.contacts, 10);
  const Real rounding = 1e-2f, way = apart(f.model, here.early.x, f.model.x_rest);
  std::set<std::uint64_t> hashes;
  for (const Put put : kPuts) {
    const Lay there = fall(f, steps, put);
    hashes.insert(state_hash(f.model, there.state));
    EXPECT_LT(apart(f.model, there.early.x, here.early.x), rounding * way) << "m";
    EXPECT_EQ(there.early_load.size(), here.early_load.size());
    for (std::size_t o = 0; o < here.early_load.size(); o++) {
      const ObstacleLoad &a = there.early_load[o], &b = here.early_load[o];
      EXPECT_LT(norm(a.impulse - b.impulse), rounding * norm(b.impulse) + 1e-9) << "N s of " << o;
      EXPECT_LT(norm(a.moment - b.moment), rounding * norm(b.moment) + 1e-9) << "N m s of " << o;
    }
    if (!kSameBits) continue;
    EXPECT_EQ(there.contacts, here.contacts);
    EXPECT_EQ(there.between, here.between);
    for (std::size_t o = 0; o < here.load.size(); o++)
      EXPECT_EQ(norm(there.load[o].impulse - here.load[o].impulse), 0) << "N s of " << o;
    EXPECT_EQ(there.state.contacts.item, here.state.contacts.item);
  }
  if (kSameBits) hashes.insert(state_hash(f.model, here.state));
  EXPECT_EQ(hashes.size(), 1u);
  return here;
}

Model sheet_of(Pattern pattern, Law law, Integrator integrator, double size = 1, bool self = true) {
  Params params{.fabric = {.law = law, .poisson = law == Law::kSheet ? 0.2 : 0},
                .solver = {.integrator = integrator}};
  params.collision.self = self, params.collision.thickness = 0.008 * size;
  TriMesh mesh = rectangle(pattern, 0, 0.2 * size, 0.13 * size, 0.01 * size);
  const TriMesh other = rectangle(pattern, 0.25 * size, 0.33 * size, 0.06 * size, 0.01 * size);
  const int first = int(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), other.vertices.begin(), other.vertices.end());
  for (const Int3 t : other.triangles) mesh.triangles.push_back(t + Int3{first, first, first});
  return must_build(mesh, params);
}

/// Turned by an angle about an oblique axis.
contact::Pose turned(Vec3d position, double angle) {
  const Vec3d axis = normalized(Vec3d{1, 2, 0.5});
  contact::Pose pose{.position = position};
  for (Vec3d& e : pose.axes.column)
    e = e * std::cos(angle) + cross(axis, e) * std::sin(angle) +
        axis * (dot(axis, e) * (1 - std::cos(angle)));
  return pose;
}

TEST(cloth_obstacles_on, sheets_on_planes_and_a_ball_that_rises_step_in_any_order_as_on_the_cpu) {
  for (const Law law : {Law::kSprings, Law::kSheet})
    for (const Integrator integrator : {Integrator::kEuler, Integrator::kBdf2}) {
      const Shape ball = contact::Sphere{0.05};
      const auto at = [](int n) { return contact::Pose{.position = {0.1, 0.06, -0.055 + 0.004 * n}}; };
      const Lay lay = expect_falls_like_the_cpu_s(
          {.model = sheet_of(Pattern::kRandom, law, integrator), .obstacles = [&](int n) {
             std::vector<Obstacle> all{plane_obstacle({0.28, 0.03, 0}, {-0.2, 0.1, 1}),
                                       contact::cloth_obstacle(ball, at(n), at(n + 1), kFrame)};
             all[0].friction = 0.7, all[1].friction = 0.1, all[1].gap = 0.004;
             return all;
           }});
      EXPECT_LT(lay.load[0].impulse.z, -1e-4) << "N s, law " << int(law);
      EXPECT_LT(lay.load[1].impulse.z, -1e-4) << "N s, law " << int(law);
    }
}

TEST(cloth_obstacles_on, sheets_on_a_rod_that_turns_step_in_any_order_as_on_the_cpu) {
  const Shape rod = contact::Capsule{0.02, 0.07};
  const auto at = [](int n) { return turned({0.18, 0.1, -0.03 + 0.002 * n}, 0.7 + 0.1 * n); };
  for (const double size : {1.0, 2.0})
    expect_falls_like_the_cpu_s(
        {.model = sheet_of(Pattern::kEquilateral, Law::kSheet, Integrator::kBdf2, size, false),
         .obstacles = [&](int n) {
           return std::vector<Obstacle>{contact::cloth_obstacle(rod, at(n), at(n + 1), kFrame)};
         }});
}

TriMesh ball_at(Vec3 center, double radius, int halvings) {
  TriMesh mesh = ball_mesh(radius, halvings);
  for (Vec3& x : mesh.vertices) x += center;
  return mesh;
}

/// A bumpy ball that swells and goes aside.
TriMesh surface_at(int n) {
  TriMesh mesh = ball_at({0.1f, 0.05f, -0.06f}, 0.055, 3);
  for (Vec3& x : mesh.vertices)
    x = x * Real(1 + 0.004 * n) + Vec3{0.001f * Real(n), 0.004f * std::sin(80 * x.x), 0};
  return mesh;
}

TEST(cloth_obstacles_on, sheets_on_surfaces_that_move_and_that_rest_step_in_any_order_as_on_the_cpu) {
  const auto table = surface_obstacle(moving_surface(
      make_sheet(
          {.corner = {-0.5, -0.5, -0.083}, .side = {1, 0, 0.1}, .up = {0, 1, 0}, .columns = 5, .rows = 3}),
      {}, 0));
  for (const Pattern pattern : {Pattern::kRandom, Pattern::kAlternating}) {
    const Lay lay = expect_falls_like_the_cpu_s(
        {.model = sheet_of(pattern, Law::kSprings, Integrator::kEuler), .obstacles = [&](int n) {
           std::vector<Obstacle> all{
               table, surface_obstacle(moving_surface(surface_at(n), surface_at(n + 1).vertices, kFrame))};
           all[1].friction = 0.6;
           return all;
         }});
    EXPECT_LT(lay.load[0].impulse.z, -1e-4) << "N s";
    EXPECT_LT(lay.load[1].impulse.z, -1e-4) << "N s";
  }
}

TEST(cloth_obstacles_on, tools_smaller_than_cells_do_not_pass_between_vertices_in_any_order) {
  const Shape ball = contact::Sphere{0.0015}, rod = contact::Capsule{0.001, 0.02},
              block = *contact::mesh_shape(ball_mesh(0.012, 1), 12);
  const auto at = [](Vec3d place, int n) { return turned(place - Vec3d{0, 0, 0.002} * n, 0.3 + 0.1 * n); };
  const Lay lay = expect_falls_like_the_cpu_s(
      {.model = sheet_of(Pattern::kTall, Law::kSheet, Integrator::kEuler, 2, false),
       .obstacles =
           [&](int n) {
             std::vector<Obstacle> all;
             for (const auto& [shape, place] :
                  {std::pair(&ball, Vec3d{0.106, 0.051, 0.004}), std::pair(&rod, Vec3d{0.2, 0.1, 0.02}),
                   std::pair(&block, Vec3d{0.3, 0.13, 0.014})})
               all.push_back(contact::cloth_tool(*shape, at(place, n), at(place, n + 1), kFrame));
             return all;
           },
       .gravity = {0, 0, 9.81}});
  EXPECT_GT(lay.between, 3);
  for (const ObstacleLoad& load : lay.load) EXPECT_GT(load.impulse.z, 1e-6) << "N s";
}

TEST(cloth_obstacles_on, a_surface_that_rests_goes_over_once_and_obstacles_may_come_and_go) {
  using lattice::Bus;
  const Model model = sheet_of(Pattern::kDiagonal, Law::kSprings, Integrator::kEuler, 1, false);
  const Obstacle ball = surface_obstacle(moving_surface(ball_at({0.1f, 0.06f, -0.053f}, 0.05, 4), {}, 0));
  const std::size_t large = ball.moving->tree.boxes.nodes.size() * sizeof(BoxTree::Node);
  DeviceState state = make_state(model);
  state.step_on(put_on_host<lattice::SeededRun<3>>(model));
  Inputs inputs = in_vacuum();
  state.step(Exec(1), model, inputs, kFrame);
  inputs.obstacles = {ball};
  Bus::over = 0;
  state.step(Exec(1), model, inputs, kFrame);
  EXPECT_GT(Bus::over, large);
  Bus::over = 0;
  for (int n = 0; n < 3; n++) EXPECT_GT(state.step(Exec(1), model, inputs, kFrame).contacts, 10);
  EXPECT_LT(Bus::over, large / 10);
  inputs.obstacles = {plane_obstacle({0, 0, -0.02}, {0, 0, 1}), ball};
  EXPECT_GT(state.step(Exec(1), model, inputs, kFrame).contacts, 10) << "it is another one's place";
  inputs.obstacles.clear();
  EXPECT_EQ(state.step(Exec(1), model, inputs, kFrame).contacts, 0);
  EXPECT_TRUE(state->contacts.list.empty());
}

}  // namespace
}  // namespace turgor::cloth
