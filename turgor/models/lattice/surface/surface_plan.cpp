#include "turgor/models/lattice/surface/surface_plan.hpp"

#include <algorithm>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"

namespace turgor::lattice::detail {

namespace {

constexpr std::size_t kVerticesPerTask = 4096, kCornersPerTask = 1024;

/// Corners and weights of all vertices; `index` is that of the corner itself.
void find_corners(const Exec& exec, const Model& model, const BodySurface& surface, SurfacePlan& plan) {
  const Vec3 h = model.anatomy.lattice.spacing;
  plan.of_vertex.resize(surface.rest.size());
  const auto find = [&](std::size_t v) {
    const EmbeddingCell& embedding = surface.embedding[v];
    const Vec3 at = surface.rest[v];
    plan.of_vertex[v].index = corners_of(model, *surface.fragments, embedding.cell, embedding.fragment);
    plan.of_vertex[v].weight = trilinear(Vec3{at.x / h.x, at.y / h.y, at.z / h.z} -
                                         Vec3(slot_node(model.anatomy.lattice, embedding.cell)));
  };
  parallel_for(exec, plan.of_vertex.size(), find, kVerticesPerTask);
}

/// Lists every corner with a weight once.
void number_corners(const Model& model, const BodySurface& surface, SurfacePlan& plan) {
  std::vector<int> number(
      std::size_t(slot_count(model.anatomy.lattice)) + surface.fragments->virtual_nodes.size(), -1);
  for (VertexCorners& vertex : plan.of_vertex)
    for (std::size_t c = 0; c < 8; c++) {
      int& n = number[std::size_t(vertex.index[c])];
      vertex.index[c] = vertex.weight[c] == 0 ? 0 : n;
      if (vertex.weight[c] == 0 || n >= 0) continue;
      n = vertex.index[c] = int(plan.corners.size());
      plan.corners.push_back(int(&n - number.data()));
    }
}

/// True if no edge between nodes less than three rows from a corner is cut. Its terms do not depend on the
/// cuts then. `row_cut` marks rows next to a cut edge.
bool is_far_from_cuts(const Lattice& l, const Cuts& cuts, int corner) {
  const int stride = row_stride(l), layer = layer_stride(l);
  for (int dk = -1; dk <= 1; dk++)
    for (int dj = -1; dj <= 1; dj++) {
      const int slot = corner + dk * layer + dj * stride;
      if (slot < 0 || std::size_t(slot / stride) >= cuts.row_cut.size()) continue;
      if (cuts.row_cut[std::size_t(slot / stride)]) return false;
    }
  return true;
}

/// Rows within two rows of a removed node, which terms of their corners may refer to. Empty: no node is
/// removed. Terms there are not kept, so that kept ones do not depend on removed nodes.
std::vector<std::uint8_t> rows_near_removed(const Lattice& l, const Cuts& cuts) {
  constexpr int kReach = 2;
  const int stride = row_stride(l), rows = l.size.y + 2;
  std::vector<std::uint8_t> near;
  for (std::size_t slot = 0; slot < cuts.removed.size(); slot++) {
    if (cuts.removed[slot] == 0) continue;
    if (near.empty()) near.assign(cuts.removed.size() / std::size_t(stride) + 1, 0);
    for (int k = -kReach; k <= kReach; k++)
      for (int j = -kReach; j <= kReach; j++)
        if (const int row = int(slot) / stride + k * rows + j; is_index(row, near.size()))
          near[std::size_t(row)] = 1;
  }
  return near;
}

/// Corners whose terms do not depend on cuts and removed nodes.
struct IntactCorners {
  const Model& model;
  const Cuts& cuts;
  std::vector<std::uint8_t> near_removed = rows_near_removed(model.anatomy.lattice, cuts);  // by row

