// Stitches in the coarse operator, against its unfactored definition and the convergence of corrections.
#include "turgor/models/lattice/coarse/coupled_points.hpp"

#include <cmath>
#include <numeric>
#include <random>

#include <gtest/gtest.h>

#include "tests/models/lattice/wounded_block.hpp"
#include "turgor/models/lattice/coarse/prolongation.hpp"
#include "turgor/models/lattice/cutting/embed_point.hpp"
#include "turgor/models/lattice/lattice.hpp"
#include "turgor/models/lattice/suture/closure.hpp"

namespace turgor::lattice {
namespace {

const Exec kSerial(1);
constexpr double kFrameTime = 1.0 / 60;

/// A wounded block with stiff threads across its wound, each between two points: E = ½ k (Σ g·u + s)², with s
/// the length that the thread is short of.
struct Threaded {
  Wounded wounded{0.4, 0.3, 70, solid_params(5, 4, 0)};
  const Model& model = wounded.model;
  State& state = wounded.state;
  std::vector<double> stiffness;  // by thread; 0 = slack [N/m]
  double shortage = 0;            // [m]
  PointSprings springs;

  /// Threads at these arc lengths from the middle of the wound.
  Threaded(std::span<const double> along, std::vector<double> k, double s)
      : stiffness(std::move(k)), shortage(s) {
    const auto fragments = fragments_of(model, state.cuts);
    const double angle = 70 * std::numbers::pi / 180;
    const Vec3d line{std::cos(angle), std::sin(angle), 0}, across{-line.y, line.x, 0};
    const Vec3d middle{12.3 * Wounded::kStep, 12.4 * Wounded::kStep, 5.6 * Wounded::kStep};
    for (const double a : along)
      for (const double side : {-1.0, 1.0}) {
        const Vec3d at = middle + line * a + across * (side * 0.005);
        springs.all.push_back({.at = embed_point(model, state.cuts, *fragments, at).value(),
                               .coupling = {.direction = Vec3(across * side), .count = side < 0 ? 2 : 0}});
      }
    make_terms(springs);
    springs.refresh = [this](const State& now) { update(now); };
    update(state);
  }
  /// The same springs without couplings.
  void uncouple() {
    for (PointSpring& spring : springs.all) spring.coupling.count = 0;
  }
  double extension(std::size_t thread, const Motion& motion) const {
    double sum = 0;
    for (const std::size_t p : {2 * thread, 2 * thread + 1})
      sum += dot(Vec3d(springs.all[p].coupling.direction), Vec3d(displacement(springs.all[p].at, motion)));
    return sum;
  }
  void update(const State& now) {
    for (std::size_t t = 0; t < stiffness.size(); t++)
      for (const std::size_t p : {2 * t, 2 * t + 1}) {
        PointSpring& spring = springs.all[p];
        const Vec3 g = spring.coupling.direction;
        spring.coupling.stiffness = p == 2 * t ? Real(stiffness[t]) : 0;
        spring.force = g * Real(-stiffness[t] * (extension(t, now.motion) + shortage));
        spring.target = displacement(spring.at, now.motion);
        spring.stiffness = axial_stiffness(normalized(g), Real(2 * stiffness[t]), 0);
      }
  }
  Inputs inputs() { return {.springs = &springs}; }
  const CoarseSpace& space() const { return *state.workspace.coarse; }

