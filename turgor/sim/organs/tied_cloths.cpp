#include "turgor/sim/organs/tied_cloths.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/core/sort_unique.hpp"
#include "turgor/core/timing.hpp"
#include "turgor/models/cloth/forces/vertex_springs.hpp"
#include "turgor/sim/organs/anderson.hpp"
#include "turgor/sim/organs/support.hpp"
#include "turgor/sim/organs/swept_body.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

namespace {

constexpr int kMostSteps = 12;         // of each cloth in a frame
constexpr double kForceChange = 1e-5;  // between the last two steps, relative to the largest force

/// Cloths of an attachment between two cloths: the one whose vertices are tied, and the other one.
struct ClothPair {
  int own = -1, other = -1;
};
ClothPair cloth_pair(const World& world, const Attachment& attachment) {
  if (attachment.swept < 0 || attachment.ties.empty()) return {};
  const contact::Tie& tie = attachment.ties[0];
  if (tie.a.body < 0 || tie.b.body < 0) return {};
  const BodyId a = coupled_body(world, tie.a.body), b = coupled_body(world, tie.b.body);
  if (a.kind != BodyKind::kCloth || b.kind != BodyKind::kCloth) return {};
  return attachment.swept == 0 ? ClothPair{a.index, b.index} : ClothPair{b.index, a.index};
}

std::vector<ClothPair> cloth_pairs(const World& world) {
  std::vector<ClothPair> pairs;
  for (const Attachment& attachment : world.coupling.attachments)
    if (const ClothPair pair = cloth_pair(world, attachment); pair.own >= 0) pairs.push_back(pair);
  return pairs;
}

/// All cloths that pairs join to this one, directly or not, ascending.
std::vector<int> joined_cloths(const std::vector<ClothPair>& pairs, int cloth) {
  std::vector<int> joined{cloth};
  for (std::size_t size = 0; size < joined.size();) {
    size = joined.size();
    for (const ClothPair& pair : pairs) {
      const bool has_own = std::binary_search(joined.begin(), joined.end(), pair.own);
      const bool has_other = std::binary_search(joined.begin(), joined.end(), pair.other);
      if (has_own != has_other) joined.push_back(has_own ? pair.other : pair.own), sort_unique(joined);
    }
  }
  return joined;
}

/// Spring between two cloths in their steps.
struct ClothTie {
  contact::Tie* tie;
  double sign;             // of the tie's force, on the own vertex
  std::size_t own, other;  // indices of steps
  int vertex;              // of the own model
  std::array<int, 3> corner;
  Vec3d weight;         // of the other point in vertices of the other model
  Vec3d offset;         // rest position of the own point minus that of the other one [m]
  double softness = 0;  // S [m/N]

