#include "turgor/models/lattice/build/skin.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/models/lattice/build/skin_lanes.hpp"
#include "turgor/models/lattice/build/skin_patches.hpp"
#include "turgor/models/lattice/build/skin_surface.hpp"
#include "turgor/models/lattice/mechanics/skin_forces.hpp"
#include "turgor/models/lattice/mechanics/skin_queries.hpp"
#include "turgor/models/lattice/model/colors.hpp"

namespace turgor::lattice {

namespace {

/// Corners of a tetrahedron's face, counter-clockwise as seen from the opposite corner.
constexpr std::array<std::array<int, 3>, 4> kFaceTowards = {{{1, 3, 2}, {0, 2, 3}, {0, 3, 1}, {0, 1, 2}}};

/// Skin of one layer of cells: each tetrahedron with exactly one corner outside contributes the opposite
/// triangle.
void detect_layer(const Model& model, int k, std::vector<Int3>& found) {
  TURGOR_CHECK(k >= 0 && k + 1 < model.anatomy.lattice.size.z,
               "a layer of cells lies between two layers of nodes");
  const Lattice& l = model.anatomy.lattice;
  for (int j = 0; j + 1 < l.size.y; j++)
    for (int i = 0; i + 1 < l.size.x; i++) {
      // corners outside
      int outside_count = 0;
      bool outside[8];
      for (int c = 0; c < 8; c++) {
        const int slot = node_slot(l, i + (c & 1), j + (c >> 1 & 1), k + (c >> 2));
        outside[c] = !is_body(model.anatomy.tissue[std::size_t(slot)]);
        outside_count += outside[c];
      }
      if (outside_count == 0 || outside_count > 5) continue;
      // tetrahedra with one corner outside
      for (const auto& tet : kKuhnTets) {
        int air = -1, count = 0;
        for (int c = 0; c < 4; c++) {
          const Int3 o = tet[std::size_t(c)];
          if (outside[o.x | o.y << 1 | o.z << 2]) air = c, count++;
        }
        if (count != 1) continue;
        Int3 triangle;
        for (int c = 0; c < 3; c++) {
          const Int3 o = tet[std::size_t(kFaceTowards[std::size_t(air)][std::size_t(c)])];
          triangle[c] = node_slot(l, i + o.x, j + o.y, k + o.z);
        }
        found.push_back(triangle);
      }
    }
}

/// Removes duplicates: triangles that two tetrahedra found from both sides of a sheet.
void drop_doubles(std::vector<std::vector<Int3>>& layers) {
  struct Key {
    int a, b, c, layer, index;
    bool operator<(const Key& o) const {
      return std::tie(a, b, c, layer, index) < std::tie(o.a, o.b, o.c, o.layer, o.index);
    }
  };
  // sort triangles by their nodes
  std::vector<Key> keys;
  for (std::size_t k = 0; k < layers.size(); k++)
    for (std::size_t t = 0; t < layers[k].size(); t++) {
      std::array<int, 3> v{layers[k][t].x, layers[k][t].y, layers[k][t].z};
      std::sort(v.begin(), v.end());
      keys.push_back({v[0], v[1], v[2], int(k), int(t)});
    }
  std::sort(keys.begin(), keys.end());
  // remove duplicates
  for (std::size_t n = 1; n < keys.size(); n++) {
    const Key &a = keys[n - 1], &b = keys[n];
    if (a.a == b.a && a.b == b.b && a.c == b.c) layers[std::size_t(b.layer)][std::size_t(b.index)].x = -1;
  }
  for (auto& layer : layers) std::erase_if(layer, [](Int3 t) { return t.x < 0; });
}

/// Orders the triangles of layer `k` in batches of up to kSkinLanes that share no node (grouping in the
/// paper). Each batch takes triangles near the front of the remaining ones, so that its nodes stay in the
/// cache. [STC 4.3]
std::vector<int> order_in_batches(const Lattice& l, int k, std::vector<Int3>& triangles) {
  constexpr std::size_t kLookAhead = 128;
  const int first = row_slot(l, -1, k);
  std::vector<int> taken(std::size_t(2 * layer_stride(l)),
                         0);  // by node of layers k and k + 1: the last batch that contains it
  std::vector<Int3> remaining = std::move(triangles), skipped;
  std::vector<int> sizes;
  triangles.clear();
  std::size_t at = 0;
  while (at < remaining.size() || !skipped.empty()) {
    const int batch = int(sizes.size()) + 1;
    int size = 0;
    const auto take = [&](Int3 t) {
      for (int c = 0; c < 3; c++)
        if (taken[std::size_t(t[c] - first)] == batch) return false;
      for (int c = 0; c < 3; c++) taken[std::size_t(t[c] - first)] = batch;
      triangles.push_back(t);
      size++;
      return true;
    };
    // skipped triangles first, then a limited look-ahead
    std::erase_if(skipped, [&](Int3 t) { return size < kSkinLanes && take(t); });
    for (; at < remaining.size() && size < kSkinLanes && skipped.size() < kLookAhead; at++)
      if (!take(remaining[at])) skipped.push_back(remaining[at]);
    sizes.push_back(size);
  }
  TURGOR_CHECK(std::all_of(sizes.begin(), sizes.end(), [](int s) { return s > 0 && s <= kSkinLanes; }),
               "a batch has 1 to kSkinLanes triangles");
  return sizes;
}

/// Triangles of all layers by layer and color of their cells: group 4 k + p of Skin.
std::vector<std::vector<Int3>> group_by_colors(const Lattice& l,
                                               const std::vector<std::vector<Int3>>& layers) {
  std::vector<std::vector<Int3>> groups(4 * layers.size());
  for (const auto& layer : layers)
    for (const Int3 t : layer) {
      const Int3 cell = cell_of(l, t);
      groups[std::size_t(4 * cell.z + (color_of(cell) & 3))].push_back(t);
    }
  return groups;
}

/// Orders triangles of one color in rounds: first one triangle per cell, then the second of each cell that
/// has one, and so on. Cells with most triangles come first. Cells of a color share no node, so a batch is up
/// to kSkinLanes triangles of one round.
std::vector<int> order_in_rounds(const Lattice& l, std::vector<Int3>& triangles) {
  // triangles by cell, most first
  std::map<int, std::vector<Int3>> by_cell;
  for (const Int3 t : triangles) by_cell[node_slot(l, cell_of(l, t))].push_back(t);
  std::vector<std::vector<Int3>> cells;
  for (auto& [slot, of_cell] : by_cell) cells.push_back(std::move(of_cell));
  std::stable_sort(cells.begin(), cells.end(),
                   [](const auto& a, const auto& b) { return a.size() > b.size(); });
  // rounds
  std::vector<int> sizes;
  triangles.clear();
  for (std::size_t round = 0; !cells.empty() && round < cells[0].size(); round++)
    for (std::size_t c = 0; c < cells.size() && cells[c].size() > round; c++) {
      if (c % kSkinLanes == 0) sizes.push_back(0);
      triangles.push_back(cells[c][round]);
      sizes.back()++;
    }
  TURGOR_CHECK(std::all_of(sizes.begin(), sizes.end(), [](int s) { return s > 0 && s <= kSkinLanes; }),
               "a batch has 1 to kSkinLanes triangles");
  return sizes;
}

/// Computes area, edges and the coefficients of F d (SkinTriangle) from rest positions.
void measure_triangle(const Vec3d (&x)[3], Vec3d line, SkinTriangle& triangle) {
  const Vec3d e1 = x[1] - x[0], e2 = x[2] - x[0], n = cross(e1, e2), normal = normalized(n);
  // axes in the triangle
  Vec3d along = line - normal * dot(normal, line);
  if (norm(along) < 1e-6 * norm(line) || norm(line) == 0)
    along = e1;  // lines normal to the skin: any direction
  along = normalized(along);
  const Vec3d across = cross(normal, along);
  // edges in these axes
  const double a = dot(e1, along), b = dot(e2, along), c = dot(e1, across), d = dot(e2, across),
               det = a * d - b * c;
  triangle.edge1 = Vec3(e1);
  triangle.edge2 = Vec3(e2);
  triangle.area = Real(0.5 * norm(n));
  TURGOR_CHECK(det != 0, "a skin triangle has an area in the CT");
  const double inverse[2][2] = {{d / det, -b / det},
                                {-c / det, a / det}};  // of (e1 e2) in the axes (along, across)
  // coefficients
  for (int q = 0; q < 2; q++) {
    triangle.along[q + 1] = Real(inverse[q][0]);
    triangle.across[q + 1] = Real(inverse[q][1]);
  }
  triangle.along[0] = -triangle.along[1] - triangle.along[2];
  triangle.across[0] = -triangle.across[1] - triangle.across[2];
}

struct MeasureTriangle {
  const Model& model;
  const SmoothedSkin& rest;
  const VectorVolume* lines;
  SkinTriangle* triangles;
  Vec3* given;  // by triangle: lines; null without

