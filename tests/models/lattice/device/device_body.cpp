// Whole steps by the device kernels, in any order, against steps of the CPU by colors.
#include "turgor/models/lattice/device/device_body.hpp"

#include <cmath>
#include <random>
#include <set>

#include "tests/models/host_backend.hpp"
#include "tests/models/lattice/cut_block.hpp"
#include "turgor/geometry/phantom.hpp"
#include "turgor/models/lattice/build/skin.hpp"

namespace turgor::lattice {
namespace {

const Exec kOne(1);
constexpr double kDt = 1.0 / 60;
#ifdef TURGOR_SAME_BITS
constexpr bool kSameBits = true;
#else
constexpr bool kSameBits = false;  // lanes and threads may contract different products
#endif

struct Variant {
  Method method;
  TissueLaw law = TissueLaw::kSprings;
  SkinLaw skin = SkinLaw::kFiber;
  bool volumes = false;
  Int3 size{13, 11, 9};
  bool coarse = false;  // without contacts, which the coarse space does not support
};

/// Tissue that differs from node to node, so that a mixed-up index is detected.
void mix_tissue(Model& model) {
  std::mt19937 random(5);
  std::uniform_real_distribution<Real> by(Real(0.5), 1);
  for (Real& w : model.anatomy.inverse_mass) w *= by(random);
  for (Real& root : model.springs.root_stiffness) root *= by(random);
}

/// A block whose second blade is laid after the first step and cuts before the fourth and the fifth one.
struct Scene {
  CutBlock block;
  std::vector<NodeContact> contacts;
  std::vector<NodeLoad> loads;