  cloth::VertexSpring spring(Vec3d target) const {
    return {.vertex = vertex,
            .target = Vec3(target),
            .stiffness = Real(tie->stiffness / (1 + tie->stiffness * softness)),
            .slack = Real(tie->slack)};
  }
  Vec3d force() const { return tie->force * sign; }
  /// Position of the other point plus the offset, from positions of the other cloth's vertices [m].
  Vec3d other_end(const cloth::Vectors& x) const {
    Vec3d end = offset;
    for (int k = 0; k < 3; k++) end += Vec3d(x[std::size_t(corner[std::size_t(k)])]) * weight[k];
    return end;
  }
};

/// Index of the step of a cloth; their number if it is not one of these.
std::size_t step_of(const World& world, const std::vector<ClothStep>& steps, int cloth) {
  std::size_t s = 0;
  while (s < steps.size() && (cloth < 0 || &steps[s].body != &world.cloth_bodies[std::size_t(cloth)])) s++;
  return s;
}

std::vector<ClothTie> ties_between(World& world, const std::vector<ClothStep>& steps) {
  std::vector<ClothTie> ties;
  for (Attachment& attachment : world.coupling.attachments) {
    const ClothPair pair = cloth_pair(world, attachment);
    const std::size_t own_step = step_of(world, steps, pair.own),
                      other_step = step_of(world, steps, pair.other);
    if (own_step == steps.size()) continue;
    for (contact::Tie& tie : attachment.ties) {
      if (tie.broken) continue;
      const bool is_a = attachment.swept == 0;
      const contact::SurfacePoint &own = is_a ? tie.a : tie.b, &other = is_a ? tie.b : tie.a;
      const std::vector<int>& carrier = swept_support(world, other.body).carrier;
      ties.push_back({.tie = &tie,
                      .sign = is_a ? 1.0 : -1.0,
                      .own = own_step,
                      .other = other_step,
                      .vertex = swept_support(world, own.body).carrier[std::size_t(own.vertex.x)],
                      .corner = {carrier[std::size_t(other.vertex.x)], carrier[std::size_t(other.vertex.y)],
                                 carrier[std::size_t(other.vertex.z)]},
                      .weight = other.weight,
                      .offset = own.rest - other.rest});
    }
  }
  return ties;
}

/// Sets S of all ties: the sum of their compliances h² Σ w_s w_t/m with all ties s of the same cloth, whose
/// forces are taken to be proportional to their stiffness. No other distribution has a larger compliance.
void set_softness(const std::vector<ClothStep>& steps, double dt, std::vector<ClothTie>& ties) {
  std::vector<std::vector<double>> stiffness(steps.size());
  for (std::size_t s = 0; s < steps.size(); s++) stiffness[s].resize(steps[s].body.state->x.size());
  for (const ClothTie& tie : ties)
    for (int k = 0; k < 3; k++)
      stiffness[tie.other][std::size_t(tie.corner[std::size_t(k)])] += tie.weight[k] * tie.tie->stiffness;
  for (ClothTie& tie : ties) {
    const aligned_vector<Real>& mass = steps[tie.other].body.state->free_mass;
    for (int k = 0; k < 3; k++) {
      const auto v = std::size_t(tie.corner[std::size_t(k)]);
      if (mass[v] > 0)
        tie.softness +=
            dt * dt * tie.weight[k] * stiffness[tie.other][v] / (double(mass[v]) * tie.tie->stiffness);
    }
  }
}

/// Steps every cloth once with the springs' targets, and sets the forces.
void step_once(const Exec& exec, double dt, std::span<const Vec3d> target, const std::vector<ClothTie>& ties,
               std::vector<ClothStep>& steps) {
  for (std::size_t s = 0; s < steps.size(); s++) {
    ClothStep& step = steps[s];
    // springs on own vertices, and the forces of those that others have solved for
    cloth::Inputs inputs = step.inputs;
    for (std::size_t n = 0; n < ties.size(); n++) {
      const ClothTie& tie = ties[n];
      if (tie.own == s) inputs.springs.push_back(tie.spring(target[n]));
      if (tie.other != s) continue;
      for (int k = 0; k < 3; k++)
        if (tie.weight[k] != 0)
          inputs.loads.push_back({tie.corner[std::size_t(k)], Vec3(tie.force() * -tie.weight[k])});
    }
    const Timer timer;
    step.report = step.body.state.step(exec, step.body.model, inputs, dt);
    step.seconds += timer.seconds();
    // forces
    for (std::size_t n = 0; n < ties.size(); n++) {
      if (ties[n].own != s) continue;
      const Vec3 x = step.body.state->x[std::size_t(ties[n].vertex)];
      ties[n].tie->force = Vec3d(cloth::spring_force(ties[n].spring(target[n]), x).force) * ties[n].sign;
    }
  }
}

/// Targets at the present motion of the other cloths, which have moved for `ahead` seconds [m].
void aim(double ahead, const std::vector<ClothStep>& steps, const std::vector<ClothTie>& ties,
         std::span<Vec3d> target) {
  for (std::size_t n = 0; n < ties.size(); n++) {
    const ClothTie& tie = ties[n];
    const cloth::State& other = steps[tie.other].body.state;
    target[n] = tie.other_end(other.x) + tie.force() * tie.softness;
    if (ahead > 0) target[n] += (tie.other_end(other.v) - tie.offset) * ahead;
  }
}

std::span<double> numbers(std::vector<Vec3d>& values) {
  static_assert(sizeof(Vec3d) == 3 * sizeof(double));
  return {values.empty() ? nullptr : &values[0].x, 3 * values.size()};
}

/// Largest force of a spring, and largest change of one since `before`; both 0 where it is not finite [N].
struct LargestForces {
  double force = 0, change = 0;
};
LargestForces largest_forces(const std::vector<ClothTie>& ties, const std::vector<Vec3d>& before) {
  LargestForces largest;
  for (std::size_t n = 0; n < ties.size(); n++) {
    largest.force = std::max(largest.force, norm(ties[n].tie->force));
    largest.change = std::max(largest.change, norm(ties[n].tie->force - before[n]));
  }
  return largest;
}

}  // namespace

std::vector<int> cloths_stepped_with(const World& world, int cloth) {
  std::vector<ClothPair> pairs = cloth_pairs(world);
  std::vector<int> left = joined_cloths(pairs, cloth), order;
  while (!left.empty()) {
    // the first that bears the force of no other one that is left
    const auto bears = [&](int index) {
      return std::any_of(pairs.begin(), pairs.end(), [&](const ClothPair& pair) {
        return pair.other == index && std::find(left.begin(), left.end(), pair.own) != left.end();
      });
    };
    auto next = std::find_if_not(left.begin(), left.end(), bears);
    if (next == left.end()) next = left.begin();
    order.push_back(*next);
    left.erase(next);
  }
  return order;
}

void step_tied_cloths(const Exec& exec, World& world, std::vector<ClothStep>& steps) {
  std::vector<ClothTie> ties = ties_between(world, steps);
  set_softness(steps, world.dt, ties);
  std::vector<cloth::State> start;
  for (const ClothStep& step : steps) start.push_back(*step.body.state);
  // first targets: the others keep their velocities and their forces
  std::vector<Vec3d> target(ties.size()), image(ties.size()), before(ties.size());
  aim(world.dt, steps, ties, target);
  AndersonMixing mixing;
  for (int n = 1;; n++) {
    for (std::size_t t = 0; t < ties.size(); t++) before[t] = ties[t].tie->force;
    step_once(exec, world.dt, target, ties, steps);
    const auto is_finite = [](const ClothStep& step) { return step.report.finite; };
    const LargestForces largest = largest_forces(ties, before);
    if (n == kMostSteps || !std::all_of(steps.begin(), steps.end(), is_finite) ||
        !(largest.change > kForceChange * largest.force))
      break;
    // again from the same state
    aim(0, steps, ties, image);
    mixing.advance(numbers(image), numbers(target));
    for (std::size_t s = 0; s < steps.size(); s++) steps[s].body.state.change() = start[s];
  }
  for (Attachment& attachment : world.coupling.attachments)
    if (step_of(world, steps, cloth_pair(world, attachment).own) < steps.size())
      contact::break_overloaded(attachment.ties);
}

}  // namespace turgor
