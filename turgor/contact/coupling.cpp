#include "turgor/contact/coupling.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/models/sfem/green.hpp"

namespace turgor::contact {

namespace {

constexpr int kMostSolves = 40;         // for taut ties and their directions
constexpr int kMostBreaks = 64;         // in one call; the rest breaks in the next one
constexpr double kLawError = 1e-8;      // see law_error
constexpr double kSiteSoftness = 1e-5;  // see TouchParams::tool_softness

/// Once a frame there is more time than in a tick.
constexpr FrictionalContactParams kSolver{.sweeps = 500, .newton_steps = 40};

/// A vertex that a tie or a site moves, with its signed weight.
struct Carrier {
  int body = 0, vertex = 0;
  double weight = 0;
};
/// All vertices of one tie or site that can move.
struct Carriers {
  std::array<Carrier, 6> list;
  std::size_t count = 0;
};

void add_carriers(std::span<const CoupledBody> bodies, const SurfacePoint& point, double sign,
                  Carriers& carriers) {
  if (point.body < 0) return;
  TURGOR_CHECK(is_index(point.body, bodies.size()) && bodies[std::size_t(point.body)].model,
               "surface points belong to coupled bodies");
  const sfem::Model& model = *bodies[std::size_t(point.body)].model;
  for (int corner = 0; corner < 3; corner++) {
    const int v = point.vertex[corner];
    if (v < 0 || point.weight[corner] == 0 || model.free_node[std::size_t(v)] < 0) continue;
    carriers.list[carriers.count++] = {point.body, v, sign * point.weight[corner]};
  }
}

/// 3×3 block of C, column-major, between two ties or sites.
std::array<double, 9> block_between(std::span<const CoupledBody> bodies, const Carriers& row,
                                    const Carriers& column) {
  std::array<double, 9> sum{};
  for (std::size_t j = 0; j < column.count; j++)
    for (std::size_t i = 0; i < row.count; i++) {
      const Carrier &r = row.list[i], &c = column.list[j];
      if (r.body != c.body) continue;
      const CoupledBody& body = bodies[std::size_t(r.body)];
      const sfem::Green& green = body.model->green;
      std::array<double, 9> block{};
      sfem::green_block(green, green.slot[std::size_t(r.vertex)], green.slot[std::size_t(c.vertex)], block);
      const double weight = r.weight * c.weight / body.stiffness_scale;
      for (std::size_t k = 0; k < 9; k++) sum[k] += weight * block[k];
    }
  return sum;
}

/// The whole system: all ties that are not broken, then all sites.
struct CoupledSystem {
  std::vector<std::size_t> tie;    // index of each tie
  std::size_t count = 0;           // ties and sites
  std::vector<double> compliance;  // C, 3·count square, column-major, lower blocks [m/N]
  std::vector<Vec3d> free;         // d of each tie, and separation of each site, without forces [m]
  double softness = 0;             // own compliance of every site [m/N]
};

double mean_diagonal(const CoupledSystem& system, std::size_t s) {
  const std::size_t n = 3 * system.count;
  double sum = 0;
  for (std::size_t axis = 0; axis < 3; axis++) sum += system.compliance[(3 * s + axis) * (n + 1)];
  return sum / 3;
}

/// Separation of a site without forces: the distance along its normal, and the slip across it.
Vec3d free_separation(std::span<const CoupledBody> bodies, const PairSite& site) {
  const auto at = [&](const SurfacePoint& p) {
    return p.rest + (p.body < 0 ? Vec3d{} : displacement_of(p, bodies[std::size_t(p.body)].free));
  };
  const Vec3d n = site.normal, a = at(site.a);
  const Vec3d slip = a - at(site.anchor) - site.slip;
  const double distance = site.distance + dot(n, a - at(site.b) - site.found);
  return slip - dot(slip, n) * n + distance * n;
}

CoupledSystem make_system(const Exec& exec, std::span<const CoupledBody> bodies, std::span<const Tie> ties,
                          std::span<const PairSite> sites) {
  CoupledSystem system;
  std::vector<Carriers> carriers;
  // ties, then sites
  for (std::size_t t = 0; t < ties.size(); t++) {
    if (ties[t].broken) continue;
    system.tie.push_back(t);
    system.free.push_back(free_stretch(bodies, ties[t]));
    add_carriers(bodies, ties[t].a, 1, carriers.emplace_back());
    add_carriers(bodies, ties[t].b, -1, carriers.back());
  }
  for (const PairSite& site : sites) {
    system.free.push_back(free_separation(bodies, site));
    add_carriers(bodies, site.a, 1, carriers.emplace_back());
    add_carriers(bodies, site.b, -1, carriers.back());
  }
  // compliance, column by column
  system.count = carriers.size();
  const std::size_t n = 3 * system.count;
  system.compliance.resize(n * n);
  parallel_for(
      exec, system.count,
      [&](std::size_t j) {
        for (std::size_t i = j; i < system.count; i++) {
          const std::array<double, 9> block = block_between(bodies, carriers[i], carriers[j]);
          for (std::size_t k = 0; k < 9; k++)
            system.compliance[(3 * j + k / 3) * n + 3 * i + k % 3] = block[k];
        }
      },
      4);
  for (std::size_t s = system.tie.size(); s < system.count; s++)
    system.softness = std::max(system.softness, kSiteSoftness * mean_diagonal(system, s));
  return system;
}

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
    const double soft = system.softness;
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

/// Breaks the most overloaded tie; false if none is.
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

}  // namespace

Vec3d displacement_of(const SurfacePoint& point, std::span<const Vec3d> displacement) {
  Vec3d sum;
  if (point.body < 0) return sum;
  for (int corner = 0; corner < 3; corner++)
    if (const int v = point.vertex[corner]; v >= 0)
      sum += displacement[std::size_t(v)] * point.weight[corner];
  return sum;
}

Vec3d free_stretch(std::span<const CoupledBody> bodies, const Tie& tie) {
  const auto moved = [&](const SurfacePoint& p) {
    return p.body < 0 ? Vec3d{} : displacement_of(p, bodies[std::size_t(p.body)].free);
  };
  return moved(tie.a) - moved(tie.b);
}

CouplingReport solve_coupling(const Exec& exec, std::span<const CoupledBody> bodies, std::span<Tie> ties,
                              std::span<PairSite> sites) {
  CouplingReport report;
  FrictionalContactProblem problem = make_frictional_contact_problem(int(ties.size() + sites.size()));
  for (;;) {
    const CoupledSystem system = make_system(exec, bodies, ties, sites);
    report.converged = solve_set(exec, system, ties, sites, problem, report.solves);
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