  bool has(int corner) const {
    const Lattice& l = model.anatomy.lattice;
    return corner < slot_count(l) && is_far_from_cuts(l, cuts, corner) &&
           (near_removed.empty() || !near_removed[std::size_t(corner / row_stride(l))]);
  }
};

/// Appends the terms of a corner to a list: a copy if they are kept.
void add_kept_terms(const Model& model, const Cuts& cuts, const IntactCorners& intact, const KeptTerms* kept,
                    int corner, std::vector<CornerTerm>& terms) {
  const bool is_node = corner < slot_count(model.anatomy.lattice);
  const int n = kept && kept->plan && is_node ? kept->index[std::size_t(corner)] : -1;
  if (n < 0 || has_displacement(model, cuts, corner) || !intact.has(corner))
    return add_corner_terms(model, cuts, corner, terms);
  const auto all = kept->plan->terms.begin();
  terms.insert(terms.end(), all + kept->plan->term_begin[std::size_t(n)],
               all + kept->plan->term_begin[std::size_t(n) + 1]);
}

/// Keeps the terms of a plan.
void keep_terms(const Model& model, const Cuts& cuts, std::shared_ptr<const SurfacePlan> plan,
                KeptTerms& kept) {
  const Lattice& l = model.anatomy.lattice;
  const IntactCorners intact{model, cuts};
  kept.index.assign(std::size_t(slot_count(l)), -1);
  for (std::size_t c = 0; c < plan->corners.size(); c++)
    if (const int corner = plan->corners[c]; intact.has(corner)) kept.index[std::size_t(corner)] = int(c);
  kept.plan = std::move(plan);
}

/// Terms of all corners, task by task.
void find_terms(const Exec& exec, const Model& model, const Cuts& cuts, const KeptTerms* kept,
                SurfacePlan& plan) {
  const std::size_t count = plan.corners.size(), tasks = (count + kCornersPerTask - 1) / kCornersPerTask;
  std::vector<std::vector<CornerTerm>> terms(tasks);
  const IntactCorners intact{model, cuts};
  plan.term_begin.assign(count + 1, 0);
  parallel_for(exec, tasks, [&](std::size_t task) {
    for (std::size_t c = task * kCornersPerTask; c < std::min(count, (task + 1) * kCornersPerTask); c++) {
      const std::size_t before = terms[task].size();
      add_kept_terms(model, cuts, intact, kept, plan.corners[c], terms[task]);
      plan.term_begin[c + 1] = int(terms[task].size() - before);
    }
  });
  for (std::size_t c = 0; c < count; c++) plan.term_begin[c + 1] += plan.term_begin[c];
  for (const std::vector<CornerTerm>& some : terms)
    plan.terms.insert(plan.terms.end(), some.begin(), some.end());
}

void find_triangles_around(const BodySurface& surface, SurfacePlan& plan) {
  std::vector<int>& begin = plan.triangle_begin;
  begin.assign(surface.rest.size() + 1, 0);
  for (const Int3 t : surface.triangles)
    for (int corner = 0; corner < 3; corner++) begin[std::size_t(t[corner]) + 1]++;
  for (std::size_t v = 1; v < begin.size(); v++) begin[v] += begin[v - 1];
  std::vector<int> next(begin.begin(), begin.end() - 1);
  plan.triangles.resize(3 * surface.triangles.size());
  for (std::size_t t = 0; t < surface.triangles.size(); t++)
    for (int corner = 0; corner < 3; corner++)
      plan.triangles[std::size_t(next[std::size_t(surface.triangles[t][corner])]++)] = 3 * int(t) + corner;
  TURGOR_CHECK(is_csr(begin, plan.triangles.size()), "the vertices have all corners of triangles");
}

/// Areas of the CT. Caps, which are no skin, and triangles opened by a cut have none.
void find_rest_areas(const Model& model, const BodySurface& surface, SurfacePlan& plan) {
  const Vec3 h = model.anatomy.lattice.spacing;
  const Real step = std::min({h.x, h.y, h.z});
  plan.rest_around.assign(surface.rest.size(), 0);
  for (int n = 0; n < surface.skin_triangles; n++) {
    const Int3 t = surface.triangles[std::size_t(n)];
    const Vec3 a = surface.rest[std::size_t(t.x)];
    const float area = norm(cross(surface.rest[std::size_t(t.y)] - a, surface.rest[std::size_t(t.z)] - a));
    const bool is_cap = n >= surface.skin_triangles - surface.cap_triangles;
    const bool has_area = !is_cap && !(area < 1e-5f * step * step);
    plan.rest_area.push_back(has_area ? area : 0);
    for (int corner = 0; corner < 3 && has_area; corner++) plan.rest_around[std::size_t(t[corner])] += area;
  }
}

}  // namespace

std::shared_ptr<const SurfacePlan> make_surface_plan(const Exec& exec, const Model& model, const Cuts& cuts,
                                                     const BodySurface& surface, KeptTerms* kept) {
  TURGOR_CHECK(surface.embedding.size() == surface.rest.size(), "every vertex is embedded in a cell");
  auto plan = std::make_shared<SurfacePlan>();
  find_corners(exec, model, surface, *plan);
  number_corners(model, surface, *plan);
  find_terms(exec, model, cuts, kept, *plan);
  find_triangles_around(surface, *plan);
  find_rest_areas(model, surface, *plan);
  const Vec3 h = model.anatomy.lattice.spacing;
  const Real step = std::min({h.x, h.y, h.z});
  plan->fronts = find_front_sides(surface, step);
  plan->ends = find_cut_ends(surface, *plan, step);
  if (kept && !kept->plan) keep_terms(model, cuts, plan, *kept);
  return plan;
}

}  // namespace turgor::lattice::detail
