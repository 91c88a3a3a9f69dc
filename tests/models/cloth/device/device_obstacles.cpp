// Sheets on obstacles: the device loops, in any order, against steps of the CPU.
#include "turgor/models/cloth/device/device_obstacles.hpp"

#include <functional>
#include <numbers>
#include <set>

#include "tests/models/cloth/meshes.hpp"
#include "tests/models/cloth/on_host.hpp"
#include "turgor/contact/cloth_obstacle.hpp"
#include "turgor/geometry/ball_mesh.hpp"
#include "turgor/models/cloth/contact/contact.hpp"
#include "turgor/models/lattice/lattice.hpp"

namespace turgor::cloth {
namespace {

using contact::Shape;
using ObstaclesAt = std::function<std::vector<Obstacle>(int frame)>;

struct Fall {
  Model model;
  ObstaclesAt obstacles;
  Vec3d gravity{0, 0, -9.81};
};

struct FallResult {
  State state, early;  // at the end, and after three steps
  std::vector<ObstacleLoad> load, early_load;
  int contacts = 0, inside_triangles = 0;  // maxima of any step: all contacts, and those inside triangles
};

std::vector<ObstacleLoad> loads(const State& state, std::size_t count) {
  std::vector<ObstacleLoad> all;
  for (std::size_t o = 0; o < count; o++) all.push_back(obstacle_load(state, int(o), {0.1, 0, 0}));
  return all;
}

/// On the CPU, or on the backend of `put`, with small random velocities.
FallResult fall(const Fall& f, int steps, Put put = nullptr) {
  DeviceState state = make_state(f.model);
  shake(f.model, state.change().v, 0.2);
  if (put) state.use_backend(put(f.model));
  EXPECT_TRUE(state.hold(f.model, 0));
  FallResult result;
  for (int n = 0; n < steps; n++) {
    Inputs inputs{.gravity = f.gravity, .obstacles = f.obstacles(n)};
    inputs.air.velocity = {1, 2, -1};
    EXPECT_TRUE(state.step(Exec(1), f.model, inputs, kFrame).finite) << n;
    const std::vector<Contact>& list = state->contacts.list;
    result.contacts = std::max(result.contacts, int(list.size()));
    result.inside_triangles = std::max(
        result.inside_triangles,
        int(std::count_if(list.begin(), list.end(), [](const Contact& c) { return c.vertex[2] >= 0; })));
    if (n == 2) result.early = *state, result.early_load = loads(state, inputs.obstacles.size());
    if (n + 1 == steps) result.load = loads(state, inputs.obstacles.size());
  }
  result.state = *state;
  return result;
}

/// Returns the result of the CPU.
FallResult expect_fall_matches_cpu(const Fall& f, int steps = 10) {
  const FallResult host = fall(f, steps);
  EXPECT_GT(host.contacts, 10);
  const Real rounding = 1e-2f, displacement = max_distance(f.model, host.early.x, f.model.x_rest);
  std::set<std::uint64_t> hashes;
  for (const Put put : kPuts) {
    const FallResult device = fall(f, steps, put);
    hashes.insert(state_hash(f.model, device.state));
    EXPECT_LT(max_distance(f.model, device.early.x, host.early.x), rounding * displacement) << "m";
    EXPECT_EQ(device.early_load.size(), host.early_load.size());
    for (std::size_t o = 0; o < host.early_load.size(); o++) {
      const ObstacleLoad &a = device.early_load[o], &b = host.early_load[o];
      EXPECT_LT(norm(a.impulse - b.impulse), rounding * norm(b.impulse) + 1e-9) << "N s of " << o;
      EXPECT_LT(norm(a.moment - b.moment), rounding * norm(b.moment) + 1e-9) << "N m s of " << o;
    }
    if (!kSameBits) continue;
    EXPECT_EQ(device.contacts, host.contacts);
    EXPECT_EQ(device.inside_triangles, host.inside_triangles);
    for (std::size_t o = 0; o < host.load.size(); o++)
      EXPECT_EQ(norm(device.load[o].impulse - host.load[o].impulse), 0) << "N s of " << o;
    EXPECT_EQ(device.state.contacts.item, host.state.contacts.item);
  }
  if (kSameBits) hashes.insert(state_hash(f.model, host.state));
  EXPECT_EQ(hashes.size(), 1u);
  return host;
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

/// A pose rotated by an angle about an oblique axis.
contact::Pose rotated_pose(Vec3d position, double angle) {
  const Vec3d axis = normalized(Vec3d{1, 2, 0.5});
  contact::Pose pose{.position = position};
  for (Vec3d& e : pose.axes.column)
    e = e * std::cos(angle) + cross(axis, e) * std::sin(angle) +
        axis * (dot(axis, e) * (1 - std::cos(angle)));
  return pose;
}

// Sheets on planes and a rising ball match the CPU in any order of the loops.
TEST(ClothDeviceObstacles, PlanesAndRisingBallMatchCpu) {
  for (const Law law : {Law::kSprings, Law::kSheet})
    for (const Integrator integrator : {Integrator::kEuler, Integrator::kBdf2}) {
      const Shape ball = contact::Sphere{0.05};
      const auto at = [](int n) { return contact::Pose{.position = {0.1, 0.06, -0.055 + 0.004 * n}}; };
      const FallResult result = expect_fall_matches_cpu(
          {.model = sheet_of(Pattern::kRandom, law, integrator), .obstacles = [&](int n) {
             std::vector<Obstacle> all{plane_obstacle({0.28, 0.03, 0}, {-0.2, 0.1, 1}),
                                       contact::cloth_obstacle(ball, at(n), at(n + 1), kFrame)};
             all[0].friction = 0.7, all[1].friction = 0.1, all[1].gap = 0.004;
             return all;
           }});
      EXPECT_LT(result.load[0].impulse.z, -1e-4) << "N s, law " << int(law);
      EXPECT_LT(result.load[1].impulse.z, -1e-4) << "N s, law " << int(law);
    }
}

// Sheets on a rotating rod match the CPU in any order of the loops.
TEST(ClothDeviceObstacles, RotatingRodMatchesCpu) {
  const Shape rod = contact::Capsule{0.02, 0.07};
  const auto at = [](int n) { return rotated_pose({0.18, 0.1, -0.03 + 0.002 * n}, 0.7 + 0.1 * n); };
  for (const double size : {1.0, 2.0})
    expect_fall_matches_cpu(
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

/// A bumpy ball that grows and moves sideways.
TriMesh surface_at(int n) {
  TriMesh mesh = ball_at({0.1f, 0.05f, -0.06f}, 0.055, 3);
  for (Vec3& x : mesh.vertices)
    x = x * Real(1 + 0.004 * n) + Vec3{0.001f * Real(n), 0.004f * std::sin(80 * x.x), 0};
  return mesh;
}

// Sheets on moving and resting surfaces match the CPU in any order of the loops.
TEST(ClothDeviceObstacles, SurfacesMatchCpu) {
  const auto table = surface_obstacle(moving_surface(
      make_sheet(
          {.corner = {-0.5, -0.5, -0.083}, .side = {1, 0, 0.1}, .up = {0, 1, 0}, .columns = 5, .rows = 3}),
      {}, 0));
  for (const Pattern pattern : {Pattern::kRandom, Pattern::kAlternating}) {
    const FallResult result = expect_fall_matches_cpu(
        {.model = sheet_of(pattern, Law::kSprings, Integrator::kEuler), .obstacles = [&](int n) {
           std::vector<Obstacle> all{
               table, surface_obstacle(moving_surface(surface_at(n), surface_at(n + 1).vertices, kFrame))};
           all[1].friction = 0.6;
           return all;
         }});
    EXPECT_LT(result.load[0].impulse.z, -1e-4) << "N s";
    EXPECT_LT(result.load[1].impulse.z, -1e-4) << "N s";
  }
}

// Tools smaller than cells do not pass inside_triangles vertices in any order of the loops.
TEST(ClothDeviceObstacles, SmallToolsDoNotPass) {
  const Shape ball = contact::Sphere{0.0015}, rod = contact::Capsule{0.001, 0.02},
              block = *contact::mesh_shape(ball_mesh(0.012, 1), 12);
  const auto at = [](Vec3d position, int n) {
    return rotated_pose(position - Vec3d{0, 0, 0.002} * n, 0.3 + 0.1 * n);
  };
  const FallResult result = expect_fall_matches_cpu(
      {.model = sheet_of(Pattern::kTall, Law::kSheet, Integrator::kEuler, 2, false),
       .obstacles =
           [&](int n) {
             std::vector<Obstacle> all;
             for (const auto& [shape, position] :
                  {std::pair(&ball, Vec3d{0.106, 0.051, 0.004}), std::pair(&rod, Vec3d{0.2, 0.1, 0.02}),
                   std::pair(&block, Vec3d{0.3, 0.13, 0.014})})
               all.push_back(contact::cloth_tool(*shape, at(position, n), at(position, n + 1), kFrame));
             return all;
           },
       .gravity = {0, 0, 9.81}});
  EXPECT_GT(result.inside_triangles, 3);
  for (const ObstacleLoad& load : result.load) EXPECT_GT(load.impulse.z, 1e-6) << "N s";
}

// A resting surface is uploaded once; obstacles may be added and removed.
TEST(ClothDeviceObstacles, RestingSurfaceIsUploadedOnce) {
  using lattice::Transfers;
  const Model model = sheet_of(Pattern::kDiagonal, Law::kSprings, Integrator::kEuler, 1, false);
  const Obstacle ball = surface_obstacle(moving_surface(ball_at({0.1f, 0.06f, -0.053f}, 0.05, 4), {}, 0));
  const std::size_t large = ball.moving->tree.boxes.nodes.size() * sizeof(BoxTree::Node);
  DeviceState state = make_state(model);
  state.use_backend(put_on_host<lattice::SeededRun<3>>(model));
  Inputs inputs = in_vacuum();
  state.step(Exec(1), model, inputs, kFrame);
  inputs.obstacles = {ball};
  Transfers::uploaded = 0;
  state.step(Exec(1), model, inputs, kFrame);
  EXPECT_GT(Transfers::uploaded, large);
  Transfers::uploaded = 0;
  for (int n = 0; n < 3; n++) EXPECT_GT(state.step(Exec(1), model, inputs, kFrame).contacts, 10);
  EXPECT_LT(Transfers::uploaded, large / 10);
  inputs.obstacles = {plane_obstacle({0, 0, -0.02}, {0, 0, 1}), ball};
  EXPECT_GT(state.step(Exec(1), model, inputs, kFrame).contacts, 10) << "the index of another obstacle";
  inputs.obstacles.clear();
  EXPECT_EQ(state.step(Exec(1), model, inputs, kFrame).contacts, 0);
  EXPECT_TRUE(state->contacts.list.empty());
}

}  // namespace
}  // namespace turgor::cloth
