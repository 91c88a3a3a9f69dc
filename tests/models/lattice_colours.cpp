// Sweeps by colours: nothing of a pass depends on anything else of it, so that threads of a GPU may do it.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <set>

#include <gtest/gtest.h>

#include "block_body.hpp"
#include "turgor/models/lattice/descent_loops.hpp"
#include "turgor/models/lattice/gpu_body.hpp"
#include "turgor/models/lattice/incision.hpp"
#include "turgor/models/lattice/pbd_loops.hpp"
#include "turgor/models/lattice/sweeps.hpp"

namespace turgor::lattice {
namespace {

const Exec kOne(1);
constexpr double kDt = 1.0 / 60;

struct CutBlock {
  Model model;
  State state;
};
/// A tense block with fixed sides, pushed out of shape and cut.
CutBlock cut_block(Method method, Int3 size = {13, 11, 9}, bool volumes = true,
                   TissueLaw law = TissueLaw::kSprings, SkinLaw skin = SkinLaw::kFibre) {
  const auto is_side = [size](Int3 p) {
    return p.x == 0 || p.y == 0 || p.z == 0 || p.x == size.x - 1 || p.y == size.y - 1;
  };
  Params params;
  params.solver = {.method = method, .schedule = Schedule::kColours, .pbd_volume = volumes};
  params.tissue = {.law = law, .volume = method == Method::kDescent && volumes ? 1.0 : 0.0};
  params.skin.law = method == Method::kPbd ? SkinLaw::kArea : skin;
  CutBlock block{block_model({.size = size, .is_fixed = is_side}, params), {}};
  block.state = make_state(block.model);
  const auto wave = [](int a, int b) { return Real(1e-3 * std::sin(1.3 * a + 0.7 * b)); };
  for (int k = 0; k < size.z; k++)
    for (int j = 0; j < size.y; j++)
      for (int i = 0; i < size.x; i++)
        if (!is_side({i, j, k}))
          block.state.u.set(std::size_t(node_slot(block.model.lattice, i, j, k)),
                            {wave(i, j), wave(j, k), wave(k, i)});
  const double y = 0.004 * (size.y / 2 + 0.5), z = 0.004 * (size.z - 1);
  const BladePath path =
      lay_blade(block.model, block.state, {.from = {0.015, y, z}, .to = {0.032, y, z}}).value();
  EXPECT_GT(cut_edges(block.model, block.state, path, 0, 1, 0), 10);
  return block;
}

TEST(lattice_colours, no_two_cells_of_a_colour_touch_the_same_node) {
  for (const Int3 size : {Int3{9, 8, 7}, {12, 5, 4}, {2, 2, 2}, {33, 3, 6}})
    for (int colour = 0; colour < kColourCount; colour++) {
      const Lattice l = make_lattice(size, {1, 1, 1});
      const ColourRows rows(size, colour);
      std::set<int> touched;  // by edges and tetrahedra of the cells, beyond the border too
      for (std::size_t n = 0; n < rows.count(); n++) {
        const auto [parity, j, k] = rows[n];
        for (int i = parity; i < size.x; i += 2) {
          EXPECT_EQ(colour_of({i, j, k}), colour);
          for (int corner = 0; corner < 8; corner++)
            EXPECT_TRUE(touched
                            .insert(node_slot(l, {i, j, k}) +
                                    slot_offset(l, {corner & 1, corner >> 1 & 1, corner >> 2}, parity))
                            .second)
                << i << " " << j << " " << k;
        }
      }
    }
}

TEST(lattice_colours, the_half_rows_of_all_colours_are_every_node_once) {
  const Int3 size{13, 6, 5};
  std::set<std::array<int, 3>> seen;
  for (int colour = 0; colour < kColourCount; colour++) {
    const ColourRows rows(size, colour);
    for (std::size_t n = 0; n < rows.count(); n++) {
      EXPECT_TRUE(seen.insert({rows[n].parity, rows[n].j, rows[n].k}).second);
      EXPECT_TRUE(contains(make_lattice(size, {1, 1, 1}), {rows[n].parity, rows[n].j, rows[n].k}));
    }
  }
  EXPECT_EQ(seen.size(), std::size_t(2 * size.y * size.z));
}

TEST(lattice_colours, any_order_within_a_colour_gives_the_same_bits) {
  for (const Method method : {Method::kPbd, Method::kDescent}) {
    std::set<std::uint64_t> hashes;
    const auto hash_after = [&](const auto& sweep) {
      auto [model, state] = cut_block(method);
      predict(kOne, model, state, {}, kDt);
      for (int n = 0; n < 4; n++) sweep(model, state, n % 2 ? Order::kBackward : Order::kForward);
      hashes.insert(state_hash(model, state));
    };
    hash_after([&](const Model& model, State& state, Order order) {
      method == Method::kPbd ? sweep_pbd(kOne, model, state)
                             : sweep_descent(kOne, model, state, {}, kDt, order);
    });
    for (const unsigned seed : {1u, 2u, 3u})
      hash_after([&](const Model& model, State& state, Order order) {
        const ShuffledRun run{seed};
        method == Method::kPbd ? sweep_pbd_by_colours(run, model, state)
                               : sweep_descent_by_colours(run, model, state, {}, kDt, order);
      });
    EXPECT_EQ(hashes.size(), 1u) << "method " << int(method);
  }
}

/// The largest difference of displacements [m], and the largest displacement.
struct Apart {
  double most = 0, largest = 0;
};
Apart apart(const Model& model, const State& a, const State& b) {
  Apart found;
  for (std::size_t s = 0; s < model.inverse_mass.size(); s++) {
    found.most = std::max(found.most, norm(Vec3d(a.u[s]) - Vec3d(b.u[s])));
    found.largest = std::max(found.largest, norm(Vec3d(a.u[s])));
  }
  return found;
}

void expect_loops_like_steps(Int3 size, bool volumes) {
  const Inputs inputs{.gravity = {1, 0, -9.81}};
  CutBlock here = cut_block(Method::kPbd, size, volumes);
  for (int n = 0; n < 5; n++) step(kOne, here.model, here.state, inputs, kDt);
  const PbdSchedule schedule = pbd_schedule(here.model);
  std::set<std::uint64_t> hashes;
  const auto go = [&](const auto& run) {
    CutBlock there = cut_block(Method::kPbd, size, volumes);
    Real fastest = 0;
    for (int n = 0; n < 5; n++) {
      std::uint32_t largest = 0;
      step_pbd_with(run, pbd_view(there.model, schedule, there.state, largest),
                    lattice_gravity(there.model, inputs), there.model.params.solver, kDt);
      fastest = std::sqrt(std::bit_cast<Real>(largest));
    }
    hashes.insert(state_hash(there.model, there.state));
    const Apart found = apart(there.model, there.state, here.state);
    EXPECT_GT(found.largest, 1e-3) << "m";
    EXPECT_LT(found.most, 1e-5 * found.largest) << "m: fused multiply-adds may differ";
    EXPECT_NEAR(fastest, here.state.fastest, 1e-4f * fastest) << "m/s";
  };
  go(CpuRun{kOne});
  go(CpuRun{Exec(8)});
  for (const unsigned seed : {1u, 2u}) go(ShuffledRun{seed});
  EXPECT_EQ(hashes.size(), 1u);
}

TEST(lattice_colours, the_loops_that_a_gpu_runs_do_in_any_order_what_a_step_does) {
  expect_loops_like_steps({13, 11, 9}, true);
  expect_loops_like_steps({20, 12, 7}, false);
}

/// A finger on some of the top, and a place between two nodes.
std::vector<NodeContact> finger(const Model& model) {
  const int z = model.lattice.size.z - 2;  // a layer of air above
  std::vector<NodeContact> contacts;
  for (int i = 3; i < 8; i++)
    contacts.push_back({.slot = node_slot(model.lattice, i, 4, z),
                        .normal = {0, 0, -1},
                        .target = {0, 0, -2e-3f},
                        .friction = 0.3f,
                        .is_held = i == 5});
  contacts.push_back(contacts[0]);
  contacts.back().other = node_slot(model.lattice, 4, 4, z);
  std::stable_sort(contacts.begin(), contacts.end(),
                   [](const NodeContact& a, const NodeContact& b) { return a.slot < b.slot; });
  return contacts;
}

void expect_descent_loops_like_sweeps(Int3 size, TissueLaw law, SkinLaw skin, bool volumes) {
  std::set<std::uint64_t> hashes;
  const auto after = [&](const auto& sweep) {
    CutBlock block = cut_block(Method::kDescent, size, volumes, law, skin);
    std::vector<NodeContact> contacts = finger(block.model);
    const Inputs inputs{.gravity = {1, 0, -9.81}, .contacts = contacts};
    predict(kOne, block.model, block.state, inputs, kDt);
    for (const Order order : {Order::kForward, Order::kForward, Order::kBackward})
      sweep(block, inputs, order);
    return std::pair(std::move(block.state), contacts);
  };
  const Model model = cut_block(Method::kDescent, size, volumes, law, skin).model;
  const auto here = after([](CutBlock& b, const Inputs& inputs, Order order) {
    sweep_descent(kOne, b.model, b.state, inputs, kDt, order);
  });
  EXPECT_EQ(here.first.copies.empty(), law == TissueLaw::kSprings);
  const auto go = [&](const auto& run) {
    const auto there = after([&run](CutBlock& b, const Inputs& inputs, Order order) {
      const DescentSchedule schedule = descent_schedule(b.model);
      const CopySchedule copies = copy_schedule(b.model, b.state);
      sweep_descent_with(run, descent_view(b.model, schedule, copies, b.state, inputs, kDt), order);
    });
    hashes.insert(state_hash(model, there.first));
    const Apart found = apart(model, there.first, here.first);
    EXPECT_GT(found.largest, 1e-3) << "m";
    EXPECT_LT(found.most, 2e-5 * found.largest) << "m: fused multiply-adds may differ";
    for (std::size_t c = 0; c < here.first.copies.size(); c++)
      EXPECT_NEAR(there.first.copies[c].z, here.first.copies[c].z, 2e-5 * found.largest) << "m, copy " << c;
    for (std::size_t c = 0; c < here.second.size(); c++)
      EXPECT_LT(norm(there.second[c].force - here.second[c].force), 1e-3f * norm(here.second[2].force))
          << "N";
  };
  go(CpuRun{Exec(2)});
  for (const unsigned seed : {1u, 2u}) go(ShuffledRun{seed});
  EXPECT_EQ(hashes.size(), 1u);
}

TEST(lattice_colours, descent_s_loops_for_a_gpu_do_in_any_order_what_its_sweeps_do) {
  expect_descent_loops_like_sweeps({13, 11, 9}, TissueLaw::kSprings, SkinLaw::kFibre, true);
  expect_descent_loops_like_sweeps({20, 12, 7}, TissueLaw::kSprings, SkinLaw::kArea, false);
  expect_descent_loops_like_sweeps({13, 11, 9}, TissueLaw::kSolid, SkinLaw::kArea, false);
  expect_descent_loops_like_sweeps({20, 12, 7}, TissueLaw::kSolid, SkinLaw::kFibre, false);
}

TEST(lattice_colours, the_loops_take_a_body_back_to_where_its_step_began) {
  CutBlock block = cut_block(Method::kPbd);
  const State before = block.state;
  const PbdSchedule schedule = pbd_schedule(block.model);
  std::uint32_t largest = 0;
  const PbdView view = pbd_view(block.model, schedule, block.state, largest);
  step_pbd_with(ShuffledRun{}, view, {0, 0, std::nanf("")}, block.model.params.solver, kDt);
  EXPECT_FALSE(std::isfinite(std::bit_cast<Real>(largest)));
  go_back_with(ShuffledRun{}, view);
  EXPECT_EQ(block.state.u.x, before.u.x);
  EXPECT_EQ(block.state.u.z, before.u.z);
  EXPECT_EQ(block.state.v.x, before.v.x);
}

/// Forces of a plate that presses all of a block's top by a millimetre, at rest [N].
double plate_force(Schedule schedule, TissueLaw law) {
  const Int3 size{9, 12, 7};
  Params params;
  params.tissue = {.law = law, .poisson = 0.4};
  params.solver = {.schedule = schedule, .sweeps = 10, .damping = 8};
  const Model model = block_model({.size = size, .is_fixed = [](Int3 p) { return p.z == 0; }}, params);
  std::vector<NodeContact> contacts;
  for (int j = 0; j < size.y; j++)
    for (int i = 0; i < size.x; i++)
      contacts.push_back({.slot = node_slot(model.lattice, i, j, size.z - 1),
                          .normal = {0, 0, -1},
                          .target = {0, 0, -1e-3f}});
  std::sort(contacts.begin(), contacts.end(),
            [](const NodeContact& a, const NodeContact& b) { return a.slot < b.slot; });
  State state = make_state(model);
  for (int n = 0; n < 150; n++) step(Exec(2), model, state, {.contacts = contacts}, kDt);
  double force = 0;
  for (const NodeContact& c : contacts) force -= double(c.force.z);
  return force;
}

TEST(lattice_colours, a_plate_on_nodes_is_borne_alike_by_slabs_and_by_colours) {
  for (const TissueLaw law : {TissueLaw::kSprings, TissueLaw::kSolid}) {
    const double slabs = plate_force(Schedule::kSlabs, law), colours = plate_force(Schedule::kColours, law);
    std::printf("  law %d: %.5f N by slabs, %.5f N by colours\n", int(law), slabs, colours);
    EXPECT_GT(slabs, 0.1) << "N";
    EXPECT_NEAR(colours, slabs, 1e-3 * slabs) << "N, law " << int(law);
  }
}

TEST(gpu_lattice, a_body_steps_there_as_it_does_here) {
  const Result<Gpu> gpu = open_gpu();
  if (!gpu) GTEST_SKIP() << gpu.error().message;
  CutBlock here = cut_block(Method::kPbd), there = cut_block(Method::kPbd);
  const auto body = put(*gpu, there.model).value();
  const Inputs inputs{.gravity = {1, 0, -9.81}};
  step(kOne, here.model, here.state, inputs, kDt);
  EXPECT_TRUE(step_on_gpu(*body, there.model, there.state, inputs, kDt).finite);
  const Apart found = apart(there.model, there.state, here.state);
  EXPECT_LT(found.most, 1e-4 * found.largest) << "m";
  EXPECT_EQ(there.state.time, here.state.time);
}

}  // namespace
}  // namespace turgor::lattice
