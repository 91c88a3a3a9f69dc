// Lattices that nothing fixes: momentum of pairs, and contact with bodies of finite elements.
#include "turgor/sim/organs/free_lattice.hpp"

#include <cmath>

#include "swept_blocks.hpp"
#include "turgor/sim/organs/support.hpp"
#include "turgor/sim/world_state.hpp"

namespace turgor {
namespace {

using test::advance;
using test::block_text;
using test::blocks_world;
using test::contact_force;
using test::contact_text;
using test::kBlockGravity;
using test::lattice_text;
using test::whole_of;
using test::world_text;

/// The block with other sweeps and cells.
std::string free_block_text(const std::string& name, int sweeps, bool partial, const std::string& keys = "") {
  std::string text = lattice_text(name, "none", fmt::format("tissue.partial_cells = {}\n", partial) + keys);
  return text.replace(text.find("sweeps = 20"), 11, fmt::format("sweeps = {}", sweeps));
}

/// Gives all free nodes of a lattice a velocity [m/s].
void throw_block(World& world, const std::string& name, Vec3 velocity) {
  for (LatticeBody& body : world.lattice_bodies) {
    if (body.name != name) continue;
    lattice::Motion& motion = body.state.change().motion;
    for (std::size_t slot = 0; slot < body.model.anatomy.inverse_mass.size(); slot++)
      if (body.model.anatomy.inverse_mass[slot] > 0) motion.v.set(slot, velocity);
  }
}

/// Kinetic energy of a lattice [J].
double kinetic_energy_of(const World& world, const std::string& name) {
  const LatticeBody& body = test::body_named(world, name);
  double sum = 0;
  for (std::size_t slot = 0; slot < body.model.anatomy.inverse_mass.size(); slot++)
    if (const double w = double(body.model.anatomy.inverse_mass[slot]); w > 0)
      sum += 0.5 * dot(Vec3d(body.state->motion.v[slot]), Vec3d(body.state->motion.v[slot])) / w;
  return sum;
}

// Two free blocks that collide obliquely, off their centers, keep their momentum and win no energy: blocks of
// whole and of partial cells, of one height and of two, with few and with many sweeps.
TEST(FreeLattice, Pair_KeepsMomentum) {
  const Exec exec(2);
  struct Case {
    bool partial;
    int sweeps, height;
  };
  for (const auto& [partial, sweeps, height] : {Case{false, 20, 8},
                                                {true, 20, 8},
                                                {true, 5, 8},
                                                {true, 5, 4},
                                                {true, 20, 4},
                                                {true, 5, 12},
                                                {false, 20, 12},
                                                {false, 20, 4}}) {
    World world =
        blocks_world(exec, {{"first", -0.055}, {"second", -0.022, false, {0.012, 0, 0}, height}},
                     world_text("[0, 0, 0]") + free_block_text("first", sweeps, partial) +
                         free_block_text("second", sweeps, partial) + contact_text("first", "second", 0.3));
    throw_block(world, "first", {Real(0.03), Real(0.05), Real(-0.02)});
    const Vec3d before = whole_of(world, "first").momentum;
    const double energy = kinetic_energy_of(world, "first");
    advance(exec, world, 120);
    const Vec3d second = whole_of(world, "second").momentum,
                lost = before - whole_of(world, "first").momentum - second;
    const double now = kinetic_energy_of(world, "first") + kinetic_energy_of(world, "second");
    std::printf(
        "partial %d, %d sweeps: %.2g of the momentum is lost, %.3f is in the second block; energy %.3f\n",
        partial, sweeps, norm(lost) / norm(before), dot(second, before) / dot(before, before), now / energy);
    EXPECT_LT(norm(lost), 5e-4 * norm(before));
    EXPECT_GT(dot(second, before), 0.2 * dot(before, before));
    EXPECT_LT(now, energy);
  }
}

// Throws that differ by a thousandth end alike. A node that gets inside beside the other block's edge, and
// faces it only after both have turned, is pushed out slowly.
TEST(FreeLattice, Pair_EndsAlikeAfterLikeThrows) {
  const Exec exec(2);
  std::vector<double> energies;
  for (const double sideways : {0.03, 0.03001, 0.03003}) {
    World world =
        blocks_world(exec, {{"first", -0.055}, {"second", -0.022, false, {0.012, 0, 0}, 4}},
                     world_text("[0, 0, 0]") + free_block_text("first", 20, false) +
                         free_block_text("second", 20, false) + contact_text("first", "second", 0.3));
    throw_block(world, "first", {Real(sideways), Real(0.05), Real(-0.02)});
    const double energy = kinetic_energy_of(world, "first");
    advance(exec, world, 120);
    energies.push_back((kinetic_energy_of(world, "first") + kinetic_energy_of(world, "second")) / energy);
  }
  for (const double energy : energies) {
    EXPECT_LT(energy, 1);
    EXPECT_NEAR(energy, energies[0], 0.02);
  }
}

// Momentum is balanced for a pair of free lattices alone: not if the ground, a fixed lattice, a fixed rigid
// body, a tool or a spring acts on one of them.
TEST(FreeLattice, OnlyFreePairs_BalanceMomentum) {
  const Exec exec(1);
  const std::string pair =
      world_text("[0, 9.81, 0]") + lattice_text("first", "none") + contact_text("first", "second", 0.3);
  const std::string ground =
      contact_text("second", "ground", 0.3, "through = [0, 0.03, 0]\nnormal = [0, -1, 0]\n");
  const std::string plate =
      "[body.plate]\nmodel = \"rigid\"\nshape = { box = [0.1, 0.02, 0.1] }\nat = [0, 0.03, 0]\nmass = "
      "1\nfixed = true\n" +
      contact_text("second", "plate", 0.3);
  const std::string finger =
      "[tool.finger]\nbody = \"second\"\nshape = { sphere = 0.012 }\npress = { at_fraction = [0.5, 0, 0.5], "
      "depth = 0.002, start = 0.2, duration = 0.3, hold = 9 }\n";
  const std::string glue =
      "[attachment.glue]\nbetween = [\"first\", \"second\"]\ndistance = 0.004\nstiffness = 500\n";
  struct Case {
    std::string name, fixed, more;
    bool balances;
  };
  for (const auto& [name, fixed, more, balances] : {Case{"free", "none", "", true},
                                                    {"ground", "none", ground, false},
                                                    {"fixed", "bone", "", false},
                                                    {"plate", "none", plate, false},
                                                    {"finger", "none", finger, false},
                                                    {"glue", "none", glue, false}}) {
    const World world =
        blocks_world(exec, {{"first", -0.055}, {"second", -0.022, fixed == "bone"}},
                     pair + lattice_text("second", fixed, fixed == "bone" ? "gravity = false\n" : "") + more);
    for (const LatticeBody& body : world.lattice_bodies) {
      lattice::Inputs inputs;
      set_free_motion(world, body, inputs);
      EXPECT_EQ(inputs.balances_momentum, balances) << name << ", " << body.name;
      EXPECT_EQ(inputs.start_acceleration, Vec3d{}) << name << ", " << body.name;
    }
  }
}

// A free pair has the same bits on any number of threads.
TEST(FreeLattice, Pair_SameBits) {
  std::vector<std::uint64_t> hashes;
  for (const int threads : {1, 2, 8}) {
    const Exec exec(threads);
    World world = blocks_world(exec, {{"first", -0.055}, {"second", -0.022}},
                               world_text("[0, 0, 0]") + free_block_text("first", 5, true) +
                                   free_block_text("second", 5, true) + contact_text("first", "second", 0.3));
    throw_block(world, "first", {0, Real(0.05), 0});
    advance(exec, world, 24);
    ASSERT_NE(whole_of(world, "second").momentum, Vec3d{});
    hashes.push_back(state_hash(world));
  }
  EXPECT_EQ(hashes[1], hashes[0]);
  EXPECT_EQ(hashes[2], hashes[0]);
}

/// Momentum of a body of finite elements [N s].
Vec3d momentum_of(const SfemBody& body) {
  Vec3d sum;
  for (std::size_t v = 0; v < body.flight->v.size(); v++) sum += body.flight->v[v] * body.model.mass[v];
  return sum;
}

/// A free block above a slab of elements of 32 mm, 1 mm apart.
World block_on_elements(const Exec& exec, const std::string& fixed, double young, const std::string& keys,
                        const std::string& gravity, bool partial = false, int sweeps = 20) {
  std::string text =
      world_text(gravity) + free_block_text("block", sweeps, partial, keys) +
      block_text("slab", "[-0.04, -0.022, -0.04]", "[0.08, 0.032, 0.08]", "[8, 3, 8]", fixed, young);
  if (fixed == "none") text += "density = 1000\n";
  return blocks_world(exec, {{"block", -0.055}}, text + contact_text("block", "slab", 0.3, "sites = 300\n"));
}

// A free block falls on fixed elements and rests there, whether these are softer or stiffer: the contact and
// the lattice bear its weight.
TEST(FreeLattice, OnFixedElements_BearsWeight) {
  const Exec exec(2);
  struct Case {
    double elements, block;
    bool partial;
  };
  for (const auto& [elements, block, partial] :
       {Case{2e4, 5e3, false}, {2e4, 5e3, true}, {1e5, 5e3, false}, {1e4, 1e5, true}}) {
    World world = block_on_elements(exec, "back", elements, fmt::format("tissue.young = {}\n", block),
                                    "[0, 9.81, 0]", partial);
    advance(exec, world, 120);
    const double weight = whole_of(world, "block").mass * kBlockGravity;
    double least = HUGE_VAL, most = 0;
    for (int n = 0; n < 30; n++) {
      advance(exec, world, 1);
      least = std::min(least, -contact_force(world).y), most = std::max(most, -contact_force(world).y);
    }
    std::printf("%.0f on %.0f Pa: %.4f to %.4f of %.4f N, %.2g m/s, sank %.2f mm\n", block, elements, least,
                most, weight, norm(whole_of(world, "block").momentum) / whole_of(world, "block").mass,
                1e3 * whole_of(world, "block").displacement.y);
    EXPECT_NEAR(least, weight, (partial ? 1e-3 : 0.05) * weight);
    EXPECT_NEAR(most, weight, (partial ? 1e-3 : 0.05) * weight);
  }
}

// A free block that flies into free elements keeps the momentum of both, and they part.
TEST(FreeLattice, AgainstFreeElements_KeepsMomentum) {
  const Exec exec(2);
  for (const double young : {5e3, 2e4, 1e5}) {
    World world = block_on_elements(exec, "none", young, "", "[0, 0, 0]");
    throw_block(world, "block", {Real(0.02), Real(0.05), Real(-0.01)});
    const Vec3d before = whole_of(world, "block").momentum;
    double most = 0;
    for (int n = 0; n < 120; n++) {
      advance(exec, world, 1);
      most = std::max(most, norm(contact_force(world)));
    }
    const Vec3d block = whole_of(world, "block").momentum, slab = momentum_of(world.sfem_bodies[0]);
    std::printf("%.0f Pa: lost %.2g, in the elements %.3f, in the block %.3f; most %.3f N\n", young,
                norm(before - block - slab) / norm(before), dot(slab, before) / dot(before, before),
                dot(block, before) / dot(before, before), most);
    EXPECT_LT(norm(before - block - slab), 1e-3 * norm(before));
    EXPECT_GT(dot(slab, before), 0.3 * dot(before, before));
    EXPECT_LT(dot(slab, before), 1.0 * dot(before, before));
  }
}

// A finger presses a free block that lies on elements: these bear the finger and the weight, which tremble.
TEST(FreeLattice, OnElementsUnderFinger_BearsBoth) {
  const Exec exec(2);
  World world = block_on_elements(exec, "back", 2e4,
                                  "[tool.finger]\nbody = \"block\"\nshape = { sphere = 0.012 }\nfriction = "
                                  "0\npress = { at_fraction = [0.5, "
                                  "0, 0.5], depth = 0.004, start = 1, duration = 0.3, hold = 9 }\n",
                                  "[0, 9.81, 0]");
  advance(exec, world, 180);
  const double weight = whole_of(world, "block").mass * kBlockGravity;
  const Vec3d finger = world.tools[0].samples.back().force;
  std::printf("elements %.5f N, weight %.5f N, finger %.5f N\n", contact_force(world).y, weight, finger.y);
  EXPECT_LT(finger.y, -0.03);
  EXPECT_NEAR(contact_force(world).y, -weight + finger.y, 0.1 * weight);
}

// The reported force of the ground changes the momentum of a stiff block in every frame, also with few
// sweeps, whose forces are larger while the block settles.
TEST(FreeLattice, OnGround_ReportedForceChangesMomentum) {
  const Exec exec(2);
  for (const int sweeps : {5, 20}) {
    World world = blocks_world(
        exec, {{"block", -0.055}},
        world_text("[0, 9.81, 0]") + free_block_text("block", sweeps, false, "tissue.young = 3e4\n") +
            contact_text("block", "ground", 0.3, "through = [0, -0.0229, 0]\nnormal = [0, -1, 0]\n"));
    const double weight = whole_of(world, "block").mass * kBlockGravity;
    Vec3d before;
    double of_sites = 0;
    for (int frame = 0; frame < 60; frame++) {
      advance(exec, world, 1);
      const Vec3d now = whole_of(world, "block").momentum;
      const Vec3d force = (now - before) / world.dt - Vec3d{0, weight, 0};
      EXPECT_LT(norm(contact_force(world) - force), 2e-3 * weight) << frame;
      of_sites = std::max(
          of_sites,
          norm(total_force(world.coupling.contacts[0].sites, world.coupling.contacts[0].body[0]) - force));
      before = now;
    }
    std::printf("%d sweeps: forces of sites are up to %.3f weights off\n", sweeps, of_sites / weight);
    EXPECT_GT(of_sites, (sweeps == 5 ? 0.05 : 0) * weight) << "the sweeps converge: this tests nothing";
  }
}

}  // namespace
}  // namespace turgor
