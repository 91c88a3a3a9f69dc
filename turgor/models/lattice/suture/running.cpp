// Running suture: one thread that makes all stitches of a row and slides between them against friction.
#include <algorithm>
#include <cmath>

#include "turgor/core/assert.hpp"
#include "turgor/models/lattice/suture/thread_loop.hpp"

namespace turgor::lattice {

namespace {

/// Share of the excess of a tension that slides away in a step.
constexpr double kSliding = 0.3;
/// Largest share of a stitch's thread that slides away in a step.
constexpr double kMostSlide = 0.02;

double angle_between(Vec3d a, Vec3d b) { return std::atan2(norm(cross(a, b)), dot(a, b)); }

/// Adds thread to a stitch. Its tension follows at once, as that of a spring of stiffness EA/L₀ between
/// points at rest: λ takes what the penalty lacks. A settled closure does not use λ.
void add_thread(const Model& model, const Thread& thread, double length, Stitch& stitch) {
  const double k = thread.stiffness / stitch.length, penalty = penalty_of(model, thread, stitch);
  stitch.multiplier = std::max(0.0, stitch.multiplier - (k - penalty) * length);
  stitch.tension = std::max(0.0, stitch.tension - k * length);
  stitch.length += length;
}

/// Slides thread from one stitch to a neighbor whose tension is larger by more than a ratio. Thread of length
/// δ leaves `from`, so that T_to − k_to δ = r (T_from + k_from δ). Returns the change of tension [N].
double slide(const Model& model, const Thread& thread, double ratio, Stitch& from, Stitch& to) {
  const double excess = to.tension - ratio * from.tension;
  if (!(excess > 0)) return 0;
  const double give = thread.stiffness / from.length, take = thread.stiffness / to.length;
  const double length = std::min(kSliding * excess / (take + ratio * give), kMostSlide * from.length);
  add_thread(model, thread, -length, from);
  add_thread(model, thread, length, to);
  return take * length;
}

}  // namespace

double turning_between(const Stitch& from, const Stitch& to, const Motion& motion) {
  constexpr std::size_t kLeftDeep = 1, kRightDeep = 2;
  const std::vector<Vec3d> a = points_now(from, motion), b = points_now(to, motion);
  const Vec3d path[] = {a[kLeftDeep], a[kRightDeep], a[kRightDeep + 1], b[0], b[kLeftDeep], b[kRightDeep]};
  double sum = 0;
  for (std::size_t p = 1; p + 1 < std::size(path); p++)
    sum += angle_between(path[p] - path[p - 1], path[p + 1] - path[p]);
  return sum;
}

double slide_thread(const Model& model, const Motion& motion, WoundClosure& closure) {
  double change = 0;
  Stitch* last = nullptr;
  // thread slides between neighbors that are closed, and past stitches that tore out
  for (Stitch& stitch : closure.stitches) {
    if (stitch.phase == StitchPhase::kPulledOut) continue;
    const bool slides = stitch.phase == StitchPhase::kKnotted;
    if (last && slides) {
      const double ratio = std::exp(closure.thread.friction * turning_between(*last, stitch, motion));
      change = std::max({change, slide(model, closure.thread, ratio, *last, stitch),
                         slide(model, closure.thread, ratio, stitch, *last)});
    }
    last = slides ? &stitch : nullptr;
  }
  return change;
}

void join_stitches(WoundClosure& closure) {
  Stitch* last = nullptr;
  const auto join = [](Stitch& from, const Stitch& to) {
    from.rest.back() = to.rest.front(), from.side.back() = to.side.front(), from.at.back() = to.at.front();
  };
  for (Stitch& stitch : closure.stitches) {
    if (stitch.phase == StitchPhase::kPulledOut || stitch.phase == StitchPhase::kBroken) continue;
    if (last) join(*last, stitch);
    last = &stitch;
  }
  if (last) join(*last, *last);
}

void free_thread(WoundClosure& closure, std::size_t torn) {
  const auto neighbor = [&](std::ptrdiff_t step) -> Stitch* {
    for (auto n = std::ptrdiff_t(torn) + step; n >= 0 && n < std::ptrdiff_t(closure.stitches.size());
         n += step)
      if (bears(closure.stitches[std::size_t(n)].phase)) return &closure.stitches[std::size_t(n)];
    return nullptr;
  };
  Stitch *before = neighbor(-1), *after = neighbor(1);
  const double share = closure.stitches[torn].length / ((before != nullptr) + (after != nullptr));
  for (Stitch* stitch : {before, after})
    if (stitch) stitch->length += share;
  join_stitches(closure);
}

double thread_length(const WoundClosure& closure) {
  double sum = 0;
  for (const Stitch& stitch : closure.stitches)
    if (bears(stitch.phase)) sum += stitch.length;
  return sum;
}

}  // namespace turgor::lattice