  /// The body with a displacement of the unknowns only.
  State moved_by(std::span<const double> unknowns) const {
    State moved = state;
    for (auto* axis : {&moved.motion.u.x, &moved.motion.u.y, &moved.motion.u.z})
      std::fill(axis->begin(), axis->end(), Real(0));
    for (VirtualNodeDisplacement& u : moved.motion.virtual_u) u = {};
    std::vector<Vec3> corners(space().row_begin.size() - 1);
    for (std::size_t row = 0; row < corners.size(); row++)
      for (int t = space().row_begin[row]; t < space().row_begin[row + 1]; t++)
        for (int axis = 0; axis < 3; axis++)
          corners[row][axis] += Real(double(space().terms[std::size_t(t)].weight) *
                                     unknowns[std::size_t(3 * space().terms[std::size_t(t)].unknown + axis)]);
    prolongate(kSerial, model, moved, corners);
    return moved;
  }
  /// Extensions of the threads by a displacement of the unknowns, from that of every node.
  std::vector<double> extensions(std::span<const double> unknowns) const {
    const State moved = moved_by(unknowns);
    std::vector<double> all;
    for (std::size_t t = 0; t < stiffness.size(); t++) all.push_back(extension(t, moved.motion));
    return all;
  }
};

constexpr double kAlong[] = {-0.011, 0.002, 0.009};

// x = (A + U K Uᵀ)⁻¹ f, tested by work of other forces h: h·A⁻¹f − h·x = (Uᵀ A⁻¹ h)·K (Uᵀ x).
TEST(CoupledPoints, SolutionHasStiffnessOfThreads) {
  Threaded body(kAlong, {300, 0, 2e4}, 0);
  ASSERT_TRUE(prepare_coarse_space(body.model, body.state, body.inputs(), kFrameTime));
  ASSERT_TRUE(has_coupled_points(body.state));
  std::mt19937 random{5};
  std::uniform_real_distribution<double> number{-1, 1};
  const auto random_forces = [&] {
    std::vector<double> f(3 * std::size_t(body.space().unknowns));
    for (double& a : f) a = number(random);
    return f;
  };
  const auto work = [](const std::vector<double>& a, const std::vector<double>& b) {
    return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
  };
  for (int n = 0; n < 5; n++) {
    const std::vector<double> f = random_forces(), h = random_forces();
    const std::vector<double> alone = body.space().factor.solve(f),
                              x = solve_coupled(body.space(), &body.springs, {}, f);
    const std::vector<double> of_x = body.extensions(x), of_h = body.extensions(body.space().factor.solve(h));
    double expected = 0, scale = 0;
    for (std::size_t t = 0; t < of_x.size(); t++) {
      expected += of_h[t] * body.stiffness[t] * of_x[t];
      scale += std::abs(of_h[t] * body.stiffness[t] * of_x[t]);
    }
    EXPECT_NEAR(work(h, alone) - work(h, x), expected, 2e-3 * scale) << "J";
  }
  // no couplings
  ASSERT_TRUE(prepare_coarse_space(body.model, body.state, {}, kFrameTime));
  EXPECT_FALSE(has_coupled_points(body.state));
  const std::vector<double> f = random_forces();
  EXPECT_EQ(solve_coupled(body.space(), nullptr, {}, f), body.space().factor.solve(f));
}

// The same with contacts besides: one that slides, with a stiffness along its normal, and one that does not
// push.
TEST(CoupledPoints, SolutionHasStiffnessOfContacts) {
  Threaded body(kAlong, {300, 0, 2e4}, 0);
  const Vec3 normal = normalized(Vec3{0.3f, -0.2f, 0.9f});
  const double stiffness = 800;
  const auto slot_at = [&](Int3 node) { return node_slot(body.model.anatomy.lattice, node); };
  std::vector<NodeContact> contacts(2);
  contacts[0].slot = slot_at({6, 8, 5}), contacts[1].slot = slot_at({8, 8, 5});
  for (NodeContact& c : contacts) {
    c.normal = normal, c.stiffness = Real(stiffness);
    c.target = body.state.motion.u[std::size_t(c.slot)] + cross(normal, Vec3{1e-3f, 0, 0});
  }
  contacts[0].force = normal, contacts[1].target = contacts[1].target - normal * 1e-3f;
  Inputs inputs = body.inputs();
  inputs.contacts = contacts;
  ASSERT_TRUE(prepare_coarse_space(body.model, body.state, inputs, kFrameTime));
  const ContactColumns columns = find_contact_columns(body.model, body.state, inputs);
  EXPECT_EQ(columns.columns.count(), 1u);
  std::mt19937 random{6};
  std::uniform_real_distribution<double> number{-1, 1};
  std::vector<double> f(3 * std::size_t(body.space().unknowns)), h = f;
  for (int n = 0; n < 5; n++) {
    for (double& a : f) a = number(random);
    for (double& a : h) a = number(random);
    const std::vector<double> x = solve_coupled(body.space(), &body.springs, columns, f),
                              of_f = body.space().factor.solve(f), of_h = body.space().factor.solve(h);
    const std::vector<double> threads_x = body.extensions(x), threads_h = body.extensions(of_h);
    const auto pressed = [&](const std::vector<double>& unknowns) {
      return double(dot(normal, body.moved_by(unknowns).motion.u[std::size_t(contacts[0].slot)]));
    };
    double expected = pressed(of_h) * stiffness * pressed(x), scale = std::abs(expected);
    EXPECT_GT(scale, 0);
    for (std::size_t t = 0; t < threads_x.size(); t++) {
      expected += threads_h[t] * body.stiffness[t] * threads_x[t];
      scale += std::abs(threads_h[t] * body.stiffness[t] * threads_x[t]);
    }
    EXPECT_NEAR(std::inner_product(h.begin(), h.end(), of_f.begin(), 0.0) -
                    std::inner_product(h.begin(), h.end(), x.begin(), 0.0),
                expected, 2e-3 * scale)
        << "J";
  }
}

// Corrections alone settle a body whose stiff threads are too short: after four, the Newton step is a
// thousandth of the first one. Without the threads in the operator, steps are too long, and four bring
// little.
TEST(CoupledPoints, CorrectionsConvergeWithThreadsOnly) {
  double left[2], step_length[2];
  for (const bool coupled : {false, true}) {
    Threaded body(kAlong, {2e4, 2e4, 2e4}, 1e-4);
    if (!coupled) body.uncouple();
    ASSERT_TRUE(prepare_coarse_space(body.model, body.state, body.inputs(), kFrameTime));
    double newton_step[4] = {};  // [m]
    for (int n = 0; n < 4; n++) {
      const CoarseStep done =
          apply_coarse_correction(kSerial, body.model, body.state, body.inputs(), kFrameTime);
      ASSERT_GT(done.step_length, 0);
      newton_step[n] = done.displacement / done.step_length;
      if (n == 0) step_length[coupled] = done.step_length;
    }
    left[coupled] = newton_step[3] / newton_step[0];
    std::printf("coupled %d: step length %.4f, Newton step falls to %.5f\n", coupled, step_length[coupled],
                left[coupled]);
  }
  EXPECT_LT(left[1], 1e-3);
  EXPECT_GT(left[0], 1e-2);
  EXPECT_NEAR(step_length[1], 1, 0.2);
  EXPECT_LT(step_length[0], 0.1);
}

/// Pulls stitches through a wounded block; returns the displacements, and the residual of the last step [N].
std::pair<VecField, double> sewn(const Exec& exec, bool coupled, int steps) {
  Wounded wounded{0.4, 0.3, 70, solid_params(5, 4, 45)};
  WoundClosure closure = lay_stitches(wounded.model, wounded.state.cuts, wounded.path, {}).value();
  closure.thread = {.stiffness = 100, .strength = 20}, closure.pull_out = 20;
  double rms = 0;
  for (int n = 1; n <= steps; n++) {
    pull_stitches(wounded.state.motion, {.duration = 0.2}, n * kFrameTime, closure);
    PointSprings springs;
    append_springs(closure, springs.all);
    if (!coupled)
      for (PointSpring& spring : springs.all) spring.coupling.count = 0;
    make_terms(springs);
    springs.refresh = [&](const State& now) {
      update_springs(wounded.model, now.motion, closure, springs.all);
    };
    Inputs inputs{.springs = &springs};
    inputs.measure_residual = true;
    const StepReport report = step(exec, wounded.model, wounded.state, inputs, kFrameTime);
    EXPECT_TRUE(report.finite);
    EXPECT_EQ(has_coupled_points(wounded.state), coupled);
    rms = report.residual.rms;
    update_multipliers(wounded.model, wounded.state.motion, closure);
  }
  return {wounded.state.motion.u, rms};
}

// A sewn body settles with one correction a step that has the stitches, and not with two that lack them.
TEST(CoupledPoints, SewnBodySettlesWithStitchesOnly) {
  const double with = sewn(kSerial, true, 40).second, without = sewn(kSerial, false, 40).second;
  std::printf("%.3e N with stitches, %.3e N without\n", with, without);
  EXPECT_LT(with, 0.01 * without) << "N";
}

// A sewn body has the same bits on one, two and eight threads.
TEST(CoupledPoints, SewnBodyHasEqualBitsOnAnyThreads) {
  const VecField one = sewn(Exec(1), true, 8).first;
  for (const int threads : {2, 8}) {
    const VecField many = sewn(Exec(threads), true, 8).first;
    EXPECT_EQ(one.x, many.x);
    EXPECT_EQ(one.y, many.y);
    EXPECT_EQ(one.z, many.z);
  }
}

}  // namespace
}  // namespace turgor::lattice
