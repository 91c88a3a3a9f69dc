// Forces of stitches, and the multipliers of stitches and walls.
#include "turgor/models/lattice/suture/closure.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/core/assert.hpp"
#include "turgor/models/lattice/suture/thread_loop.hpp"
#include "turgor/models/lattice/suture/wall_contact.hpp"

namespace turgor::lattice {

namespace {

/// Share of the error that a step removes from a multiplier. Bodies settle in a few steps; larger values
/// let soft bodies with inertia oscillate.
constexpr double kRelaxation = 0.3;
/// Gape at which lips count as closed [m].
constexpr double kClosedGape = 1e-4;
/// Thread pulled in per step, over the gape, after the time of the pull. The lips of an excision travel far:
/// a faster pull would overshoot before the tissue follows.
constexpr double kSlowPull = 0.1;

PointStiffness sum_of(const PointStiffness& a, const PointStiffness& b) {
  return {a.xx + b.xx, a.yy + b.yy, a.zz + b.zz, a.xy + b.xy, a.xz + b.xz, a.yz + b.yz};
}

/// Updates a stitch and its springs. L = Σ |x_{p+1} − x_p|, multiplier λ, penalty κ:
///   T = max(0, λ + κ (L − L₀)),  f_p = −T ∂L/∂x_p = T g
/// A point's stiffness bounds its coupling with the n − 1 others: n κ g gᵀ + 2 T Σ (I − e eᵀ)/l. Strands in
/// bites that keep their length have no force: the tissue between their points bears the thread.
/// [Hestenes 1969] In a settled closure, λ = 0 and κ = EA/L₀, so that the thread has the energy ½ κ (L −
/// L₀)².
void update_stitch(const Model& model, const Motion& motion, const WoundClosure& closure, Stitch& stitch,
                   std::span<PointSpring> springs) {
  const Loop loop = loop_of(stitch, motion);
  const std::size_t count = stitch.rest.size();
  // tension
  double penalty = 0;
  if (stitch.length > 0) {
    penalty = closure.settled ? closure.thread.stiffness / stitch.length
                              : penalty_of(model, closure.thread, stitch);
    const double kept = closure.settled ? 0 : stitch.multiplier;
    stitch.tension = std::max(0.0, kept + penalty * (loop.total() - stitch.length));
  }
  // springs
  const bool is_taut = stitch.tension > 0;
  springs[0].coupling.stiffness = is_taut ? Real(penalty) : 0;
  for (std::size_t p = 0; p < count; p++) {
    const Vec3d g = loop.pull_across(p);
    PointSpring& spring = springs[p];
    spring.force = Vec3(g * stitch.tension);
    spring.target = displacement(spring.at, motion);
    spring.stiffness = outer(g, is_taut ? double(count) * penalty : 0);
    for (const std::size_t strand : {p, loop.before(p)})
      if (!loop.is_bite[strand] && loop.length[strand] > 0)
        spring.stiffness = sum_of(
            spring.stiffness,
            axial_stiffness(Vec3(loop.direction[strand]), 0, Real(2 * stitch.tension / loop.length[strand])));
  }
}

/// Gives a stitch of prescribed tension the thread that its loop has under this tension.
void end_pull(const Motion& motion, const Thread& thread, Stitch& stitch) {
  stitch.length = loop_length(stitch, motion) / (1 + stitch.tension / thread.stiffness);
  stitch.multiplier = stitch.tension;
}

/// Pulls one stitch; `elapsed`: time since the start of the pull [s].
void pull_stitch(const Motion& motion, const Pull& pull, double elapsed, const Thread& thread,
                 Stitch& stitch) {
  const double share = pull.duration > 0 ? elapsed / pull.duration : 1;
  // length of the thread
  if (pull.until_closed) {
    const double rest = rest_length(stitch), slack = std::max(stitch.before - rest, 0.1 * rest);
    const bool is_closed = share >= 1 && gape_under(stitch, motion) <= kClosedGape;
    if (is_closed || stitch.length == stitch.shortest) {
      if (stitch.length == 0) end_pull(motion, thread, stitch);
      stitch.phase = StitchPhase::kKnotted;
      return;
    }
    double length = stitch.before - share * slack;
    if (share > 1 && stitch.gap > 0)
      length = std::max(length, stitch.length - kSlowPull * gape_under(stitch, motion));
    stitch.length = std::max(length, stitch.shortest);
    return;
  }
  // tension
  stitch.tension = pull.from + (pull.tension - pull.from) * std::min(1.0, share);
  if (share < 1) return;
  end_pull(motion, thread, stitch);
  stitch.phase = StitchPhase::kKnotted;
}

/// Strands between positions of the points of a stitch.
Loop loop_through(const Stitch& stitch, std::span<const Vec3d> x) {
  constexpr double kShortest = 1e-9;  // [m]
  const std::size_t count = stitch.rest.size();
  Loop loop{std::vector<Vec3d>(count), std::vector<double>(count), std::vector<char>(count)};
  for (std::size_t p = 0; p + (stitch.is_open ? 1 : 0) < count; p++) {
    const std::size_t next = (p + 1) % count;
    const Vec3d d = x[next] - x[p];
    loop.is_bite[p] = stitch.keeps_bites && stitch.side[p] == stitch.side[next];
    loop.length[p] =
        loop.is_bite[p] ? norm(stitch.rest[next] - stitch.rest[p]) : std::max(norm(d), kShortest);
    loop.direction[p] = d / std::max(norm(d), kShortest);
  }
  return loop;
}

/// Turns the threads, walls and rims of a closure that has come to rest into springs with the present forces.
void make_springs(const Model& model, const Motion& motion, WoundClosure& closure) {
  closure.settled = true;
  // the thread of a running suture keeps its length
  for (Stitch& stitch : closure.stitches)
    if (bears(stitch.phase) && !closure.is_running)
      stitch.length = loop_length(stitch, motion) / (1 + stitch.tension / closure.thread.stiffness);
  for (WallPair& pair : closure.walls)
    if (pair.at.parted)
      pair.multiplier =
          pair.force > 0 ? pair.force + wall_stiffness(model, pair, true) * gap_of(pair, motion) : 0;
}

}  // namespace

bool bears(const WoundClosure& closure) {
  return std::any_of(closure.stitches.begin(), closure.stitches.end(),
                     [](const Stitch& stitch) { return bears(stitch.phase); });
}

std::vector<Vec3d> points_now(const Stitch& stitch, const Motion& motion) {
  std::vector<Vec3d> points = stitch.rest;
  for (std::size_t p = 0; p < points.size(); p++) points[p] += Vec3d(displacement(stitch.at[p], motion));
  return points;
}

Loop loop_of(const Stitch& stitch, const Motion& motion) {
  return loop_through(stitch, points_now(stitch, motion));
}

Loop rest_loop_of(const Stitch& stitch) { return loop_through(stitch, stitch.rest); }

double penalty_of(const Model& model, const Thread& thread, const Stitch& stitch) {
  return std::min(penalty_at(model, stitch.at[0]), thread.stiffness / stitch.length);
}

void pull_stitches(const Motion& motion, const Pull& pull, double time, WoundClosure& closure) {
  if (time < pull.start) return;
  for (Stitch& stitch : closure.stitches) {
    if (stitch.phase == StitchPhase::kWaiting) {
      stitch.phase = StitchPhase::kPulled;
      stitch.before = loop_length(stitch, motion);
    }
    if (stitch.phase != StitchPhase::kPulled) continue;
    closure.settled = false;
    pull_stitch(motion, pull, time - pull.start, closure.thread, stitch);
  }
}

void untie_stitches(const Motion& motion, WoundClosure& closure) {
  closure.settled = false;
  for (Stitch& stitch : closure.stitches) {
    if (!bears(stitch.phase)) continue;
    stitch.phase = StitchPhase::kPulled;
    stitch.length = 0, stitch.before = loop_length(stitch, motion);
  }
}

double loop_length(const Stitch& stitch, const Motion& motion) { return loop_of(stitch, motion).total(); }

double gape_under(const Stitch& stitch, const Motion& motion) {
  if (!stitch.lips.parted) return 0;
  return stitch.gap +
         dot(Vec3d(displacement(stitch.lips.right, motion)) - Vec3d(displacement(stitch.lips.left, motion)),
             stitch.across);
}

std::vector<Vec3d> stitch_forces(const Stitch& stitch, const Motion& motion) {
  std::vector<Vec3d> forces(stitch.rest.size());
  if (!bears(stitch.phase)) return forces;
  const Loop loop = loop_of(stitch, motion);
  for (std::size_t p = 0; p < forces.size(); p++) forces[p] = loop.pull(p) * stitch.tension;
  return forces;
}

double thread_force(const WoundClosure& closure, const Motion& motion) {
  double sum = 0;
  for (const Stitch& stitch : closure.stitches) {
    const std::vector<Vec3d> forces = stitch_forces(stitch, motion);
    for (std::size_t p = 0; p < forces.size(); p++)
      if (stitch.side[p] < 0) sum += dot(forces[p], stitch.across);
  }
  return sum;
}

double closing_force(const WoundClosure& closure, const Motion& motion) {
  return thread_force(closure, motion) - wall_force(closure);
}

std::size_t spring_count(const WoundClosure& closure) {
  if (!bears(closure)) return 0;
  std::size_t count = 0;
  for (const Stitch& stitch : closure.stitches)
    if (bears(stitch.phase)) count += stitch.at.size();
  for (const WallPair& pair : closure.walls) count += pair.at.parted ? 2 : 0;
  return count;
}

double stored_energy(const Model& model, const Motion& motion, const WoundClosure& closure) {
  double sum = 0;
  if (!bears(closure)) return sum;
  for (const Stitch& stitch : closure.stitches) {
    if (!bears(stitch.phase) || stitch.length == 0) continue;
    const double stretch = std::max(0.0, loop_length(stitch, motion) - stitch.length);
    sum += 0.5 * closure.thread.stiffness / stitch.length * stretch * stretch;
  }
  for (const WallPair& pair : closure.walls) {
    if (!pair.at.parted || !closure.settled) continue;
    const double stiffness = wall_stiffness(model, pair, true),
                 force = std::max(0.0, pair.multiplier - stiffness * gap_of(pair, motion));
    sum += 0.5 * force * force / stiffness;
  }
  return sum;
}

void append_springs(const WoundClosure& closure, std::vector<PointSpring>& springs) {
  if (!bears(closure)) return;
  for (const Stitch& stitch : closure.stitches) {
    if (!bears(stitch.phase)) continue;
    const Loop loop = rest_loop_of(stitch);
    for (std::size_t p = 0; p < stitch.at.size(); p++)
      springs.push_back({.at = stitch.at[p],
                         .coupling = {.direction = Vec3(loop.pull_across(p)),
                                      .count = p == 0 ? int(stitch.at.size()) : 0}});
  }
  for (const WallPair& pair : closure.walls) {
    if (!pair.at.parted) continue;
    const Vec3 n(pair.normal);
    springs.push_back({.at = pair.at.left, .coupling = {.direction = -n, .count = 2}});
    springs.push_back({.at = pair.at.right, .coupling = {.direction = n}});
  }
}

void update_springs(const Model& model, const Motion& motion, WoundClosure& closure,
                    std::span<PointSpring> springs) {
  TURGOR_CHECK(springs.size() == spring_count(closure), "every point of a closure has a spring");
  if (springs.empty()) return;
  std::size_t next = 0;
  for (Stitch& stitch : closure.stitches) {
    if (!bears(stitch.phase)) continue;
    update_stitch(model, motion, closure, stitch, springs.subspan(next, stitch.at.size()));
    next += stitch.at.size();
  }
  for (WallPair& pair : closure.walls) {
    if (!pair.at.parted) continue;
    update_wall(model, motion, closure.settled, pair, springs.subspan(next, 2));
    next += 2;
  }
}

void update_multipliers(const Model& model, const Motion& motion, WoundClosure& closure) {
  constexpr double kSettled = 1e-3;  // change over the largest tension
  if (!bears(closure)) {
    closure.settled = true;
    return;
  }
  if (closure.settled) {
    // a stitch that is pulled again goes on with its tension
    for (Stitch& stitch : closure.stitches)
      if (bears(stitch.phase))
        stitch.multiplier = stitch.tension - penalty_of(model, closure.thread, stitch) *
                                                 (loop_length(stitch, motion) - stitch.length);
    if (closure.is_running) slide_thread(model, motion, closure);
    return;
  }
  double largest = 0, change = 0;
  bool is_pulled = false;
  const auto move = [&change](double& multiplier, double by) {
    const double moved = std::max(0.0, multiplier + kRelaxation * by);
    change = std::max(change, std::abs(moved - multiplier));
    multiplier = moved;
  };
  // threads: the error of the law T = k (L − L₀)
  for (Stitch& stitch : closure.stitches) {
    is_pulled = is_pulled || stitch.phase == StitchPhase::kPulled;
    if (!bears(stitch.phase) || stitch.length == 0) continue;
    const double k = closure.thread.stiffness / stitch.length,
                 error = loop_length(stitch, motion) - stitch.length - stitch.tension / k;
    move(stitch.multiplier, penalty_of(model, closure.thread, stitch) * error);
    largest = std::max(largest, stitch.tension);
  }
  // walls: the overlap
  for (WallPair& pair : closure.walls)
    if (pair.at.parted) move(pair.multiplier, -penalty_at(model, pair.at.left) * gap_of(pair, motion));
  if (closure.is_running) change = std::max(change, slide_thread(model, motion, closure));
  if (!is_pulled && change <= kSettled * largest) make_springs(model, motion, closure);
}

void end_overloaded_stitches(const Motion& motion, double time, WoundClosure& closure) {
  bool has_broken = false;
  const auto end = [&](Stitch& stitch, StitchPhase phase) {
    stitch.phase = phase;
    stitch.tension = stitch.multiplier = 0, stitch.ended = time;
    closure.settled = false;
  };
  for (std::size_t n = 0; n < closure.stitches.size(); n++) {
    Stitch& stitch = closure.stitches[n];
    if (!bears(stitch.phase)) continue;
    double most = 0;
    for (const Vec3d f : stitch_forces(stitch, motion)) most = std::max(most, norm(f));
    const bool breaks = stitch.tension > closure.thread.strength, tears = most > closure.pull_out;
    if (breaks || tears) end(stitch, breaks ? StitchPhase::kBroken : StitchPhase::kPulledOut);
    if (tears && !breaks && closure.is_running) free_thread(closure, n);
    has_broken = has_broken || breaks;
  }
  // one thread
  if (has_broken && closure.is_running)
    for (Stitch& stitch : closure.stitches)
      if (bears(stitch.phase)) end(stitch, StitchPhase::kBroken);
}

}  // namespace turgor::lattice
