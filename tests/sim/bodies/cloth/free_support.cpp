#include "turgor/sim/bodies/cloth/free_support.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <tuple>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/sim/bodies/cloth/cloth_scenes.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {
namespace {

using namespace test;

constexpr double kFall = 0.05;  // [m]

/// A square sheet of 0.4 m whose rim is held.
std::string held_sheet(int cells) {
  return fmt::format(R"(
[body.sheet]
model = "cloth"
sheet = {{ corner = [-0.2, -0.2, 0], side = [0.4, 0, 0], up = [0, 0.4, 0], columns = {0}, rows = {0} }}
fabric = {{ density = 0.2 }}
wind = {{ density = 0 }}
[body.sheet.obstacle.load]
body = "load"
[body.sheet.hold.left]
box = [[-1, -1, -1], [-0.199, 1, 1]]
[body.sheet.hold.right]
box = [[0.199, -1, -1], [1, 1, 1]]
[body.sheet.hold.front]
box = [[-1, -1, -1], [1, -0.199, 1]]
[body.sheet.hold.back]
box = [[-1, 0.199, -1], [1, 1, 1]]
)",
                     cells);
}
/// A ball of 30 mm, beside the middle of the sheet; `rest` adds keys.
std::string ball(double mass, const std::string& rest = "") {
  return fmt::format(
      "[body.load]\nmodel = \"rigid\"\nshape = {{ sphere = 0.03 }}\nat = [0.003, 0.002, {}]\nmass = {}\n{}\n",
      0.031 + kFall, mass, rest);
}
std::string box(double mass) {
  return fmt::format(
      "[body.load]\nmodel = \"rigid\"\nshape = {{ box = [0.06, 0.05, 0.04] }}\nat = [0.003, 0.002, {}]\n"
      "mass = {}\n",
      0.021 + kFall, mass);
}
/// A block of 10 kPa.
std::string soft_block(double mass) {
  return fmt::format(
      "[body.load]\nmodel = \"sfem\"\nblock = {{ corner = [-0.027, -0.028, {}], size = [0.06, 0.06, 0.03], "
      "count = [4, 4, 2] }}\nfixed = \"none\"\nyoung = 1e4\npoisson = 0.3\ndensity = {}\nprecision = "
      "\"double\"\ncache = false\n",
      0.001 + kFall, mass / (0.06 * 0.06 * 0.03));
}
std::string at_rate(double rate) {
  return fmt::format("[world]\ngravity = [0, 0, -9.81]\nframe_rate = {}\n", rate);
}

/// Height of the center of mass of the only body on the sheet [m].
double height(const World& world) {
  if (!world.rigid_bodies.empty()) return world.rigid_bodies[0].state.center.z;
  const SfemBody& body = world.sfem_bodies[0];
  double sum = 0, mass = 0;
  for (std::size_t v = 0; v < body.model.mass.size(); v++)
    sum += body.model.mass[v] * (body.model.body.mesh.vertices[v].z + body.free.before[v].z),
        mass += body.model.mass[v];
  return sum / mass;
}

/// Fall of a body on the sheet.
struct Landing {
  double lowest = 1, rebound = -1;  // height of its center: least, and largest after that [m]
  double last = 0;                  // height at the end [m]
  Vec3d force;                      // mean of the last half second, on the body [N]
  double sway = 0;                  // change of the height in the last half second [m]
};
Landing land(World& world, double seconds, const Exec& exec = Exec(1)) {
  Landing landing;
  const int frames = int(seconds / world.dt), half = int(0.5 / world.dt);
  double low = 1, high = -1;
  for (int n = 0; n < frames; n++) {
    run(world, 1, exec);
    const double z = height(world);
    if (z < landing.lowest) landing.lowest = z, landing.rebound = z;
    landing.rebound = std::max(landing.rebound, z);
    if (n >= frames - half) low = std::min(low, z), high = std::max(high, z);
  }
  landing.last = height(world), landing.sway = high - low;
  landing.force = mean_of_last(world.cloth_bodies[0].obstacles[0].force, std::size_t(half));
  return landing;
}

/// Least height of the sheet [m].
double lowest_vertex(const World& world) {
  const ClothBody& sheet = world.cloth_bodies[0];
  double low = 1;
  for (int v = 0; v < sheet.model.count; v++) low = std::min(low, double(sheet.state->x[std::size_t(v)].z));
  return low;
}

/// The sheet bears the whole weight, and the body has come to rest below the height from which it fell.
void expect_borne(const Landing& landing, double mass) {
  const double weight = mass * kGravity;
  EXPECT_NEAR(landing.force.z, weight, 0.01 * weight) << "N";
  EXPECT_LT(std::hypot(landing.force.x, landing.force.y), 0.01 * weight) << "N";
  EXPECT_LT(landing.rebound - landing.last, 0.5 * kFall) << "m, of a bounce";
  EXPECT_LT(landing.sway, 5e-4) << "m, in the last half second";
}

