// GPU memory that runs out during a run: bodies continue on the host, from the state before the step that
// lacked it.
#include <gtest/gtest.h>

#include "cuda_runtime.h"
#include "tests/models/cloth/sheets.hpp"
#include "tests/models/lattice/cut_block.hpp"
#include "turgor/core/gpu.hpp"
#include "turgor/core/hash.hpp"
#include "turgor/models/cloth/contact/obstacle.hpp"
#include "turgor/models/cloth/device/gpu_sheet.hpp"
#include "turgor/models/lattice/device/gpu_body.hpp"

namespace turgor {
namespace {

/// No device memory is free during its lifetime.
struct WithoutMemory {
  std::size_t free = open_gpu().value().free_bytes;
  WithoutMemory() { pretend_memory(0); }
  WithoutMemory(const WithoutMemory&) = delete;
  WithoutMemory& operator=(const WithoutMemory&) = delete;
  ~WithoutMemory() { pretend_memory(free); }
};

const Exec kAlone(1);

}  // namespace
}  // namespace turgor

namespace turgor::cloth {
namespace {

/// A shaken sheet above a plane that it does not touch yet, on the GPU.
struct FallingSheet {
  Model model;
  DeviceState state;
  Inputs inputs;

  FallingSheet(bool self, Integrator integrator, double strain_limit) {
    Params params;
    params.solver = {
        .integrator = integrator, .method = Method::kChebyshev, .sweeps = 8, .strain_limit = strain_limit};
    params.collision.self = self, params.collision.thickness = 0.0096;
    model = must_build(flat_sheet(20), params);
    State start = make_state(model);
    shake(model, start.v, 0.2);
    state = start;
    for (int v = 0; v < 5; v++) EXPECT_TRUE(state.hold(model, v));
    state.use_backend(put(open_gpu().value(), model).value());
    inputs.gravity = {0, 0, -9.81}, inputs.air.velocity = {1, 0.5, -1};
  }
  StepReport step() { return state.step(kAlone, model, inputs, kFrame); }
  /// Reaches the plane.
  void add_plane() { inputs.obstacles = {plane_obstacle({0, 0, 0.002}, {0.05, 0, 1})}; }
};

void expect_same_motion(const Model& model, const State& a, const State& b) {
  for (std::size_t v = 0; v < std::size_t(model.count); v++) {
    EXPECT_EQ(a.x[v], b.x[v]) << v;
    EXPECT_EQ(a.v[v], b.v[v]) << v;
  }
}

// Cloth whose contacts do not fit into memory continues on the host: its step has the bits of a host's step.
// A predicted state loses its history.
TEST(PretendedGpuMemory, ClothContinuesOnHost) {
  for (const bool self : {false, true})
    for (const Integrator integrator : {Integrator::kEuler, Integrator::kBdf2})
      for (const double limit : {0.0, 0.05}) {
        FallingSheet sheet(self, integrator, limit);
        for (int n = 0; n < 3; n++) EXPECT_TRUE(sheet.step().finite);
        sheet.add_plane();
        State host = sheet.state.host();
        host.history.dt = 0;
        const StepReport expected = step(kAlone, sheet.model, host, sheet.inputs, kFrame);
        const WithoutMemory lack;
        const StepReport found = sheet.step();
        EXPECT_GT(found.contacts, 20);
        EXPECT_EQ(found.contacts, expected.contacts);
        EXPECT_FALSE(sheet.state.has_device());
        EXPECT_TRUE(sheet.state.take_lack_of_memory());
        EXPECT_FALSE(sheet.state.take_lack_of_memory());
        expect_same_motion(sheet.model, sheet.state, host);
        EXPECT_TRUE(sheet.step().finite);
      }
}

// Contacts from before the lack of memory keep their impulses.
TEST(PretendedGpuMemory, ClothKeepsWarmStart) {
  FallingSheet sheet(true, Integrator::kEuler, 0);
  sheet.add_plane();
  for (int n = 0; n < 3; n++) EXPECT_TRUE(sheet.step().finite);
  const Contacts before = sheet.state->contacts;
  EXPECT_GT(before.list.size(), 20u);
  // a second obstacle below all vertices doubles the contacts
  sheet.inputs.obstacles.push_back(plane_obstacle({0, 0, 0.002}, {0, 0.05, 1}));
  State host = sheet.state.host();
  (void)step(kAlone, sheet.model, host, sheet.inputs, kFrame);
  const WithoutMemory lack;
  EXPECT_TRUE(sheet.step().finite);
  EXPECT_FALSE(sheet.state.has_device());
  expect_same_motion(sheet.model, sheet.state, host);
}

// Spare entries of lists are given up first.
TEST(PretendedGpuMemory, ListsGiveUpSpareEntries) {
  FallingSheet sheet(false, Integrator::kEuler, 0);
  EXPECT_TRUE(sheet.step().finite);
  sheet.add_plane();
  FallingSheet other(false, Integrator::kEuler, 0);
  EXPECT_TRUE(other.step().finite);
  other.add_plane();
  // memory that the contacts of an equal sheet take, with their spare entries
  const std::size_t before = open_gpu().value().free_bytes;
  EXPECT_TRUE(other.step().finite);
  const std::size_t taken = before - open_gpu().value().free_bytes;
  pretend_memory(taken * 5 / 6);
  EXPECT_TRUE(sheet.step().finite);
  pretend_memory(before - taken);
  EXPECT_TRUE(sheet.state.has_device());
}

}  // namespace
}  // namespace turgor::cloth

