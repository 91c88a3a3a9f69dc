// Cloths that are tied to each other.
#include <cmath>

#include <fmt/format.h>

#include "organs_scene.hpp"
#include "tests/sim/resumed.hpp"
#include "turgor/sim/world_state.hpp"

namespace turgor {
namespace {

using test::advance;

constexpr double kTiedGravity = 9.81;  // [m/s²]

/// A sheet of 60 mm that hangs down from a height y, `high` meters.
std::string sheet_below(const std::string& name, double y, double high, int columns,
                        const std::string& keys = "") {
  return fmt::format(
      "[body.{}]\nmodel = \"cloth\"\nsheet = {{ corner = [-0.03, {}, 0], side = [0.06, 0, 0], up = [0, {}, "
      "0], "
      "columns = {}, rows = 6 }}\nwind = {{ density = 0 }}\ncollision.self = false\n{}",
      name, y, -high, columns, keys);
}
/// Springs between the upper edge of a sheet at height y and another body.
std::string tied_edge(const std::string& name, const std::string& sheet, const std::string& other, double y,
                      double stiffness) {
  return fmt::format(
      "[attachment.{}]\nbetween = [\"{}\", \"{}\"]\nbox = [[-1, {}, -1], [1, {}, 1]]\ndistance = "
      "0.01\npoints = 60\nstiffness = {}\n",
      name, sheet, other, y - 1e-4, y + 1e-4, stiffness);
}
std::string tied_header(const std::string& gravity = "[0, -9.81, 0]") {
  return "[world]\nduration = 20\ngravity = " + gravity + "\n";
}
/// Three sheets of different fabrics and meshes below each other. The first hangs from the ground.
std::string three_sheets(double seam) {
  const std::string damped = "damping.motion = 4\n";
  return tied_header() + sheet_below("first", 0, 0.04, 12, damped + "fabric.density = 0.3\n") +
         sheet_below("second", -0.0405, 0.02, 9, damped + "fabric.density = 0.1\n") +
         sheet_below("third", -0.061, 0.02, 7, damped + "fabric.density = 0.5\n") +
         tied_edge("top", "first", "ground", 0, 200) + tied_edge("seam", "second", "first", -0.0405, seam) +
         tied_edge("hem", "third", "second", -0.061, seam);
}
Vec3d force_of(const World& world, const std::string& name) {
  for (const Attachment& attachment : world.coupling.attachments)
    if (attachment.name == name) return attachment.samples.back().force;
  return {NAN, NAN, NAN};
}
double weight_below(const World& world, std::size_t first) {
  double mass = 0;
  for (std::size_t b = first; b < world.cloth_bodies.size(); b++)
    mass += world.cloth_bodies[b].model.total_mass;
  return mass * kTiedGravity;
}
Vec3d momentum_of(const World& world) {
  Vec3d sum;
  for (const ClothBody& body : world.cloth_bodies)
    for (std::size_t v = 0; v < std::size_t(body.model.count); v++)
      sum += Vec3d(body.state->v[v]) * double(body.model.mass[v]);
  return sum;
}

class TiedClothsOfStiffness : public testing::TestWithParam<double> {};

// Every seam bears the weight of the sheets below it, whether it is soft or much stiffer than the fabric.
TEST_P(TiedClothsOfStiffness, SeamsBearWeightBelow) {
  const Exec exec(2);
  World world = test::organs_world(exec, three_sheets(GetParam()));
  advance(exec, world, 240);
  const char* names[] = {"top", "seam", "hem"};
  for (std::size_t n = 0; n < 3; n++) {
    const double weight = weight_below(world, n);
    const Vec3d force = force_of(world, names[n]);
    std::printf("%s: %.6f N of %.6f N\n", names[n], force.y, weight);
    EXPECT_LT(norm(force - Vec3d{0, weight, 0}), 2e-3 * weight) << names[n];
  }
}
INSTANTIATE_TEST_SUITE_P(Seams, TiedClothsOfStiffness, testing::Values(10.0, 200.0, 1e5));

// A sheet that flies off pulls the other one with it: momentum is kept.
TEST(TiedCloths, KeepMomentum) {
  const Exec exec(2);
  const std::string free = "damping.motion = 0\n";
  World world = test::organs_world(
      exec, tied_header("[0, 0, 0]") + sheet_below("first", 0, 0.04, 12, free + "fabric.density = 0.3\n") +
                sheet_below("second", -0.0405, 0.02, 9, free + "fabric.density = 0.1\n") +
                tied_edge("seam", "second", "first", -0.0405, 100));
  cloth::State& state = world.cloth_bodies[0].state.change();
  for (std::size_t v = 0; v < std::size_t(world.cloth_bodies[0].model.count); v++)
    state.v.set(v, Vec3(Vec3d{0.02 * std::sin(double(v)), 0.05, 0.1}));
  const Vec3d before = momentum_of(world);
  Vec3d pulled;
  for (int frame = 0; frame < 60; frame++) {
    advance(exec, world, 1);
    pulled += force_of(world, "seam") * world.dt;
  }
  const Vec3d after = momentum_of(world);
  std::printf("momentum %.3e of %.3e kg m/s, pulled %.3e\n", norm(after), norm(before), norm(pulled));
  EXPECT_LT(norm(after - before), 2e-3 * norm(before));
  EXPECT_GT(norm(pulled), 0.1 * norm(before));
}

// A spring between cloths that is overloaded tears.
TEST(TiedCloths, WeakSeamTears) {
  const Exec exec(2);
  World world = test::organs_world(exec, three_sheets(200) + "break_force = 0.002\n");
  advance(exec, world, 60);
  EXPECT_TRUE(world.coupling.attachments[2].ties[0].broken);
  EXPECT_GT(world.coupling.attachments[2].torn_at, 0);
  EXPECT_EQ(force_of(world, "hem"), Vec3d{});
}

// A seam whose springs all bear ten times their strength opens as a whole.
TEST(TiedCloths, OverloadedSeamTearsAtOnce) {
  const Exec exec(2);
  World world = test::organs_world(exec, three_sheets(200));
  advance(exec, world, 240);
  std::vector<contact::Tie>& seam = world.coupling.attachments[2].ties;
  ASSERT_GT(seam.size(), 4u);
  for (contact::Tie& tie : seam) tie.strength = 0.1 * norm(tie.force);
  advance(exec, world, 2);
  for (const contact::Tie& tie : seam) EXPECT_TRUE(tie.broken);
}

// The same bits on any number of threads, after a copy and from a state file.
TEST(TiedCloths, SameBits) {
  const std::string text = three_sheets(200);
  World world = test::organs_world(Exec(1), text), resumed = test::organs_world(Exec(1), text);
  const LoadedPatches loaded = loaded_patches(world);
  advance(Exec(1), world, 10);
  World copy = copy_of(world), other = copy_of(world);
  advance(Exec(1), world, 10);
  advance(Exec(2), other, 10);
  advance(Exec(8), copy, 10);
  EXPECT_EQ(state_hash(copy), state_hash(world));
  EXPECT_EQ(state_hash(other), state_hash(world));
  EXPECT_NE(force_of(world, "seam"), Vec3d{});
  test::expect_resumes(Exec(2), test::fresh_folder() / "state.tgs", loaded, world, resumed);
}

}  // namespace
}  // namespace turgor
