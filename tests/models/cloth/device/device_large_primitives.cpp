// Sheets in triangles larger than their thickness: the device loops, in any order, against steps of the CPU.
#include "turgor/models/cloth/device/device_large_primitives.hpp"

#include <set>

#include "tests/models/cloth/meshes.hpp"
#include "tests/models/cloth/on_host.hpp"
#include "turgor/models/cloth/contact/obstacle.hpp"

namespace turgor::cloth {
namespace {

struct Crumple {
  Model model;
  double throw_speed = 0.4;  // of vertices, random [m/s]
};

struct Crumpled {
  State state, early;   // at the end, and after three steps
  int corners[5] = {};  // contacts by number of vertices, maximum of any step
  int edges = 0;        // contacts of two edges
  int in_impact_zone = 0;
};

bool is_of_edges(const Contact& c) { return c.vertex[3] >= 0 && c.weight[1] > 0; }

/// Crumples the sheet over itself and onto a table, on the CPU or on the backend of `put`.
Crumpled crumple(const Crumple& c, int steps, Put put = nullptr) {
  DeviceState state = make_state(c.model);
  shake(c.model, state.change().v, c.throw_speed, 3);
  if (put) state.use_backend(put(c.model));
  for (const int v : {0, 1, 2}) EXPECT_TRUE(state.hold(c.model, v));
  const Real length = Real(std::sqrt(c.model.area));
  Inputs inputs{.gravity = {0, 0, -9.81}, .obstacles = {plane_obstacle({0, 0, -0.1 * length}, {0.1, 0, 1})}};
  inputs.air.velocity = {-6, 1, 2};
  inputs.air.gusts = 0.5;
  Crumpled all;
  for (int n = 0; n < steps; n++) {
    for (const int v : {0, 1, 2})
      (void)state.move_hold(
          c.model, v,
          {0.03f * length * Real(n), 0.1f * length * Real(v), 0.1f * length * std::sin(0.5f * Real(n))});
    const StepReport report = state.step(Exec(1), c.model, inputs, kFrame);
    EXPECT_TRUE(report.finite) << n;
    all.in_impact_zone = std::max(all.in_impact_zone, report.in_impact_zone);
    int corners[5] = {}, edges = 0;
    for (const Contact& contact : state->contacts.list) {
      corners[std::count_if(contact.vertex.begin(), contact.vertex.end(), [](int v) { return v >= 0; })]++;
      edges += is_of_edges(contact);
    }
    for (int k = 0; k < 5; k++) all.corners[k] = std::max(all.corners[k], corners[k]);
    all.edges = std::max(all.edges, edges);
    if (n == 2) all.early = *state;
  }
  all.state = *state;
  return all;
}

Model coarse_sheet(Pattern pattern, Law law, Integrator integrator, double size, double thickness) {
  Params params{.fabric = {.law = law}, .solver = {.integrator = integrator}};
  params.collision.thickness = thickness * size;
  TriMesh mesh = rectangle(pattern, 0, 0.11 * size, 0.09 * size, 0.01 * size);
  const TriMesh other = rectangle(pattern, 0.02 * size, 0.09 * size, 0.05 * size, 0.01 * size);
  const int first = int(mesh.vertices.size());
  for (const Vec3 x : other.vertices) mesh.vertices.push_back(x + Vec3{0, 0, Real(0.012 * size)});
  for (const Int3 t : other.triangles) mesh.triangles.push_back(t + Int3{first, first, first});
  return must_build(mesh, params);
}

void expect_crumpling_matches_cpu(const Crumple& c, int steps = 8) {
  ASSERT_FALSE(c.model.large.triangles.empty());
  const Crumpled host = crumple(c, steps);
  EXPECT_GT(host.corners[4], 20) << "vertex-triangle and edge-edge contacts";
  EXPECT_GT(host.edges, 5);
  const Real displacement = max_distance(c.model, host.early.x, c.model.x_rest);
  std::set<std::uint64_t> hashes;
  for (const Put put : kPuts) {
    const Crumpled device = crumple(c, steps, put);
    hashes.insert(state_hash(c.model, device.state));
    EXPECT_LT(max_distance(c.model, device.early.x, host.early.x), 1e-2f * displacement) << "m";
    EXPECT_EQ(self_distance(Exec(1), c.model, device.state).crossings, 0);
    if (!kSameBits) continue;
    EXPECT_EQ(device.in_impact_zone, host.in_impact_zone);
    for (int k = 0; k < 5; k++) EXPECT_EQ(device.corners[k], host.corners[k]) << k << " vertices";
    EXPECT_EQ(device.edges, host.edges);
    EXPECT_EQ(device.state.contacts.begin, host.state.contacts.begin);
    EXPECT_EQ(device.state.contacts.item, host.state.contacts.item);
  }
  if (kSameBits) hashes.insert(state_hash(c.model, host.state));
  EXPECT_EQ(hashes.size(), 1u);
}

// Contacts of large triangles and edges match the CPU in any order of the loops.
TEST(ClothDeviceLargePrimitives, MatchesCpuInAnyOrder) {
  for (const Law law : {Law::kSprings, Law::kSheet})
    for (const Integrator integrator : {Integrator::kEuler, Integrator::kBdf2})
      expect_crumpling_matches_cpu({coarse_sheet(Pattern::kAlternating, law, integrator, 1, 0.004)});
}

// Contacts of large triangles match the CPU on any mesh and at any size.
TEST(ClothDeviceLargePrimitives, MatchesCpuOnAnyMesh) {
  expect_crumpling_matches_cpu(
      {coarse_sheet(Pattern::kRandom, Law::kSheet, Integrator::kEuler, 2, 0.0035), 0.8});
  expect_crumpling_matches_cpu(
      {coarse_sheet(Pattern::kLong, Law::kSprings, Integrator::kEuler, 1, 0.0014), 0.2}, 4);
  // Some triangles are large, others are not.
  expect_crumpling_matches_cpu(
      {coarse_sheet(Pattern::kRandom, Law::kSprings, Integrator::kBdf2, 0.5, 0.0094), 0.2});
}

}  // namespace
}  // namespace turgor::cloth