namespace turgor::lattice {
namespace {

struct OnGpu {
  Model model;
  DeviceState state;

  explicit OnGpu(TissueLaw law, bool coarse = false) {
    CutBlock block = cut_block(Method::kVbd, {13, 11, 9}, false, law);
    model = std::move(block.model), state = std::move(block.state);
    model.params.solver.coarse = coarse;
    state.use_backend(upload_model(open_gpu().value(), model).value());
  }
  StepReport step(std::span<NodeContact> contacts = {}) {
    return state.step(kAlone, model, inputs(contacts), kDt);
  }
  Inputs inputs(std::span<NodeContact> contacts = {}) const {
    return {.gravity = {1, 0, -9.81}, .contacts = contacts};
  }
  static constexpr double kDt = 1.0 / 60;
};

std::uint64_t hash_of(const VecField& field) {
  std::uint64_t hash = kHashSeed;
  for (const aligned_vector<Real>* axis : {&field.x, &field.y, &field.z})
    hash = hash_values(std::span(*axis), hash);
  return hash;
}
void expect_same_motion(const State& a, const State& b) {
  EXPECT_EQ(hash_of(a.motion.u), hash_of(b.motion.u));
  EXPECT_EQ(hash_of(a.motion.v), hash_of(b.motion.v));
  EXPECT_EQ(hash_values(std::span(a.motion.virtual_u), kHashSeed),
            hash_values(std::span(b.motion.virtual_u), kHashSeed));
  EXPECT_EQ(a.motion.time, b.motion.time);
}

// A body whose cut does not fit into memory continues on the host, with the bits of a body there.
TEST(PretendedGpuMemory, CutBodyContinuesOnHost) {
  OnGpu body(TissueLaw::kSolid), equal(TissueLaw::kSolid);
  for (int n = 0; n < 2; n++) EXPECT_TRUE(body.step().finite && equal.step().finite);
  const BladePath path =
      lay_blade(equal.model, equal.state, {.from = {0.012, 0.016, 0.032}, .to = {0.03, 0.016, 0.032}})
          .value();
  State host = equal.state.host();
  EXPECT_GT(cut_edges(equal.model, host, path, 0, 1, 1), 10);
  const WithoutMemory lack;
  ASSERT_TRUE(body.state.is_on_device());
  EXPECT_GT(body.state.cut_edges(body.model, path, 0, 1, 1), 10);
  EXPECT_FALSE(body.state.has_device());
  EXPECT_TRUE(body.state.take_lack_of_memory());
  expect_same_motion(body.state, host);
  (void)step(kAlone, equal.model, host, equal.inputs(), OnGpu::kDt);
  EXPECT_TRUE(body.step().finite);
  expect_same_motion(body.state, host);
}

// So does one whose contacts do not fit, and one whose coarse space does not.
TEST(PretendedGpuMemory, BodyInContactContinuesOnHost) {
  for (const bool coarse : {false, true}) {
    OnGpu body(TissueLaw::kSolid, coarse);
    std::vector<NodeContact> first = finger(body.model), contacts, host_contacts;
    EXPECT_TRUE(body.step(coarse ? first : contacts).finite) << "no coarse correction with contacts";
    if (!coarse) contacts = host_contacts = first;
    State host = body.state.host();
    (void)step(kAlone, body.model, host, body.inputs(host_contacts), OnGpu::kDt);
    EXPECT_EQ(host.workspace.coarse != nullptr, coarse);
    const WithoutMemory lack;
    EXPECT_TRUE(body.step(contacts).finite);
    EXPECT_FALSE(body.state.has_device()) << coarse;
    expect_same_motion(body.state, host);
    for (std::size_t n = 0; n < contacts.size(); n++) EXPECT_EQ(contacts[n].force, host_contacts[n].force);
  }
}

// A reader of some nodes downloads the whole state instead. The next step is on the GPU.
TEST(PretendedGpuMemory, ReadersOfNodesDownloadState) {
  OnGpu body(TissueLaw::kSprings), equal(TissueLaw::kSprings);
  EXPECT_TRUE(body.step().finite && equal.step().finite);
  const std::vector<int> nodes{node_slot(body.model.anatomy.lattice, 6, 5, 4)};
  {
    const WithoutMemory lack;
    body.state.read_nodes(nodes, [&](const State& now) { expect_same_motion(now, equal.state); });
    EXPECT_FALSE(body.state.is_on_device());
  }
  EXPECT_TRUE(body.step().finite && equal.step().finite);
  EXPECT_TRUE(body.state.is_on_device());
  EXPECT_FALSE(body.state.take_lack_of_memory());
  expect_same_motion(body.state, equal.state);
}

}  // namespace
}  // namespace turgor::lattice
