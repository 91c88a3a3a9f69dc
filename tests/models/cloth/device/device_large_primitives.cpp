// Sheets in triangles larger than their thickness by the loops that a GPU runs, in any order, against steps
// of the CPU.
#include "turgor/models/cloth/device/device_large_primitives.hpp"

#include <set>

#include "tests/models/cloth/meshes.hpp"
#include "tests/models/cloth/on_host.hpp"
#include "turgor/models/cloth/contact/obstacle.hpp"

namespace turgor::cloth {
namespace {

struct Crumple {
  Model model;
  double throw_speed = 0.4;  // of vertices, at random [m/s]
};

struct Crumpled {
  State state, early;   // at the end, and after three steps
  int corners[5] = {};  // contacts of so many vertices, most of a step
  int edges = 0;        // of two edges
  int in_impact_zone = 0;
};

bool is_of_edges(const Contact& c) { return c.vertex[3] >= 0 && c.weight[1] > 0; }

/// Pushed together over itself and onto a table, on the CPU or where `put` says.
Crumpled crumple(const Crumple& c, int steps, Put put = nullptr) {
  DeviceState state = make_state(c.model);
  shake(c.model, state.change().v, c.throw_speed, 3);
  if (put) state.step_on(put(c.model));
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

void expect_crumples_like_the_cpu_s(const Crumple& c, int steps = 8) {
  ASSERT_FALSE(c.model.coarse.triangles.empty());
  const Crumpled here = crumple(c, steps);
  EXPECT_GT(here.corners[4], 20) << "vertices and triangles, and edges";
  EXPECT_GT(here.edges, 5);
  const Real way = apart(c.model, here.early.x, c.model.x_rest);
  std::set<std::uint64_t> hashes;
  for (const Put put : kPuts) {
    const Crumpled there = crumple(c, steps, put);
    hashes.insert(state_hash(c.model, there.state));
    EXPECT_LT(apart(c.model, there.early.x, here.early.x), 1e-2f * way) << "m";
    EXPECT_EQ(self_distance(Exec(1), c.model, there.state).crossings, 0);
    if (!kSameBits) continue;
    EXPECT_EQ(there.in_impact_zone, here.in_impact_zone);
    for (int k = 0; k < 5; k++) EXPECT_EQ(there.corners[k], here.corners[k]) << k << " vertices";
    EXPECT_EQ(there.edges, here.edges);
    EXPECT_EQ(there.state.contacts.begin, here.state.contacts.begin);
    EXPECT_EQ(there.state.contacts.item, here.state.contacts.item);
  }
  if (kSameBits) hashes.insert(state_hash(c.model, here.state));
  EXPECT_EQ(hashes.size(), 1u);
}

TEST(cloth_coarse_on, large_triangles_and_edges_stay_apart_in_any_order_as_on_the_cpu) {
  for (const Law law : {Law::kSprings, Law::kSheet})
    for (const Integrator integrator : {Integrator::kEuler, Integrator::kBdf2})
      expect_crumples_like_the_cpu_s({coarse_sheet(Pattern::kAlternating, law, integrator, 1, 0.004)});
}

TEST(cloth_coarse_on, so_they_do_on_any_mesh_and_in_any_size) {
  expect_crumples_like_the_cpu_s(
      {coarse_sheet(Pattern::kRandom, Law::kSheet, Integrator::kEuler, 2, 0.0035), 0.8});
  expect_crumples_like_the_cpu_s(
      {coarse_sheet(Pattern::kLong, Law::kSprings, Integrator::kEuler, 1, 0.0014), 0.2}, 4);
  // Some of the triangles are large and some are not.
  expect_crumples_like_the_cpu_s(
      {coarse_sheet(Pattern::kRandom, Law::kSprings, Integrator::kBdf2, 0.5, 0.0094), 0.2});
}

}  // namespace
}  // namespace turgor::cloth
