// Whole steps by the loops that a GPU runs, in any order, against steps of the CPU by colours.
#include "turgor/models/lattice/device/device_body.hpp"

#include <cmath>
#include <random>
#include <set>

#include "tests/models/host_side.hpp"
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
constexpr bool kSameBits = false;  // lanes and threads may fuse other multiplications with additions
#endif

struct Variant {
  Method method;
  TissueLaw law = TissueLaw::kSprings;
  SkinLaw skin = SkinLaw::kFiber;
  bool volumes = false;
  Int3 size{13, 11, 9};
  bool coarse = false;  // then without contacts, for which there is none
};

/// Tissue unlike from node to node, so that whoever takes one for another is found.
void mix_tissue(Model& model) {
  std::mt19937 random(5);
  std::uniform_real_distribution<Real> by(Real(0.5), 1);
  for (Real& w : model.inverse_mass) w *= by(random);
  for (Real& root : model.root_stiffness) root *= by(random);
}

/// A block whose second blade is laid while it runs and cuts before its fourth and its fifth step.
struct Scene {
  CutBlock block;
  std::vector<NodeContact> contacts;
  std::vector<NodeLoad> loads;

  explicit Scene(const Variant& v) : block(cut_block(v.method, v.size, v.volumes, v.law, v.skin)) {
    block.model.params.solver.coarse = v.coarse;
    mix_tissue(block.model);
    const Lattice& l = block.model.lattice;
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

struct Went {
  State state;
  std::vector<NodeContact> contacts;
  StepReport report;
};

/// On the CPU, or where `there` says.
Went six_steps(const Variant& v,
               const std::function<std::shared_ptr<BodyBackend>(const Model&)>& there = {}) {
  Scene scene(v);
  const Model& model = scene.block.model;
  DeviceState state = std::move(scene.block.state);
  if (there) state.step_on(there(model));
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

void expect_like(const Model& model, const Went& there, const Went& here) {
  const Apart found = apart(model, there.state, here.state);
  EXPECT_GT(found.largest, 1e-3) << "m";
  EXPECT_LT(found.most, 2e-5 * found.largest) << "m";
  EXPECT_EQ(there.state.time, here.state.time);
  EXPECT_NEAR(there.state.fastest, here.state.fastest, 1e-4f * here.state.fastest) << "m/s";
  ASSERT_EQ(there.state.virtual_nodes.size(), here.state.virtual_nodes.size());
  for (std::size_t c = 0; c < here.state.virtual_nodes.size(); c++)
    EXPECT_NEAR(there.state.virtual_nodes[c].z, here.state.virtual_nodes[c].z, 2e-5 * found.largest)
        << "m, copy " << c;
  Real hardest = 0;
  for (const NodeContact& c : here.contacts) hardest = std::max(hardest, norm(c.force));
  for (std::size_t c = 0; c < here.contacts.size(); c++)
    EXPECT_LT(norm(there.contacts[c].force - here.contacts[c].force), 1e-3f * hardest) << "N";
  const Residual &a = there.report.residual, &b = here.report.residual;
  EXPECT_NEAR(a.before, b.before, 1e-3 * b.before) << "N";
  EXPECT_NEAR(a.rms, b.rms, 1e-3 * b.rms) << "N";
  EXPECT_NEAR(a.largest, b.largest, 1e-3 * b.largest) << "N";
}

void expect_steps_like_the_cpu_s(const Variant& v) {
  const Model model = Scene(v).block.model;
  const Went here = six_steps(v);
  EXPECT_EQ(here.state.virtual_nodes.empty(), v.law == TissueLaw::kSprings);
  EXPECT_EQ(here.report.residual.rms > 0, v.method == Method::kVbd);
  std::set<std::uint64_t> hashes;
  for (const auto there :
       {put_on_host<ThreadedRun<1>>, put_on_host<ThreadedRun<2>>, put_on_host<ThreadedRun<8>>,
        put_on_host<SeededRun<1>>, put_on_host<SeededRun<2>>}) {
    const Went went = six_steps(v, there);
    expect_like(model, went, here);
    hashes.insert(state_hash(model, went.state));
  }
  if (kSameBits && !v.coarse) hashes.insert(state_hash(model, here.state));
  EXPECT_EQ(hashes.size(), 1u);
}

TEST(lattice_body_on, steps_of_pbd_go_in_any_order_as_on_the_cpu) {
  expect_steps_like_the_cpu_s({.method = Method::kPbd, .volumes = true});
  expect_steps_like_the_cpu_s({.method = Method::kPbd, .size = {20, 12, 7}});
}

TEST(lattice_body_on, a_ct_s_nodes_are_of_few_kinds_and_each_is_of_its_own) {
  const CtVolume ct = make_phantom(
      kOne, {.kind = PhantomKind::kHead, .size = {64, 64, 60}, .spacing = {0.004, 0.004, 0.005}});
  for (const Int3 block : {Int3{1, 1, 1}, Int3{3, 2, 1}}) {
    const Model model = build(kOne, ct, {},
                              {.block = block,
                               .fix_ends = true,
                               .skin = {.law = SkinLaw::kArea},
                               .solver = {.method = Method::kPbd, .ordering = Ordering::kColors}})
                            .value();
    const PbdOrdering ordering = pbd_schedule(model);
    ASSERT_EQ(ordering.kind.size(), model.inverse_mass.size());
    EXPECT_LT(ordering.kinds.size(), std::size_t(std::min(2000, model.body_nodes / 10)));
    for (std::size_t s = 0; s < ordering.kind.size(); s++) {
      const NodeKind is = ordering.kinds.at(ordering.kind[s]);
      ASSERT_EQ(is.w, model.inverse_mass[s]) << s;
      ASSERT_EQ(is.root, model.root_stiffness[s]) << s;
    }
  }
}

TEST(lattice_body_on, steps_of_descent_with_springs_go_in_any_order_as_on_the_cpu) {
  expect_steps_like_the_cpu_s({.method = Method::kVbd, .volumes = true});
  expect_steps_like_the_cpu_s({.method = Method::kVbd, .skin = SkinLaw::kArea, .size = {20, 12, 7}});
}

TEST(lattice_body_on, steps_of_descent_with_solid_tissue_go_in_any_order_as_on_the_cpu) {
  expect_steps_like_the_cpu_s({.method = Method::kVbd, .law = TissueLaw::kSolid, .skin = SkinLaw::kArea});
  expect_steps_like_the_cpu_s({.method = Method::kVbd, .law = TissueLaw::kSolid, .size = {20, 12, 7}});
}

TEST(lattice_body_on, steps_with_a_coarse_space_go_in_any_order_as_on_the_cpu) {
  expect_steps_like_the_cpu_s(
      {.method = Method::kVbd, .law = TissueLaw::kSolid, .skin = SkinLaw::kArea, .coarse = true});
  expect_steps_like_the_cpu_s(
      {.method = Method::kVbd, .law = TissueLaw::kSolid, .size = {20, 12, 7}, .coarse = true});
}

/// Displacement that one step from there leaves, with velocities like this and nobody held, or somebody.
State one_step(bool held, Real speed,
               const std::function<std::shared_ptr<BodyBackend>(const Model&)>& there) {
  Params params;
  params.solver = {.ordering = Ordering::kColors};
  const Model model =
      block_model({.size = {9, 8, 7}, .is_fixed = [held](Int3 p) { return held && p.z == 0; }}, params);
  State begin = make_state(model);
  for (int k = 1; k < 7; k++)
    for (int j = 0; j < 8; j++)
      for (int i = 0; i < 9; i++)
        begin.v.set(std::size_t(node_slot(model.lattice, i, j, k)), {i % 2 ? speed : -speed, 0, 0});
  begin.fastest = speed;
  DeviceState state = std::move(begin);
  if (there) state.step_on(there(model));
  EXPECT_TRUE(state.step(kOne, model, {.gravity = {0, 0, -9.81}}, kDt).finite);
  return *state;
}

TEST(lattice_body_on, wild_bodies_begin_at_rest_and_what_nothing_holds_falls_there_too) {
  const Model model = block_model({.size = {9, 8, 7}}, {});
  for (const bool held : {true, false})
    for (const Real speed : {0.01f, 0.2f}) {
      const State here = one_step(held, speed, {}), there = one_step(held, speed, put_on_host<SeededRun<3>>);
      const Apart found = apart(model, there, here);
      EXPECT_GT(found.largest, 1e-5) << "m, held " << held << ", " << speed << " m/s";
      EXPECT_LT(found.most, 2e-5 * found.largest) << "m, held " << held << ", " << speed << " m/s";
    }
}

TEST(lattice_body_on, a_step_that_is_not_finite_is_undone) {
  for (const Variant& v :
       {Variant{.method = Method::kPbd}, Variant{.method = Method::kVbd, .law = TissueLaw::kSolid}}) {
    Scene scene(v);
    const Model& model = scene.block.model;
    const State before = scene.block.state;
    DeviceState state = std::move(scene.block.state);
    state.step_on(put_on_host<SeededRun<1>>(model));
    const double nan = std::nan("");
    EXPECT_FALSE(state.step(kOne, model, {.gravity = {0, 0, nan}}, kDt).finite);
    EXPECT_EQ(state->u.x, before.u.x);
    EXPECT_EQ(state->u.z, before.u.z);
    EXPECT_EQ(state->time, before.time);
    for (std::size_t c = 0; c < before.virtual_nodes.size(); c++)
      EXPECT_EQ(state->virtual_nodes[c].z, before.virtual_nodes[c].z);
    for (std::size_t s = 0; s < before.v.x.size(); s++) ASSERT_EQ(state->v.x[s], 0) << s;
  }
}

TEST(lattice_body_on, skin_under_another_tension_pulls_there_as_it_does_here) {
  const auto end = [](bool there) {
    Scene scene({.method = Method::kVbd, .law = TissueLaw::kSolid});
    Model model = scene.block.model;
    DeviceState state = std::move(scene.block.state);
    if (there) state.step_on(put_on_host<SeededRun<1>>(model));
    for (const double tension : {45.0, 20.0}) {
      model.params.skin.tension_along = tension;
      measure_pull(kOne, model, model.skin);
      for (int n = 0; n < 3; n++) EXPECT_TRUE(state.step(kOne, model, {}, kDt).finite);
    }
    return std::pair(model, *state);
  };
  const auto [model, here] = end(false);
  const State there = end(true).second;
  const Apart found = apart(model, there, here);
  EXPECT_LT(found.most, 2e-5 * found.largest) << "m";
}

}  // namespace
}  // namespace turgor::lattice
