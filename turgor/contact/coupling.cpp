#include "turgor/contact/coupling.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "turgor/contact/coupled_system.hpp"

namespace turgor::contact {

namespace {

constexpr int kMostSolves = 40;     // for taut ties and their directions
constexpr int kMostBreaks = 64;     // in one call; the rest breaks in the next one
constexpr double kLawError = 1e-8;  // see law_error

/// Once a frame there is more time than in a tick.
constexpr FrictionalContactParams kSolver{.sweeps = 500, .newton_steps = 40};

/// Force of a tie with this stretch.
Vec3d law(const Tie& tie, Vec3d stretch) {
  if (tie.slack == 0) return stretch * -tie.stiffness;
  const double size = norm(stretch), over = size - tie.slack;
  return over > 0 ? stretch * (-tie.stiffness * over / size) : Vec3d{};
}

/// Forces μ of all ties and sites, and d of each tie or separation of each site under them.
struct Loaded {
  std::vector<Vec3d> force, stretch;
};

/// d and separations under forces.
std::vector<Vec3d> stretched(const Exec& exec, const CoupledSystem& system,
                             const std::vector<Vec3d>& forces) {
  const std::size_t n = 3 * system.count;
  std::vector<Vec3d> stretch(system.count);
  parallel_for(
      exec, system.count,
      [&](std::size_t s) {
        Vec3d sum = system.free[s];
        for (std::size_t t = 0; t < system.count; t++) {
          if (forces[t] == Vec3d{}) continue;
          for (std::size_t axis = 0; axis < 3; axis++)
            for (std::size_t k = 0; k < 3; k++) {
              const std::size_t row = 3 * s + k, column = 3 * t + axis;
              sum[int(k)] +=
                  system.compliance[s >= t ? column * n + row : row * n + column] * forces[t][int(axis)];
            }
        }
        stretch[s] = sum;
      },
      16);
  return stretch;
}

/// Compliance T⁻¹ of a taut tie around a stretch, and its separation without forces: d + T⁻¹ λ for the
/// stretch d of the body. T = −dλ/dd has the stiffness k along d and k (1 − s/|d|) across it.
struct TautTie {
  Mat3d compliance;
  Vec3d separation;
};
TautTie linearized(const Tie& tie, Vec3d free, Vec3d stretch) {
  const double along = 1 / tie.stiffness;
  if (tie.slack == 0) return {{{{along, 0, 0}, {0, along, 0}, {0, 0, along}}}, free};
  const double size = norm(stretch), across = along / (1 - tie.slack / size);
  const Vec3d n = stretch / size;
  TautTie taut{{{{across, 0, 0}, {0, across, 0}, {0, 0, across}}}, free - n * tie.slack};
  for (int axis = 0; axis < 3; axis++) taut.compliance.column[axis] += n * (n[axis] * (along - across));
  return taut;
}

/// Ties that are taut, then all sites.
std::vector<std::size_t> taut_and_sites(const CoupledSystem& system, std::span<const Tie> ties,
                                        const Loaded& loaded) {
  constexpr double kTaut = 1 + 1e-9;  // a tie at its slack has no stiffness across it
  std::vector<std::size_t> used;
  for (std::size_t s = 0; s < system.tie.size(); s++)
    if (const Tie& tie = ties[system.tie[s]]; tie.slack == 0 || norm(loaded.stretch[s]) > kTaut * tie.slack)
      used.push_back(s);
  for (std::size_t s = system.tie.size(); s < system.count; s++) used.push_back(s);
  return used;
}

/// Copies these rows into a contact problem; ties are held sites.
void fill_problem(const CoupledSystem& system, std::span<const Tie> ties, std::span<const PairSite> sites,
                  const Loaded& loaded, const std::vector<std::size_t>& used, FrictionalContactProblem& p) {
  const std::size_t n = 3 * system.count;
  p.count = int(used.size()), p.held = 0;
  for (std::size_t j = 0; j < used.size(); j++) {
    // columns of C
    const std::size_t s = used[j];
    for (std::size_t axis = 0; axis < 3; axis++) {
      double* column = &p.compliance[(3 * j + axis) * std::size_t(p.stride)];
      for (std::size_t i = j; i < used.size(); i++)
        for (std::size_t k = 0; k < 3; k++)
          column[3 * i + k] = system.compliance[(3 * s + axis) * n + 3 * used[i] + k];
    }
    // own compliance and separation
    const double soft = system.softness[s];
    TautTie own{{{{soft, 0, 0}, {0, soft, 0}, {0, 0, soft}}}, system.free[s]};
    if (s < system.tie.size()) {
      own = linearized(ties[system.tie[s]], system.free[s], loaded.stretch[s]), p.held++;
    } else {
      const PairSite& site = sites[s - system.tie.size()];
      p.normal[j] = site.normal, p.friction[j] = site.friction;
    }
    for (std::size_t axis = 0; axis < 3; axis++) {
      double* column = &p.compliance[(3 * j + axis) * std::size_t(p.stride)];
      for (std::size_t k = 0; k < 3; k++) column[3 * j + k] += own.compliance.column[axis][int(k)];
      p.separation[3 * j + axis] = own.separation[int(axis)];
      p.force[3 * j + axis] = loaded.force[s][int(axis)];
    }
  }
}

/// State on the line from one state to another.
Loaded between(const Loaded& from, const Loaded& to, double length) {
  Loaded state = from;
  for (std::size_t s = 0; s < state.force.size(); s++) {
    state.force[s] += (to.force[s] - from.force[s]) * length;
    state.stretch[s] += (to.stretch[s] - from.stretch[s]) * length;
  }
  return state;
}

/// Sum of the squared differences between forces and law [N²].
double squared_error(const CoupledSystem& system, std::span<const Tie> ties, const Loaded& loaded) {
  double sum = 0;
  for (std::size_t s = 0; s < system.tie.size(); s++) {
    const Vec3d error = loaded.force[s] - law(ties[system.tie[s]], loaded.stretch[s]);
    sum += dot(error, error);
  }
  return sum;
}

/// State after a Newton step that is halved until the ties follow their law better.
Loaded shortened_step(const CoupledSystem& system, std::span<const Tie> ties, const Loaded& from, Loaded to,
                      double& length) {
  constexpr double kShortest = 1.0 / 32;
  const double before = squared_error(system, ties, from);
  if (squared_error(system, ties, to) < before) return to;
  for (length = 0.5; length > kShortest; length /= 2)
    if (Loaded state = between(from, to, length); squared_error(system, ties, state) < before) return state;
  return between(from, to, length);
}

/// Largest violation of the ties' law, relative to the largest force.
double law_error(const CoupledSystem& system, std::span<const Tie> ties, const Loaded& loaded) {
  double error = 0, largest = 0;
  for (std::size_t s = 0; s < system.tie.size(); s++) {
    error = std::max(error, norm(loaded.force[s] - law(ties[system.tie[s]], loaded.stretch[s])));
    largest = std::max(largest, norm(loaded.force[s]));
  }
  return largest > 0 ? error / largest : error;
}

/// Newton steps on the stretches of the ties, each with a solution of the contact problem, shortened so that
/// the ties follow their law better. Ties without slack need one step.
bool solve_set(const Exec& exec, const CoupledSystem& system, std::span<Tie> ties, std::span<PairSite> sites,
               FrictionalContactProblem& problem, int& solves) {
  // start from the present forces
  Loaded now;
  for (const std::size_t t : system.tie) now.force.push_back(ties[t].force);
  for (const PairSite& site : sites) now.force.push_back(site.force);
  now.stretch = stretched(exec, system, now.force);
  const bool is_linear = std::all_of(ties.begin(), ties.end(), [](const Tie& t) { return t.slack == 0; });
  bool converged = false;
  for (int n = 0; n < kMostSolves && !converged; n++, solves++) {
    // solution around the present stretches
    const std::vector<std::size_t> used = taut_and_sites(system, ties, now);
    Loaded next{std::vector<Vec3d>(system.count), {}};
    fill_problem(system, ties, sites, now, used, problem);
    const FrictionalContactReport report = solve(problem, kSolver);
    for (std::size_t j = 0; j < used.size(); j++) {
      next.force[used[j]] = {problem.force[3 * j], problem.force[3 * j + 1], problem.force[3 * j + 2]};
      if (used[j] >= system.tie.size()) sites[used[j] - system.tie.size()].state = problem.state[j];
    }
    if (is_linear) {
      now = std::move(next), converged = report.converged;
      break;
    }
    // step; the first one makes the forces of contacts those of the present geometry
    next.stretch = stretched(exec, system, next.force);
    double length = 1;
    now = n == 0 ? std::move(next) : shortened_step(system, ties, now, std::move(next), length);
    converged = length == 1 && report.converged && law_error(system, ties, now) <= kLawError;
  }
  // forces of the solution
  for (std::size_t s = 0; s < system.tie.size(); s++) ties[system.tie[s]].force = now.force[s];
  for (std::size_t s = system.tie.size(); s < system.count; s++)
    sites[s - system.tie.size()].force = now.force[s];
  return converged;
}

}  // namespace

bool break_one(std::span<Tie> ties) {
  Tie* weakest = nullptr;
  double most = 1;
  for (Tie& tie : ties) {
    if (tie.broken || tie.strength == 0) continue;
    if (const double load = norm(tie.force) / tie.strength; load > most) most = load, weakest = &tie;
  }
  if (!weakest) return false;
  weakest->broken = true, weakest->force = {};
  return true;
}

void break_overloaded(std::span<Tie> ties) {
  for (Tie& tie : ties)
    if (!tie.broken && tie.strength > 0 && norm(tie.force) > tie.strength) tie.broken = true, tie.force = {};
}

CouplingReport solve_coupling(const Exec& exec, std::span<const CoupledBody> bodies, std::span<Tie> ties,
                              std::span<PairSite> sites) {
  CouplingStorage storage;
  return solve_coupling(exec, bodies, ties, sites, storage);
}

CouplingReport solve_coupling(const Exec& exec, std::span<const CoupledBody> bodies, std::span<Tie> ties,
                              std::span<PairSite> sites, CouplingStorage& storage) {
  // room for a few more, since sites come and go
  if (const int count = int(ties.size() + sites.size()); count > storage.capacity) {
    storage.capacity = count + count / 8;
    storage.problem = make_frictional_contact_problem(storage.capacity);
  }
  CouplingReport report;
  for (;;) {
    fill_system(exec, bodies, ties, sites, storage.system);
    report.converged = solve_set(exec, storage.system, ties, sites, storage.problem, report.solves);
    if (report.broken == kMostBreaks || !break_one(ties)) break;
    report.broken++;
  }
  return report;
}

std::vector<VertexForce> forces_on(int body, std::span<const Tie> ties, std::span<const PairSite> sites) {
  std::map<int, Vec3d> sum;
  const auto add = [&](const SurfacePoint& point, Vec3d force) {
    if (point.body != body || force == Vec3d{}) return;
    for (int corner = 0; corner < 3; corner++)
      if (point.vertex[corner] >= 0 && point.weight[corner] != 0)
        sum[point.vertex[corner]] += force * point.weight[corner];
  };
  for (const Tie& tie : ties) add(tie.a, tie.force), add(tie.b, -tie.force);
  for (const PairSite& site : sites) add(site.a, site.force), add(site.b, -site.force);
  std::vector<VertexForce> list;
  for (const auto& [vertex, force] : sum) list.push_back({vertex, force});
  return list;
}

}  // namespace turgor::contact
