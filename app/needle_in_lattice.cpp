#include "app/needle_in_lattice.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/core/assert.hpp"
#include "turgor/models/lattice/build/block_body.hpp"
#include "turgor/models/lattice/cutting/fragments.hpp"
#include "turgor/models/lattice/lattice.hpp"

namespace turgor {

LatticeUnderNeedles build_block(const LatticeNeedleBlock& block) {
  lattice::Params params;
  params.skin.enabled = false;
  params.tissue.law = lattice::TissueLaw::kSolid, params.tissue.poisson = block.poisson;
  params.solver = {.sweeps = block.sweeps, .damping = 8};
  const auto is_fixed = [&block](Int3 n) {
    if (!block.are_sides_fixed) return n.z == 0;
    return n.x == 0 || n.y == 0 || n.x == block.nodes.x - 1 || n.y == block.nodes.y - 1;
  };
  LatticeUnderNeedles body;
  body.model = lattice::block_model(
      {.size = block.nodes, .spacing = block.spacing, .young = block.young, .is_fixed = is_fixed}, params);
  body.state = lattice::make_state(body.model);
  body.surface = lattice::build_surface(body.model, body.state.cuts);
  return body;
}

double top_of(const LatticeUnderNeedles& body) {
  double z = 0;
  for (const Vec3 x : body.surface.rest) z = std::max(z, double(x.z));
  return z;
}

LatticeNeedlePush needle_above(const contact::Needle& needle, Vec3d entry, double tilt, double around) {
  const Vec3d z{std::sin(tilt) * std::cos(around), std::sin(tilt) * std::sin(around), std::cos(tilt)};
  const Vec3d x = normalized(cross(Vec3d{0.3, 1, 0}, z));
  return {needle, entry, {entry + z * 0.002, {{x, cross(z, x), z}}}, contact::make_lattice_needle()};
}

double depth_of(const LatticeNeedlePush& push) {
  return -dot(push.pose.position - push.entry, push.pose.axes.column[2]);
}

double force_on(const LatticeNeedlePush& push) { return dot(push.state.force, push.pose.axes.column[2]); }

void step_needles(const Exec& exec, LatticeUnderNeedles& body, std::vector<LatticeNeedlePush>& needles) {
  constexpr double kFrameTime = 1.0 / 60;  // [s]
  const auto fragments = lattice::fragments_of(body.model, body.state.cuts);
  const contact::NeedleSurroundings around{body.model, body.state, body.surface, *fragments,
                                           [](Vec3d) { return contact::NeedleTissue{}; }};
  // springs of all needles
  lattice::PointSprings springs;
  springs.settled = true;
  for (LatticeNeedlePush& push : needles) {
    begin_needle_step(around, push.needle, push.pose, push.state);
    append_needle_springs(push.state, springs.all);
    springs.settled = springs.settled && push.state.settled;
  }
  make_terms(springs);
  springs.refresh = [&](const lattice::State& now) {
    std::size_t next = 0;
    for (LatticeNeedlePush& push : needles)
      next += update_needle_springs(body.model, now.motion, push.needle, push.state,
                                    std::span(springs.all).subspan(next));
  };
  // step
  lattice::Inputs inputs;
  if (!springs.all.empty()) inputs.springs = &springs;
  const lattice::StepReport report = lattice::step(exec, body.model, body.state, inputs, kFrameTime);
  TURGOR_ASSERT(report.finite, "a needle that moves by less than a cell keeps its block finite");
  for (LatticeNeedlePush& push : needles) finish_needle_step(around, push.needle, push.state);
}

void push_to(const Exec& exec, LatticeUnderNeedles& body, std::vector<LatticeNeedlePush>& needles,
             double depth, double step, const std::function<void()>& visit) {
  double farthest = 0;
  for (const LatticeNeedlePush& push : needles)
    farthest = std::max(farthest, std::abs(depth - depth_of(push)));
  const int frames = std::max(1, int(std::lround(farthest / step)));
  std::vector<double> each;
  for (const LatticeNeedlePush& push : needles) each.push_back((depth - depth_of(push)) / frames);
  for (int frame = 0; frame < frames; frame++) {
    for (std::size_t n = 0; n < needles.size(); n++)
      needles[n].pose.position -= needles[n].pose.axes.column[2] * each[n];
    step_needles(exec, body, needles);
    if (visit) visit();
  }
}

}  // namespace turgor