  explicit Scene(const Variant& v) : block(cut_block(v.method, v.size, v.volumes, v.law, v.skin)) {
    block.model.params.solver.coarse = v.coarse;
    mix_tissue(block.model);
    const Lattice& l = block.model.anatomy.lattice;
    const int top = l.size.z - 2;
    if (v.method == Method::kVbd && !v.coarse) contacts = finger(block.model);
    for (const int i : {9, 4, 9})
      loads.push_back({.slot = node_slot(l, i, 6, top), .force = {1e-3f * Real(i), 2e-3f, 5e-3f}});
  }
  Inputs inputs() {
    return {.gravity = {1, 0, -9.81}, .measure_residual = true, .loads = loads, .contacts = contacts};
  }
  static Incision second_blade(const Variant& v) {
    const int middle = v.size.y / 2;
    const double y = 0.004 * (middle - 1.5), z = 0.004 * (v.size.z - 1);
    return {.from = {0.012, y, z}, .to = {0.03, y, z}};
  }
};

struct Outcome {
  State state;
  std::vector<NodeContact> contacts;
  StepReport report;
};

/// On the CPU, or on the backend that `put` returns.
Outcome six_steps(const Variant& v,
                  const std::function<std::shared_ptr<BodyBackend>(const Model&)>& put = {}) {
  Scene scene(v);
  const Model& model = scene.block.model;
  DeviceState state = std::move(scene.block.state);
  if (put) state.use_backend(put(model));
  StepReport report;
  BladePath path;
  for (int n = 0; n < 6; n++) {
    if (n == 1) path = lay_blade(model, state, Scene::second_blade(v)).value();
    if (n >= 3 && n < 5) {
      const double begin = n == 3 ? 0 : 0.4;
      EXPECT_GT(state.cut_edges(model, path, begin, n == 3 ? 0.4 : 1, 1), 4);
    }
    report = state.step(kOne, model, scene.inputs(), kDt);
    EXPECT_TRUE(report.finite);
  }
  return {*state, scene.contacts, report};
}

void expect_near(const Model& model, const Outcome& device, const Outcome& host) {
  const StateDifference found = state_difference(model, device.state, host.state);
  EXPECT_GT(found.largest, 1e-3) << "m";
  EXPECT_LT(found.most, 2e-5 * found.largest) << "m";
  EXPECT_EQ(device.state.motion.time, host.state.motion.time);
  EXPECT_NEAR(device.state.motion.fastest, host.state.motion.fastest, 1e-4f * host.state.motion.fastest)
      << "m/s";
  ASSERT_EQ(device.state.motion.virtual_u.size(), host.state.motion.virtual_u.size());
  for (std::size_t c = 0; c < host.state.motion.virtual_u.size(); c++)
    EXPECT_NEAR(device.state.motion.virtual_u[c].z, host.state.motion.virtual_u[c].z, 2e-5 * found.largest)
        << "m, virtual node " << c;
  Real hardest = 0;
  for (const NodeContact& c : host.contacts) hardest = std::max(hardest, norm(c.force));
  for (std::size_t c = 0; c < host.contacts.size(); c++)
    EXPECT_LT(norm(device.contacts[c].force - host.contacts[c].force), 1e-3f * hardest) << "N";
  const Residual &a = device.report.residual, &b = host.report.residual;
  EXPECT_NEAR(a.before, b.before, 1e-3 * b.before) << "N";
  EXPECT_NEAR(a.rms, b.rms, 1e-3 * b.rms) << "N";
  EXPECT_NEAR(a.largest, b.largest, 1e-3 * b.largest) << "N";
}

void expect_steps_match_cpu(const Variant& v) {
  const Model model = Scene(v).block.model;
  const Outcome host = six_steps(v);
  EXPECT_EQ(host.state.motion.virtual_u.empty(), v.law == TissueLaw::kSprings);
  EXPECT_EQ(host.report.residual.rms > 0, v.method == Method::kVbd);
  std::set<std::uint64_t> hashes;
  for (const auto put : {put_on_host<ThreadedRun<1>>, put_on_host<ThreadedRun<2>>,
                         put_on_host<ThreadedRun<8>>, put_on_host<SeededRun<1>>, put_on_host<SeededRun<2>>}) {
    const Outcome outcome = six_steps(v, put);
    expect_near(model, outcome, host);
    hashes.insert(state_hash(model, outcome.state));
  }
  if (kSameBits && !v.coarse) hashes.insert(state_hash(model, host.state));
  EXPECT_EQ(hashes.size(), 1u);
}

// PBD steps match the CPU in any order of the loops.
TEST(DeviceBody, PbdMatchesCpuInAnyOrder) {
  expect_steps_match_cpu({.method = Method::kPbd, .volumes = true});
  expect_steps_match_cpu({.method = Method::kPbd, .size = {20, 12, 7}});
}

// The nodes of a CT have few kinds, and the table of kinds reproduces every node's mass and stiffness.
TEST(DeviceBody, NodeKindsReproduceNodes) {
  const CtVolume ct = make_phantom(
      kOne, {.kind = PhantomKind::kHead, .size = {64, 64, 60}, .spacing = {0.004, 0.004, 0.005}});
  for (const Int3 block : {Int3{1, 1, 1}, Int3{3, 2, 1}}) {
    const Model model = build(kOne, ct, {},
                              {.block = block,
                               .fix_ends = true,
                               .skin = {.law = SkinLaw::kArea},
                               .solver = {.method = Method::kPbd, .ordering = Ordering::kColors}})
                            .value();
    const PbdOrdering ordering = pbd_ordering(model);
    ASSERT_EQ(ordering.kind.size(), model.anatomy.inverse_mass.size());
    EXPECT_LT(ordering.kinds.size(), std::size_t(std::min(2000, model.anatomy.body_nodes / 10)));
    for (std::size_t s = 0; s < ordering.kind.size(); s++) {
      const NodeKind is = ordering.kinds.at(ordering.kind[s]);
      ASSERT_EQ(is.w, model.anatomy.inverse_mass[s]) << s;
      ASSERT_EQ(is.root, model.springs.root_stiffness[s]) << s;
    }
  }
}

// VBD steps of springs match the CPU in any order of the loops.
TEST(DeviceBody, VbdOfSpringsMatchesCpuInAnyOrder) {
  expect_steps_match_cpu({.method = Method::kVbd, .volumes = true});
  expect_steps_match_cpu({.method = Method::kVbd, .skin = SkinLaw::kArea, .size = {20, 12, 7}});
}

// VBD steps of solid tissue match the CPU in any order of the loops.
TEST(DeviceBody, VbdOfSolidMatchesCpuInAnyOrder) {
  expect_steps_match_cpu({.method = Method::kVbd, .law = TissueLaw::kSolid, .skin = SkinLaw::kArea});
  expect_steps_match_cpu({.method = Method::kVbd, .law = TissueLaw::kSolid, .size = {20, 12, 7}});
  expect_steps_match_cpu({.method = Method::kVbd, .law = TissueLaw::kSolid, .skin = SkinLaw::kExponential});
}

// Steps with a coarse space match the CPU in any order of the loops.
TEST(DeviceBody, CoarseSpaceMatchesCpuInAnyOrder) {
  expect_steps_match_cpu(
      {.method = Method::kVbd, .law = TissueLaw::kSolid, .skin = SkinLaw::kArea, .coarse = true});
  expect_steps_match_cpu(
      {.method = Method::kVbd, .law = TissueLaw::kSolid, .size = {20, 12, 7}, .coarse = true});
}

/// State after one step from given speeds, of a fixed or a free body.
State one_step(bool held, Real speed, const std::function<std::shared_ptr<BodyBackend>(const Model&)>& put) {
  Params params;
  params.solver = {.ordering = Ordering::kColors};
  const Model model =
      block_model({.size = {9, 8, 7}, .is_fixed = [held](Int3 p) { return held && p.z == 0; }}, params);
  State begin = make_state(model);
  for (int k = 1; k < 7; k++)
    for (int j = 0; j < 8; j++)
      for (int i = 0; i < 9; i++)
        begin.motion.v.set(std::size_t(node_slot(model.anatomy.lattice, i, j, k)),
                           {i % 2 ? speed : -speed, 0, 0});
  begin.motion.fastest = speed;
  DeviceState state = std::move(begin);
  if (put) state.use_backend(put(model));
  EXPECT_TRUE(state.step(kOne, model, {.gravity = {0, 0, -9.81}}, kDt).finite);
  return *state;
}

// The predictors of fast bodies and of free bodies match the CPU.
TEST(DeviceBody, FastAndFreeBodiesMatchCpu) {
  const Model model = block_model({.size = {9, 8, 7}}, {});
  for (const bool held : {true, false})
    for (const Real speed : {0.01f, 0.2f}) {
      const State host = one_step(held, speed, {}), device = one_step(held, speed, put_on_host<SeededRun<3>>);
      const StateDifference found = state_difference(model, device, host);
      EXPECT_GT(found.largest, 1e-5) << "m, held " << held << ", " << speed << " m/s";
      EXPECT_LT(found.most, 2e-5 * found.largest) << "m, held " << held << ", " << speed << " m/s";
    }
}

// A step that is not finite is undone.
TEST(DeviceBody, NonFiniteStepIsUndone) {
  for (const Variant& v :
       {Variant{.method = Method::kPbd}, Variant{.method = Method::kVbd, .law = TissueLaw::kSolid}}) {
    Scene scene(v);
    const Model& model = scene.block.model;
    const State before = scene.block.state;
    DeviceState state = std::move(scene.block.state);
    state.use_backend(put_on_host<SeededRun<1>>(model));
    const double nan = std::nan("");
    EXPECT_FALSE(state.step(kOne, model, {.gravity = {0, 0, nan}}, kDt).finite);
    EXPECT_EQ(state->motion.u.x, before.motion.u.x);
    EXPECT_EQ(state->motion.u.z, before.motion.u.z);
    EXPECT_EQ(state->motion.time, before.motion.time);
    for (std::size_t c = 0; c < before.motion.virtual_u.size(); c++)
      EXPECT_EQ(state->motion.virtual_u[c].z, before.motion.virtual_u[c].z);
    for (std::size_t s = 0; s < before.motion.v.x.size(); s++) ASSERT_EQ(state->motion.v.x[s], 0) << s;
  }
}

// A changed tension of the skin acts on the device as on the CPU.
TEST(DeviceBody, ChangedTensionMatchesCpu) {
  const auto end = [](bool device) {
    Scene scene({.method = Method::kVbd, .law = TissueLaw::kSolid});
    Model model = scene.block.model;
    DeviceState state = std::move(scene.block.state);
    if (device) state.use_backend(put_on_host<SeededRun<1>>(model));
    for (const double tension : {45.0, 20.0}) {
      model.params.skin.tension_along = tension;
      model.prestress_force = measure_prestress(kOne, model);
      for (int n = 0; n < 3; n++) EXPECT_TRUE(state.step(kOne, model, {}, kDt).finite);
    }
    return std::pair(model, *state);
  };
  const auto [model, host] = end(false);
  const State device = end(true).second;
  const StateDifference found = state_difference(model, device, host);
  EXPECT_LT(found.most, 2e-5 * found.largest) << "m";
}

}  // namespace
}  // namespace turgor::lattice
