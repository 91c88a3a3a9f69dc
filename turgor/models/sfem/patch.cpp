#include "turgor/models/sfem/patch.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numeric>
#include <string>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/core/sort_unique.hpp"
#include "turgor/models/sfem/elements.hpp"
#include "turgor/models/sfem/patch_assembly.hpp"
#include "turgor/models/sfem/patch_condense.hpp"
#include "turgor/models/sfem/patch_interior.hpp"

namespace turgor::sfem {

namespace {

/// The fine triangles that a touch can reach without leaving the patch's outer surface.
std::vector<Int3> touched_triangles(const FineMesh& fine, std::span<const Vec3d> touches) {
  if (touches.empty()) return fine.outer;
  std::vector<int> piece(fine.nodes.size());  // smallest node of the piece each belongs to
  std::iota(piece.begin(), piece.end(), 0);
  for (bool changed = true; changed;) {
    changed = false;
    for (const auto [a, b, c] : fine.outer) {
      const int least = std::min({piece[std::size_t(a)], piece[std::size_t(b)], piece[std::size_t(c)]});
      for (const int node : {a, b, c}) {
        changed = changed || piece[std::size_t(node)] != least;
        piece[std::size_t(node)] = least;
      }
    }
  }
  std::vector<int> wanted;
  for (const Vec3d touch : touches) {
    double nearest = std::numeric_limits<double>::max();
    int found = -1;
    for (const Int3 t : fine.outer)
      for (const int node : {t.x, t.y, t.z})
        if (const Vec3d d = fine.nodes[std::size_t(node)].x - touch; dot(d, d) < nearest)
          nearest = dot(d, d), found = node;
    if (found >= 0) wanted.push_back(piece[std::size_t(found)]);
  }
  std::vector<Int3> triangles;
  for (const Int3 t : fine.outer)
    if (std::find(wanted.begin(), wanted.end(), piece[std::size_t(t.x)]) != wanted.end())
      triangles.push_back(t);
  return triangles;
}

/// Nodes of the triangles, ascending.
std::vector<int> nodes_of(const std::vector<Int3>& triangles) {
  std::vector<int> nodes;
  for (const auto [a, b, c] : triangles) nodes.insert(nodes.end(), {a, b, c});
  sort_unique(nodes);
  return nodes;
}

PatchUnknowns number_unknowns(const Model& model, std::span<const int> elements, const FineMesh& fine,
                              const std::vector<int>& touched, bool with_change) {
  PatchUnknowns unknowns;
  const SolidMesh& mesh = model.body.mesh;
  const bool is_refined = fine.parent.size() > elements.size();
  if (is_refined) {
    const std::vector<int> coupled =
        with_change ? changed_elements(model, elements) : std::vector<int>(elements.begin(), elements.end());
    for (const int e : coupled)
      for (const int v : element(mesh, std::size_t(e)))
        if (model.free_node[std::size_t(v)] >= 0) unknowns.coarse.push_back(v);
  } else {  // the touched vertices suffice
    for (const int node : touched) {
      const FineNode& from = fine.nodes[std::size_t(node)];
      unknowns.coarse.insert(unknowns.coarse.end(), from.coarse.begin(), from.coarse.begin() + from.supports);
    }
  }
  sort_unique(unknowns.coarse);

  unknowns.local.assign(fine.nodes.size(), -1);
  const auto has_own = [&](int node) {
    const FineNode& n = fine.nodes[std::size_t(node)];
    return !n.at_vertex && !n.on_border && !n.fixed;
  };
  for (const bool surface : {false, true}) {
    if (surface) unknowns.first_touched = unknowns.local_count;
    for (int node = 0; node < int(fine.nodes.size()); node++)
      if (has_own(node) && std::binary_search(touched.begin(), touched.end(), node) == surface)
        unknowns.local[std::size_t(node)] = unknowns.local_count++;
  }
  TURGOR_CHECK(unknowns.first_touched >= 0 && unknowns.first_touched <= unknowns.local_count,
               "touched local functions are the last ones");
  return unknowns;
}

/// Points of the patch: touched fine nodes with their coarse supports.
void make_points(const FineMesh& fine, const PatchUnknowns& unknowns, const std::vector<int>& touched,
                 const std::vector<Int3>& triangles, Patch& patch) {
  std::vector<int> number(fine.nodes.size(), -1);
  for (const int node : touched) {
    number[std::size_t(node)] = int(patch.points.size());
    const FineNode& from = fine.nodes[std::size_t(node)];
    PatchPoint point{from.x, from.key};
    TURGOR_ASSERT(from.supports <= int(point.coarse.size()),
                  "a surface point depends on the corners of one face");
    point.supports = from.supports, point.local = unknowns.local[std::size_t(node)];
    for (std::size_t s = 0; s < std::size_t(from.supports); s++) {
      TURGOR_CHECK(std::binary_search(unknowns.coarse.begin(), unknowns.coarse.end(), from.coarse[s]),
                   "the supports of a point are unknowns");
      const auto at = std::lower_bound(unknowns.coarse.begin(), unknowns.coarse.end(), from.coarse[s]);
      point.coarse[s] = int(at - unknowns.coarse.begin()), point.weight[s] = from.weight[s];
    }
    patch.points.push_back(point);
  }
  for (const auto [a, b, c] : triangles)
    patch.triangles.push_back({number[std::size_t(a)], number[std::size_t(b)], number[std::size_t(c)]});
}

/// Elements around the free surface vertex nearest to a position.
void elements_at(const Model& model, Vec3d touch, std::vector<int>& found) {
  const SolidMesh& mesh = model.body.mesh;
  int nearest = -1;
  double least = std::numeric_limits<double>::max();
  for (std::size_t i = 0; i < model.green.surface_count; i++) {
    const Vec3d d = mesh.vertices[std::size_t(model.green.nodes[i])] - touch;
    if (dot(d, d) < least) least = dot(d, d), nearest = model.green.nodes[i];
  }
  for (std::size_t t = 0; t < model.surface.triangles.size(); t++) {
    const Int3 v = model.surface.triangles[t];
    if (v.x == nearest || v.y == nearest || v.z == nearest) found.push_back(model.surface.element[t]);
  }
}

/// Elements that may be in a patch: all vertices whose stiffness the patch changes have Green's functions.
std::vector<char> usable_elements(const Model& model) {
  const SolidMesh& mesh = model.body.mesh;
  const bool by_node = averages_nodes(mesh, model.params.formulation);
  std::vector<char> usable(element_count(mesh)), vertex_usable(mesh.vertices.size(), 1);
  for (std::size_t e = 0; e < usable.size(); e++) {
    // all corners are stored or fixed
    const auto corners = element(mesh, e);
    usable[e] = std::all_of(corners.begin(), corners.end(), [&](int v) {
      return model.free_node[std::size_t(v)] < 0 || model.green.slot[std::size_t(v)] >= 0;
    });
    // node-averaged: all elements around the corners as well
    if (by_node && !usable[e])
      for (const int v : corners) vertex_usable[std::size_t(v)] = 0;
  }
  for (std::size_t e = 0; by_node && e < usable.size(); e++)
    for (const int v : element(mesh, e)) usable[e] = usable[e] && vertex_usable[std::size_t(v)];
  return usable;
}

/// Nodes of the subdivision of one element.
double nodes_of_element(int corners, int refinement) {
  const double n = (corners == 10 ? 2 : 1) * refinement;
  return corners == 8 ? std::pow(n + 1, 3) : (n + 1) * (n + 2) * (n + 3) / 6;
}

PatchCost cost_of(const Model& model, const PatchUnknowns& unknowns, std::size_t elements, int refinement,
                  std::size_t points, Precision precision) {
  // dense system of the functions that are not eliminated before
  const bool reduces = has_free_interior(model, unknowns);
  const double local = 3.0 * (unknowns.local_count - (reduces ? unknowns.first_touched : 0)),
               coarse = 3.0 * double(unknowns.coarse.size()), n = 3.0 * double(points);
  const double number = precision == Precision::kSingle ? 4 : 8;
  const double system = 2 * local * local + 4 * local * coarse;  // K_L and S, K_LG, Ψ, Z
  const double green = 2 * coarse * coarse, surface = 4 * n * n;
  const double levels = 3 * n * n * 8;  // Ξ of the points, and of their clusters
  PatchCost cost{.local_nodes = std::size_t(unknowns.local_count),
                 .points = points,
                 .bytes = number * (system + green + surface) + 8 * 3 * coarse * coarse + levels,
                 .flops = local * local * local / 3 + 2 * local * coarse * (local + coarse) + 2 * n * n * n};
  if (!reduces) return cost;
  // elimination below the surface, before that: matrices of elements, fronts that grow to the whole surface
  const double of_element = 3 * nodes_of_element(model.body.mesh.corners, refinement);
  const double below = 3 * std::pow(unknowns.first_touched, 2.0 / 3), front = local + coarse + below;
  cost.bytes = std::max(cost.bytes, 8 * (double(elements) * of_element * of_element + 2 * front * front));
  cost.flops += double(elements) * std::pow(of_element, 3) / 3 + 2 * below * front * front;
  return cost;
}

Error too_large(const PatchCost& cost, std::size_t elements, int refinement, std::size_t most_bytes) {
  const auto text = [](double value) {
    char digits[32];
    std::snprintf(digits, sizeof digits, "%.3g", value);
    return std::string(digits);
  };
  return Error{"a patch of " + std::to_string(elements) + " elements, each edge in " +
               std::to_string(refinement) + " parts, has " + std::to_string(cost.local_nodes) +
               " nodes of its own and would take " + text(cost.bytes * 1e-9) + " GB and " +
               text(cost.flops * 1e-9) + " thousand million operations, allowed are " +
               text(double(most_bytes) * 1e-9) +
               " GB: a smaller patch.radius, a lower patch.refinement or more memory"};
}

}  // namespace

std::vector<int> patch_elements(const Model& model, std::span<const Vec3d> touches, double radius) {
  const SolidMesh& mesh = model.body.mesh;
  const std::size_t faces = element_faces(mesh).size();
  std::vector<int> found;
  const std::vector<char> usable = usable_elements(model);
  std::vector<char> seen(element_count(mesh), 0);
  for (const Vec3d touch : touches) elements_at(model, touch, found);
  sort_unique(found);
  for (const int e : found) seen[std::size_t(e)] = 1;
  const auto is_near = [&](int e) {
    const Vec3d x = centroid(mesh, std::size_t(e));
    return std::any_of(touches.begin(), touches.end(), [&](Vec3d touch) { return norm(x - touch) < radius; });
  };
  for (std::size_t i = 0; i < found.size(); i++)
    for (std::size_t f = 0; f < faces; f++) {
      const int across = model.neighbors[std::size_t(found[i]) * faces + f];
      if (across < 0 || seen[std::size_t(across)]) continue;
      seen[std::size_t(across)] = 1;
      if (is_near(across) && usable[std::size_t(across)]) found.push_back(across);
    }
  std::sort(found.begin(), found.end());
  return found;
}

PatchCost patch_cost(const Model& model, std::span<const int> elements, int refinement,
                     std::span<const Vec3d> touches) {
  TURGOR_CHECK(is_sorted_unique(elements), "the elements of a patch ascend");
  const FineMesh fine = refine(model, elements, refinement);
  const std::vector<int> touched = nodes_of(touched_triangles(fine, touches));
  const bool with_change = refinement > 1 && changes_stiffness(model, elements, fine);
  const PatchUnknowns unknowns = number_unknowns(model, elements, fine, touched, with_change);
  return cost_of(model, unknowns, elements.size(), refinement, touched.size(), model.params.precision);
}

Result<Patch> build_patch(const Model& model, std::span<const int> elements, int refinement,
                          std::span<const Vec3d> touches, std::size_t most_bytes) {
  TURGOR_CHECK(is_sorted_unique(elements), "the elements of a patch ascend");
  const FineMesh fine = refine(model, elements, refinement);
  const std::vector<Int3> triangles = touched_triangles(fine, touches);
  const std::vector<int> touched = nodes_of(triangles);
  const bool with_change = refinement > 1 && changes_stiffness(model, elements, fine);
  const PatchUnknowns unknowns = number_unknowns(model, elements, fine, touched, with_change);
  Patch patch;
  patch.elements.assign(elements.begin(), elements.end());
  patch.coarse = unknowns.coarse;
  patch.local_nodes = unknowns.local_count;
  make_points(fine, unknowns, touched, triangles, patch);
  // functions below the surface are eliminated before the points are numbered
  const int below = has_free_interior(model, unknowns) ? unknowns.first_touched : 0;
  for (PatchPoint& point : patch.points)
    if (point.local >= 0) point.local -= below;
  patch.surface_nodes = unknowns.local_count - below;
  bool done = false;
  for (const Precision precision : {Precision::kSingle, Precision::kDouble}) {
    if (done || precision < model.params.precision) continue;
    const PatchCost cost = cost_of(model, unknowns, elements.size(), refinement, touched.size(), precision);
    if (cost.bytes > double(most_bytes)) return too_large(cost, elements.size(), refinement, most_bytes);
    done = precision == Precision::kSingle
               ? condense<float>(model, elements, fine, unknowns, with_change, patch)
               : condense<double>(model, elements, fine, unknowns, with_change, patch);
  }
  if (!done)
    return Error{
        "the patch's stiffness is lost to rounding: expected Poisson's ratios farther below 0.5, or "
        "elements that are less flat"};
  add_levels(patch);
  return patch;
}

}  // namespace turgor::sfem
