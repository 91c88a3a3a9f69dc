// Local contact of a needle in a lattice, for haptic ticks.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "turgor/contact/lattice_needle_step.hpp"

namespace turgor::contact {

namespace {

/// Stiffness of a shaft in tissue along and across it, and of its tip on a surface [N/m].
struct NeedleStiffness {
  double along = 0, across = 0;
};

/// A shaft of length L and radius a along itself: 2π G L/ln(2.5 L (1 − ν)/a) [Randolph, Wroth 1978, a pile],
/// and across it by the ratio of needle_touch.hpp. A tip: 4 G h, of a disk of the size h of a cell.
NeedleStiffness stiffness_of(const lattice::Model& model, const Needle& needle, const LatticeNeedle& state) {
  const LatticeNeedlePoint& end = track_of(state).points[0];
  const double poisson = model.params.tissue.poisson;
  const double shear =
      std::max(double(model.anatomy.cell_young[std::size_t(end.at.cell)]), model.params.tissue.fat) /
      (2 * (1 + poisson));
  const double tip = end.is_coupled ? 4 * shear * double(model.anatomy.lattice.spacing.x) : 0;
  const double radius = needle.diameter / 2, length = std::max(0.0, state.inserted);
  const double log = std::max(1.0, std::log(2.5 * length * (1 - poisson) / radius + 1));
  const double shaft = 2 * std::numbers::pi * shear * length / log;
  return {tip + shaft, tip + shaft * 4 * (1 - poisson) / (3 - 4 * poisson)};
}

}  // namespace

LocalContact local_contact(const lattice::Model& model, const Needle& needle, const LatticeNeedle& state) {
  const bool is_near = state.phase != NeedlePhase::kOutside;
  const Vec3d up = state.pose.axes.column[2];
  LocalContact contact{.is_near = is_near,
                       .is_held = true,
                       .origin = state.pose.position,
                       .normal = up,
                       .force = state.force,
                       .reach = kNeedleJump,
                       .needle = {.is_needle = true,
                                  .reading = state.reading,
                                  .work = state.work,
                                  .punctures = state.punctures,
                                  .entry_force = state.entry_force}};
  if (!is_near) return contact;
  const NeedleStiffness stiffness = stiffness_of(model, needle, state);
  contact.stiffness = stiffness.along, contact.shear_stiffness = stiffness.across;
  contact.arm = up * (std::max(0.0, state.inserted) / 2);
  // bounds: friction both ways, tearing, and the load of the spread crack
  double friction = 0;
  for (const LatticeNeedlePoint& point : track_of(state).points) friction += friction_bound(needle, point);
  const double spread = state.phase == NeedlePhase::kInside ? spreading_force(needle, shaft_of(state)) : 0;
  const double tearing = track_of(state).points[0].is_coupled ? tearing_force(needle, state) : 0;
  contact.needle.lowest = std::min(spread - friction, dot(state.force, up));
  contact.needle.highest = std::max(spread + friction + tearing, dot(state.force, up));
  contact.needle.is_touching = state.phase == NeedlePhase::kTouching;
  contact.needle.after_puncture = tearing_inside(needle, state);
  return contact;
}

}  // namespace turgor::contact