// ------------------------------------------------------------ rigid bodies

// A sheet that weighs 32 g bears balls of up to 0.5 kg that fall on it, at any rate and in any cells. No
// vertex is in the ball, and holds and sheet are in balance.
TEST(FreeSupport, FallingBallComesToRest) {
  for (const auto& [mass, rate, cells] :
       {std::tuple{0.05, 60.0, 20}, {0.5, 60.0, 20}, {0.5, 120.0, 20}, {0.2, 60.0, 40}}) {
    SCOPED_TRACE(fmt::format("{} kg at {} Hz, {} cells", mass, rate, cells));
    World world = must_load(at_rate(rate) + held_sheet(cells) + ball(mass));
    const Landing landing = land(world, 2);
    expect_borne(landing, mass);
    // no vertex is in the ball
    const Vec3d center = world.rigid_bodies[0].state.center;
    const ClothBody& sheet = world.cloth_bodies[0];
    double nearest = 1;
    for (int v = 0; v < sheet.model.count; v++)
      nearest = std::min(nearest, norm(Vec3d(sheet.state->x[std::size_t(v)]) - center));
    EXPECT_GT(nearest, 0.03) << "m";
    // holds bear both weights
    double held = 0;
    for (const ClothHold& hold : sheet.holds) held -= hold.force.back().z;
    const double inner = (mass + sheet.model.total_mass) * kGravity;
    EXPECT_NEAR(std::abs(held), inner, 0.02 * inner) << "N";
  }
}

// A box stays on the sheet. The sag does not depend on the frame rate, thus not on the motion before it.
TEST(FreeSupport, FallingBoxComesToRest) {
  double sag[2];
  for (int n = 0; n < 2; n++) {
    World world = must_load(at_rate(n == 0 ? 60 : 120) + held_sheet(20) + box(0.05));
    const Landing landing = land(world, 2);
    expect_borne(landing, 0.05);
    const double low = lowest_vertex(world);
    EXPECT_NEAR(world.rigid_bodies[0].state.center.z - 0.02 - low, 0, 0.006)
        << "m, of the bottom on the sheet";
    sag[n] = -low;
  }
  EXPECT_NEAR(sag[0], sag[1], 0.02 * sag[1]) << "m";
}

// The spin of a ball dies by friction with the sheet.
TEST(FreeSupport, SpinDies) {
  World world = must_load(at_rate(60) + held_sheet(20) + ball(0.2, "spin = [10, 20, 15]"));
  const Landing landing = land(world, 3);
  expect_borne(landing, 0.2);
  double most = 0;
  for (const RigidSample& sample : world.rigid_bodies[0].samples) most = std::max(most, norm(sample.spin));
  EXPECT_LT(most, 1.05 * norm(Vec3d{10, 20, 15})) << "rad/s";
  EXPECT_LT(norm(world.rigid_bodies[0].samples.back().spin), 1) << "rad/s";
}

// A ball that is thrown up from the sheet has the momentum of all impulses and of its weight.
TEST(FreeSupport, MomentumIsConserved) {
  World world = must_load(at_rate(60) + held_sheet(20) + ball(0.2));
  const double start = world.rigid_bodies[0].state.velocity.z;
  double impulse = 0;
  for (int n = 0; n < 30; n++) {
    run(world, 1);
    impulse += (world.cloth_bodies[0].obstacles[0].force.back().z - 0.2 * kGravity) * world.dt;
    EXPECT_NEAR(0.2 * (world.rigid_bodies[0].state.velocity.z - start), impulse, 1e-6) << "N s, frame " << n;
  }
}

// ------------------------------------------------------------ bodies of finite elements

// A soft block comes to rest on the sheet.
TEST(FreeSupport, SoftBlockComesToRest) {
  for (const double rate : {60.0, 120.0}) {
    SCOPED_TRACE(rate);
    World world = must_load(at_rate(rate) + held_sheet(20) + soft_block(0.108));
    expect_borne(land(world, 2), 0.108);
  }
}

// The same bits on any number of threads.
TEST(FreeSupport, EqualBitsOnAnyThreads) {
  for (const std::string& load : {ball(0.2), soft_block(0.108)}) {
    std::uint64_t hash[3];
    for (int n = 0; n < 3; n++) {
      const Exec exec(n == 0 ? 1 : n == 1 ? 2 : 8);
      World world = must_load(at_rate(60) + held_sheet(20) + load, {}, exec);
      run(world, 30, exec);
      hash[n] = state_hash(world);
    }
    EXPECT_EQ(hash[0], hash[1]);
    EXPECT_EQ(hash[0], hash[2]);
  }
}

}  // namespace
}  // namespace turgor
