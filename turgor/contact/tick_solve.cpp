#include <algorithm>

#include "turgor/contact/touch_tick.hpp"
#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"

namespace turgor::contact {

namespace {

/// 3×3 block of C = Eᵀ Ξ E, column-major.
struct Block {
  double value[9] = {};
  void add(const double* from, std::size_t stride, double weight) {
    for (std::size_t j = 0; j < 3; j++)
      for (std::size_t i = 0; i < 3; i++) value[3 * j + i] += weight * from[j * stride + i];
  }
};

/// Block of a cluster with another cluster or a site.
Block block_of_clusters(const sfem::Patch& patch, const Site& row, const Site& column) {
  TURGOR_CHECK(is_index(column.level - 1, patch.levels.size()), "the level of a site belongs to the patch");
  const sfem::PatchLevel& level = patch.levels[std::size_t(column.level - 1)];
  const auto q = std::size_t(column.point.x);
  Block block;
  // clusters of the same level: precomputed
  if (row.level == column.level) {
    const std::size_t n = 3 * sfem::cluster_count(level);
    block.add(&level.compliance[3 * q * n + 3 * std::size_t(row.point.x)], n, 1);
    return block;
  }
  // cluster and points: motion of the points
  const std::size_t n = 3 * patch.points.size();
  visit_points(patch, row,
               [&](std::size_t p, double w) { block.add(&level.motion[3 * q * n + 3 * p], n, w); });
  return block;
}

/// Block of C between any two sites.
Block block_between(const sfem::Patch& patch, const Site& row, const Site& column) {
  if (column.level > 0) return block_of_clusters(patch, row, column);
  Block block;
  // by symmetry
  if (row.level > 0) {
    const Block other = block_of_clusters(patch, column, row);
    for (std::size_t k = 0; k < 9; k++) block.value[k] = other.value[k % 3 * 3 + k / 3];
    return block;
  }
  // points: weighted sum of the patch's compliance
  const std::size_t n = 3 * patch.points.size();
  visit_points(patch, column, [&](std::size_t q, double wq) {
    visit_points(patch, row, [&](std::size_t p, double wp) {
      block.add(&patch.compliance[3 * q * n + 3 * p], n, wp * wq);
    });
  });
  return block;
}

/// Fills the lower triangle of C.
void fill_compliance(Tick& tick) {
  TURGOR_CHECK(3 * tick.state.new_sites.size() <= std::size_t(tick.state.problem.stride),
               "contact sites fit the allocated capacity");
  TURGOR_CHECK(tick.viscous.total >= 0, "a viscous body is at least as stiff as an elastic one");
  FrictionalContactProblem& problem = tick.state.problem;
  const std::vector<Site>& sites = tick.state.new_sites;
  const auto stride = std::size_t(problem.stride);
  const double scale = 1 / (1 + tick.viscous.total);
  // A small compliance of each site itself. Without it, two tools that squeeze one point have no finite
  // solution, and many sites in one triangle have several.
  const double own = tick.state.params.tool_softness * scale * tick.state.surface.largest_softness;
  // blocks on and below the diagonal
  for (std::size_t j = 0; j < sites.size(); j++) {
    double* column = &problem.compliance[3 * j * stride];
    for (std::size_t i = j; i < sites.size(); i++) {
      const Block block = block_between(tick.patch, sites[i], sites[j]);
      for (std::size_t k = 0; k < 9; k++) column[k / 3 * stride + 3 * i + k % 3] = scale * block.value[k];
    }
    if (sites[j].state == SiteState::kHeld) continue;
    for (std::size_t axis = 0; axis < 3; axis++) column[axis * stride + 3 * j + axis] += own;
  }
}

/// Position of a point without any force of this tick.
Vec3d free_position(const Tick& tick, std::size_t point) {
  const Vec3d x = tick.patch.points[point].x + tick.state.offset[point];
  if (tick.viscous.count == 0) return x;
  return x + remembered_displacement(tick.viscous, tick.state.history, point);
}

/// Separation of a site from its tool without contact forces. Along the normal it is the gap to the tool's
/// tangent plane at the nearest point, across it the slip since the site stuck last.
Vec3d free_separation(const Tick& tick, const Site& site) {
  Vec3d x;
  visit_points(tick.patch, site, [&](std::size_t p, double w) { x += w * free_position(tick, p); });
  const Vec3d slip = x - to_world(tick.pose(std::size_t(site.tool)), site.anchor);
  if (site.state == SiteState::kHeld) return slip;
  const Vec3d now = weighted(tick.patch, site, tick.state.x), n = site.normal;
  return slip - dot(slip, n) * n + (site.distance + dot(n, x - now)) * n;
}

}  // namespace

void solve_sites(Tick& tick) {
  TouchState& state = tick.state;
  FrictionalContactProblem& problem = state.problem;
  std::vector<Site>& sites = state.new_sites;
  TURGOR_CHECK(std::is_partitioned(sites.begin(), sites.end(),
                                   [](const Site& s) { return s.state == SiteState::kHeld; }),
               "held sites come first");
  // the problem: C, b, initial forces, normals, friction
  problem.count = int(sites.size());
  problem.held = state.held;
  fill_compliance(tick);
  for (std::size_t s = 0; s < sites.size(); s++) {
    const Vec3d b = free_separation(tick, sites[s]), f = sites[s].force;
    for (int axis = 0; axis < 3; axis++) {
      problem.separation[3 * s + std::size_t(axis)] = b[axis];
      problem.force[3 * s + std::size_t(axis)] = f[axis];
    }
    problem.normal[s] = sites[s].normal;
    problem.friction[s] = tick.tools[std::size_t(sites[s].tool)].friction;
  }
  // solve
  state.solution = solve(problem, state.params.solver);
  // forces and states of the sites
  for (std::size_t s = 0; s < sites.size(); s++) {
    sites[s].force = {problem.force[3 * s], problem.force[3 * s + 1], problem.force[3 * s + 2]};
    sites[s].state = problem.state[s];
  }
}

}  // namespace turgor::contact
