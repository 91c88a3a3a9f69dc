#include <algorithm>

#include "turgor/contact/tick.hpp"

namespace turgor::contact {

namespace {

/// One block of C = Eᵀ Ξ E, column by column.
struct Block {
  double value[9] = {};
  void add(const double* from, std::size_t stride, double weight) {
    for (std::size_t j = 0; j < 3; j++)
      for (std::size_t i = 0; i < 3; i++) value[3 * j + i] += weight * from[j * stride + i];
  }
};

Block block_of_clusters(const sfem::Patch& patch, const Site& row, const Site& column) {
  const sfem::PatchLevel& level = patch.levels[std::size_t(column.level - 1)];
  const auto q = std::size_t(column.point.x);
  Block block;
  if (row.level == column.level) {
    const std::size_t n = 3 * sfem::cluster_count(level);
    block.add(&level.compliance[3 * q * n + 3 * std::size_t(row.point.x)], n, 1);
    return block;
  }
  const std::size_t n = 3 * patch.points.size();
  visit_points(patch, row,
               [&](std::size_t p, double w) { block.add(&level.motion[3 * q * n + 3 * p], n, w); });
  return block;
}

Block block_between(const sfem::Patch& patch, const Site& row, const Site& column) {
  if (column.level > 0) return block_of_clusters(patch, row, column);
  Block block;
  if (row.level > 0) {
    const Block other = block_of_clusters(patch, column, row);
    for (std::size_t k = 0; k < 9; k++) block.value[k] = other.value[k % 3 * 3 + k / 3];
    return block;
  }
  const std::size_t n = 3 * patch.points.size();
  visit_points(patch, column, [&](std::size_t q, double wq) {
    visit_points(patch, row, [&](std::size_t p, double wp) {
      block.add(&patch.compliance[3 * q * n + 3 * p], n, wp * wq);
    });
  });
  return block;
}

/// The lower triangle.
void fill_compliance(Tick& tick) {
  FrictionalContactProblem& problem = tick.state.problem;
  const std::vector<Site>& sites = tick.state.new_sites;
  const auto stride = std::size_t(problem.stride);
  const double scale = 1 / (1 + tick.viscous.p);
  // Two tools that squeeze one place, or many sites in one triangle, would have no finite answer, or many.
  const double own = tick.state.params.tool_softness * scale * tick.state.surface.largest_softness;
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

/// Where a point would be without any force of this tick.
Vec3d free_place(const Tick& tick, std::size_t point) {
  const Vec3d x = tick.patch.points[point].x + tick.state.offset[point];
  if (tick.viscous.p == 0) return x;
  return x + tick.viscous.p / (1 + tick.viscous.p) * tick.state.history.v[point];
}

/// The separation of a site from its tool if no force acted: along the normal, the gap to the tool's tangent
/// plane at its nearest place; across it, the slip since it stuck last.
Vec3d free_separation(const Tick& tick, const Site& site) {
  Vec3d x;
  visit_points(tick.patch, site, [&](std::size_t p, double w) { x += w * free_place(tick, p); });
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
  state.solution = solve(problem, state.params.solver);
  for (std::size_t s = 0; s < sites.size(); s++) {
    sites[s].force = {problem.force[3 * s], problem.force[3 * s + 1], problem.force[3 * s + 2]};
    sites[s].state = problem.state[s];
  }
}

}  // namespace turgor::contact