  void operator()(std::size_t t) const {
    SkinTriangle& triangle = triangles[t];
    const TissueParams& tissue = model.params.tissue;
    // means over the corners
    Vec3d x[3], center;
    double hu = 0;
    for (int c = 0; c < 3; c++) {
      x[c] = rest.of(
          number_in_body(model.anatomy.lattice, slot_node(model.anatomy.lattice, triangle.vertex[c])));
      center += x[c] / 3;
      hu += model.anatomy.hu[std::size_t(triangle.vertex[c])] / 3.0;
    }
    // direction of the lines
    const Vec3d patient = model.anatomy.grid.origin + model.anatomy.grid.axes * center;
    const Vec3d line = inverse(model.anatomy.grid.axes) *
                       (lines != nullptr ? lines_at(*lines, patient) : model.params.skin.direction);
    if (given != nullptr) given[t] = Vec3(line);
    // geometry and stiffness
    measure_triangle(x, line, triangle);
    triangle.stiffness =
        Real(std::clamp((hu - tissue.air_max) / (tissue.bone_min - tissue.air_max), 0.05, 1.0));
  }
};

/// Smoothed skin from the triangles of owned cells, which are in the order of layers.
SmoothedSkin smooth_skin(const Exec& exec, const Model& model, const JoinSkin& join_skin) {
  const Lattice& l = model.anatomy.lattice;
  std::vector<SkinNodes> all;
  for (const SkinTriangle& t : model.anatomy.skin.triangles) {
    const int layer = cell_of(l, t.vertex).z;
    if (layer < model.anatomy.owned.begin || layer >= model.anatomy.owned.end) continue;
    SkinNodes& nodes = all.emplace_back();
    for (int c = 0; c < 3; c++) nodes[std::size_t(c)] = number_in_body(l, slot_node(l, t.vertex[c]));
  }
  if (join_skin) join_skin(all);
  return {exec, l, all};
}

}  // namespace

void detect_skin(const Exec& exec, std::span<const CellSurface> surfaces, const VectorVolume* lines,
                 const JoinSkin& join_skin, Model& model) {
  Skin& skin = model.anatomy.skin;
  // triangles by layer
  std::vector<std::vector<Int3>> layers(std::size_t(model.anatomy.lattice.size.z - 1));
  parallel_for(exec, layers.size(), [&](std::size_t k) { detect_layer(model, int(k), layers[k]); });
  drop_doubles(layers);
  // batches
  const SolverParams& solver = model.params.solver;
  const bool in_rounds = solver.method == Method::kPbd && solver.ordering == Ordering::kColors;
  if (in_rounds) layers = group_by_colors(model.anatomy.lattice, layers);
  std::vector<std::vector<int>> sizes(layers.size());
  parallel_for(exec, layers.size(), [&](std::size_t k) {
    sizes[k] = in_rounds ? order_in_rounds(model.anatomy.lattice, layers[k])
                         : order_in_batches(model.anatomy.lattice, int(k), layers[k]);
  });
  // list of triangles and batches
  skin.batch_begin = {0};
  for (std::size_t k = 0; k < layers.size(); k++) {
    skin.layer_begin.push_back(int(skin.batch_begin.size()) - 1);
    for (const int size : sizes[k]) skin.batch_begin.push_back(skin.batch_begin.back() + size);
    for (const Int3 vertex : layers[k]) skin.triangles.push_back({.vertex = vertex});
  }
  skin.triangles.shrink_to_fit();
  skin.layer_begin.push_back(int(skin.batch_begin.size()) - 1);
  // geometry
  TURGOR_CHECK(is_csr(skin.batch_begin, skin.triangles.size()), "the batches cover all triangles");
  TURGOR_CHECK(is_csr(skin.layer_begin, skin.batch_begin.size() - 1), "the layers cover all batches");
  if (lines != nullptr) skin.lines.resize(skin.triangles.size());
  const SmoothedSkin rest = smooth_skin(exec, model, join_skin);
  parallel_for(
      exec, skin.triangles.size(),
      MeasureTriangle{model, rest, lines, skin.triangles.data(), lines ? skin.lines.data() : nullptr}, 1024);
  // lanes
  const bool pbd = model.params.solver.method == Method::kPbd;
  if (!pbd && model.params.skin.law == SkinLaw::kFiber) skin.patches = make_patches(surfaces, lines, model);
  lay_out_skin(model);
  if (pbd) return;
  model.prestress_force = measure_prestress(exec, model);
}

/// Computes the skin forces at rest. The CT shows a body at rest under skin tension, so the tissue's
/// prestress balances any skin force in it. Such forces come from curvature and from stairs of the lattice.
/// The prestress remains after the skin is cut.
std::vector<Vec3> measure_prestress(const Exec& exec, const Model& model) {
  const Skin& skin = model.anatomy.skin;
  const VbdTables& vbd = model.vbd;
  TURGOR_CHECK(!skin.row_begin.empty(), "prestress acts on a body with skin");
  const SkinForces forces(model);
  // undeformed body
  std::vector<Real> still(model.anatomy.inverse_mass.size(), 0);
  const NodeArrays nodes{still.data(), still.data(), still.data(), nullptr, nullptr, nullptr};
  // sum over the corners at each node
  std::vector<Vec3> force(skin.nodes.size());
  parallel_for(
      exec, skin.row_begin.size() - 1,
      [&](std::size_t row) {
        const int first = vbd.corner_begin[std::size_t(skin.row_begin[row])];
        CornerSystems systems;
        for (auto at = std::size_t(skin.row_begin[row]); at < std::size_t(skin.row_begin[row + 1]); at++)
          for (int c = vbd.corner_begin[at]; c < vbd.corner_begin[at + 1]; c++) {
            const int lane = (c - first) % kSkinLanes;
            const int lanes = vbd.lanes_begin[row] + (c - first) / kSkinLanes;
            if (lane == 0 && skin.patches.empty())
              forces.gather(vbd.corners[std::size_t(lanes)], nodes, systems);
            else if (lane == 0)
              forces.gather(vbd.patch_corners[std::size_t(lanes)], nodes, systems);
            force[at] += systems.get(lane).f;
          }
      },
      64);
  return force;
}

}  // namespace turgor::lattice
