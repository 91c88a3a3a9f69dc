#include "turgor/models/lattice/surface/surface.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/core/assert.hpp"
#include "turgor/models/lattice/surface/ct_level_set.hpp"
#include "turgor/models/lattice/surface/surface_assembly.hpp"
#include "turgor/models/lattice/surface/surface_cache.hpp"
#include "turgor/models/lattice/surface/surface_plan.hpp"
#include "turgor/models/lattice/surface/tet_points.hpp"

namespace turgor::lattice {

namespace {

using detail::kFirstCap;
using detail::kSkin;
using detail::kWall;
using detail::MeshInput;
using detail::Points;
using detail::SlabPoints;
using detail::SurfacePoint;

/// Cell that is being meshed.
struct CurrentCell {
  Int3 cell, first;  // cell and its first fine node
  int slot = 0;
  CellLevels level;
  const CutCell* cut = nullptr;  // null: not near a cut
  bool has_removed = false;
  std::vector<CutPoint> cut_points;
  bool has_several_blades = false;
};

/// Tetrahedron of the current cell.
struct Tet : FineTet {
  int kind = 0;                      // index into kKuhnTets
  std::array<int, 4> sub_node = {};  // sub-lattice indices of its nodes
  TetPattern pattern = {};
  bool any_cut = false, any_removed = false;
};

struct Builder : MeshInput {
  SlabPoints output = {};
  CurrentCell current = {};
  LevelsNear levels_near{level, fragments.fine};

  const FineLattice& fine() const { return fragments.fine; }
};

std::uint8_t border_of(const FineLattice& f, Int3 p) {
  int mask = 0;
  for (int axis = 0; axis < 3; axis++) {
    if (p[axis] == 0) mask |= 1 << (2 * axis);
    if (p[axis] == f.size[axis] - 1) mask |= 2 << (2 * axis);
  }
  return std::uint8_t(mask);
}

std::uint64_t key_of(const Tet& tet, TetPoint p) {
  const auto offset = [&](int corner) {
    const Int3 d = tet.nodes[std::size_t(corner)] - tet.nodes[std::size_t(p.i)];
    return std::uint64_t((d.x + 1) + 3 * (d.y + 1) + 9 * (d.z + 1));
  };
  const std::uint64_t own =
      is_middle(p) ? std::uint64_t(tet.kind) : 7;  // middle points are not shared between tetrahedra
  return ((tet.index[std::size_t(p.i)] * 27 + offset(p.j)) * 27 + offset(p.b)) * 8 + own;
}

/// Cell and fragment in which points near a corner are embedded.
EmbeddingCell embedding_of(const Builder& builder, const Tet& tet, std::size_t corner) {
  const CurrentCell& c = builder.current;
  if (c.cut == nullptr) return {c.slot, -1};
  const Fragments& fragments = builder.fragments;
  const int fragment = fragment_of(fragments.label.data(), *c.cut, tet.sub_node[corner]);
  if (fragment < c.cut->fragment_count) return {c.slot, fragment};
  const GhostFragment& ghost =
      fragments.ghosts[std::size_t(c.cut->first_ghost + fragment - c.cut->fragment_count)];
  return {fragments.cells[std::size_t(ghost.cell)].slot, ghost.fragment};
}

/// True if points near a corner left the body with a piece.
bool is_excised(const Builder& builder, const Tet& tet, std::size_t corner) {
  if (builder.current.cut == nullptr || builder.cuts.excised.empty()) return false;
  const EmbeddingCell at = embedding_of(builder, tet, corner);
  const CutCell* cell = find_cell(builder.fragments, at.cell);
  return at.fragment >= 0 && builder.fragments.all[std::size_t(cell->first_fragment + at.fragment)].excised;
}

int point_index(Builder& builder, const Tet& tet, TetPoint p) {
  // find or create the point
  const std::uint64_t key = key_of(tet, p);
  const int point = builder.output.index.find_or_add(key);
  if (std::size_t(point) == builder.output.keys.size()) {
    builder.output.keys.push_back(key);
    const auto i = std::size_t(p.i), b = std::size_t(p.b);
    SurfacePoint made;
    made.position = position_of(tet, p);
    made.embedding = embedding_of(builder, tet, i);
    made.border = border_of(builder.fine(), tet.nodes[i]) & border_of(builder.fine(), tet.nodes[b]);
    made.is_skin = is_skin_point(p);
    builder.output.points.all.push_back(made);
  }
  // a point near a cut is not merged
  builder.output.points.all[std::size_t(point)].is_near_cut |= builder.current.cut != nullptr;
  return point;
}

/// True if the diagonal between points 1 and 3 of a quadrangle is shorter than the other one. Next to cuts,
/// the positions are those of this tetrahedron, so that they do not depend on the cells meshed before.
bool is_second_diagonal_shorter(const Builder& builder, const Tet& tet, const TetPolygon& polygon,
                                const std::array<int, 16>& index) {
  const auto at = [&](std::size_t n) {
    return builder.current.cut ? position_of(tet, polygon.at(int(n)))
                               : builder.output.points.all[std::size_t(index[n])].position;
  };
  return norm(at(1) - at(3)) < norm(at(0) - at(2));
}

/// Adds a polygon as a triangle fan. A quadrangle is split along its shorter diagonal.
void add_polygon(Builder& builder, const Tet& tet, const TetPolygon& polygon, int group) {
  if (is_excised(builder, tet, std::size_t(polygon.at(0).i))) return;
  std::array<int, 16> p;
  for (int n = 0; n < polygon.count; n++) p[std::size_t(n)] = point_index(builder, tet, polygon.at(n));
  if (polygon.count == 4 && is_second_diagonal_shorter(builder, tet, polygon, p))
    std::rotate(p.begin(), p.begin() + 1, p.begin() + 4);
  auto& triangles = builder.output.points.triangles[std::size_t(group)];
  const int cell = detail::cell_index(builder.model.anatomy.lattice, builder.current.cell);
  for (int n = 2; n < polygon.count; n++)
    triangles.push_back({{p[0], p[std::size_t(n - 1)], p[std::size_t(n)]}, cell});
}

void add_polygons(Builder& builder, const Tet& tet, const TetPolygons& polygons, int group) {
  for (int n = 0; n < polygons.count; n++)
    add_polygon(builder, tet, polygons.polygons[std::size_t(n)], group);
}

/// Adds a lip where the outline of the skin crosses a cut: a pair of points, one on each side.
void add_lips(Builder& builder, const Tet& tet, const TetPolygon& outline) {
  for (int n = 0; n < outline.count; n++) {
    const TetPoint from = outline.at(n), to = outline.at(n + 1);
    if (from.i == to.i || !tet.pattern.cut[std::size_t(from.i)][std::size_t(to.i)]) continue;
    const int from_side = point_index(builder, tet, clip_point(from.i, to.i, from.b)),
              to_side = point_index(builder, tet, clip_point(to.i, from.i, from.b));
    const Clip clip = clip_between(tet, from.i, to.i, from.b);
    builder.output.points.lips.push_back({.left = clip.rightward ? from_side : to_side,
                                          .right = clip.rightward ? to_side : from_side,
                                          .incision = clip.edge->incision,
                                          .along = Real(clip.along)});
  }
}

void add_caps(Builder& builder, const Tet& tet) {
  for (int face = 0; face < 4; face++) {
    int mask = 63;
    for (const int corner : kTetFaces[std::size_t(face)])
      mask &= border_of(builder.fine(), tet.nodes[std::size_t(corner)]);
    for (int plane = 0; plane < 6; plane++)
      if (mask >> plane & 1) add_polygons(builder, tet, face_polygons(tet.pattern, face), kFirstCap + plane);
  }
}

/// True if the edge between two corners of a tetrahedron is cut.
bool is_cut(const Builder& builder, const Tet& tet, std::size_t a, std::size_t b) {
  const CutCell* cell = builder.current.cut;
  if (cell == nullptr || !cell->is_cut) return false;
  const int family = family_of(tet.nodes[b] - tet.nodes[a]);
  const std::size_t lower = family >= 0 ? a : b;
  const int bit = family >= 0 ? family : family_of(tet.nodes[a] - tet.nodes[b]);
  return builder.fragments.cut_bits[cell->first_sub_index + std::size_t(tet.sub_node[lower])] >> bit & 1;
}

/// True if the lattice node nearest to a fine node is removed.
bool is_removed(const Builder& builder, Int3 node) {
  const Vec3d at = lattice_index(builder.fine(), node);
  const Int3 nearest{int(std::lround(at.x)), int(std::lround(at.y)), int(std::lround(at.z))};
  return is_removed_tissue(builder.model, builder.cuts, node_slot(builder.fine().cells, nearest));
}

void add_tet(Builder& builder, Int3 local, int kind) {
  const FineLattice& f = builder.fine();
  const CurrentCell& c = builder.current;
  // levels of the corners
  Tet tet{{.fragments = builder.fragments,
           .cuts = builder.cuts,
           .levels = builder.levels_near,
           .cut_points = c.cut_points,
           .is_near_cut = c.cut != nullptr,
           .has_several_blades = c.has_several_blades},
          kind};
  int solids = 0, border = 0;
  for (std::size_t n = 0; n < 4; n++) {
    const Int3 at = local + kKuhnTets[std::size_t(kind)][n];
    tet.nodes[n] = c.first + at;
    tet.sub_node[n] = sub_index(f, at);
    tet.index[n] = fine_index(f, tet.nodes[n]);
    tet.level[n] = double(c.level.at[std::size_t(tet.sub_node[n])]);
    tet.pattern.solid[n] = tet.level[n] > 0;
    if (!tet.pattern.solid[n] && c.has_removed) tet.any_removed |= is_removed(builder, tet.nodes[n]);
    solids += tet.pattern.solid[n];
    border |= border_of(f, tet.nodes[n]);
  }
  if (solids == 0) return;
  // cut edges between solid corners
  for (std::size_t a = 0; a < 4; a++)
    for (std::size_t b = 0; b < a; b++) {
      const bool cut = tet.pattern.solid[a] && tet.pattern.solid[b] && is_cut(builder, tet, a, b);
      tet.pattern.cut[a][b] = tet.pattern.cut[b][a] = cut;
      tet.any_cut |= cut;
    }
  // skin and lips
  if (solids < 4) {
    TetPolygon outline;
    const TetPolygons skin = skin_polygons(tet.pattern, outline);
    add_polygons(builder, tet, skin, tet.any_removed ? kWall : kSkin);
    if (tet.any_cut) add_lips(builder, tet, outline);
  }
  // caps at the border of the scan, and walls of cuts
  if (border) add_caps(builder, tet);
  if (tet.any_cut) add_polygons(builder, tet, wall_polygons(tet.pattern), kWall);
}

/// Meshes the sub-cells of a cell that contain the surface.
void add_cell(Builder& builder, bool border) {
  const FineLattice& f = builder.fine();
  const CurrentCell& c = builder.current;
  const std::uint8_t* cut =
      c.cut && c.cut->is_cut ? &builder.fragments.cut_bits[c.cut->first_sub_index] : nullptr;
  // skip sub-cells of air, and of uncut tissue away from the border
  for (int z = 0; z < f.subdivisions.z; z++)
    for (int y = 0; y < f.subdivisions.y; y++)
      for (int x = 0; x < f.subdivisions.x; x++) {
        int solids = 0;
        bool any_cut = false;
        for (int n = 0; n < 8; n++) {
          const int sub_node = sub_index(f, {x + (n & 1), y + (n >> 1 & 1), z + (n >> 2)});
          solids += c.level.at[std::size_t(sub_node)] > 0;
          any_cut |= cut != nullptr && cut[sub_node] != 0;
        }
        if (solids == 0 || (solids == 8 && !border && !any_cut)) continue;
        for (int t = 0; t < 6; t++) add_tet(builder, {x, y, z}, t);
      }
}

/// Meshes a cell unless it is all air or all uncut tissue.
void mesh_cell(Builder& builder, Int3 cell) {
  const Lattice& l = builder.fine().cells;
  // corners
  CurrentCell& c = builder.current;
  c.cell = cell, c.slot = node_slot(l, cell), c.first = first_of_cell(builder.fine(), cell);
  int solids = 0;
  c.has_removed = false;
  c.cut = find_cell(builder.fragments, c.slot);
  for (int n = 0; n < 8; n++) {
    const int slot = c.slot + slot_offset(l, cell_corner(n), cell.x & 1);
    solids += (c.cut ? was_solid : is_solid)(builder.model, builder.cuts, slot);
    c.has_removed |= is_removed_tissue(builder.model, builder.cuts, slot);
  }
  const bool border = cell.x == 0 || cell.y == 0 || cell.z == 0 || cell.x + 2 == l.size.x ||
                      cell.y + 2 == l.size.y || cell.z + 2 == l.size.z;
  // its level set
  if (solids == 0 || (solids == 8 && !border && !(c.cut && c.cut->is_cut))) return;
  c.level = builder.level(c.slot);
  c.cut_points.clear();
  if (c.cut)
    c.cut_points = cut_points_near(builder.fragments, builder.cuts, cell),
    builder.levels_near.begin_cell(cell);
  c.has_several_blades = std::any_of(c.cut_points.begin(), c.cut_points.end(), [&](const CutPoint& p) {
    return p.incision != c.cut_points.front().incision;
  });
  add_cell(builder, border);
}

/// Layers of cells per task. A thin slab keeps the index of points in the cache.
constexpr int kSlab = 4;

void mesh_slab(Builder& builder, int slab) {
  const Int3 size = builder.model.anatomy.lattice.size;
  for (int k = slab * kSlab; k < std::min((slab + 1) * kSlab, size.z - 1); k++)
    for (int j = 0; j + 1 < size.y; j++)
      for (int i = 0; i + 1 < size.x; i++) mesh_cell(builder, {i, j, k});
}

}  // namespace

detail::Points detail::mesh_body(const Exec& exec, const MeshInput& input) {
  std::vector<SlabPoints> slabs(std::size_t((input.model.anatomy.lattice.size.z - 1 + kSlab - 1) / kSlab));
  parallel_for(exec, slabs.size(), [&](std::size_t s) {
    Builder builder{input};
    mesh_slab(builder, int(s));
    slabs[s] = std::move(builder.output);
  });
  return concatenate_slabs(slabs);
}

detail::SlabPoints detail::mesh_cell(const MeshInput& input, Int3 cell) {
  Builder builder{input};
  lattice::mesh_cell(builder, cell);
  return std::move(builder.output);
}

BodySurface build_surface(const Model& model, const Cuts& cuts, const CtVolume* ct, Extent extent,
                          const Exec& exec, detail::SurfaceCache* cache) {
  TURGOR_CHECK(cache == nullptr || extent == Extent::kAll, "only whole surfaces are cached");
  const std::shared_ptr<const Fragments> fragments = fragments_of(model, cuts);
  const CtLevelSet level(model, cuts, fragments->fine, ct);
  const MeshInput input{model, cuts, level, *fragments};
  BodySurface surface;
  if (cache) {
    surface = detail::update_surface(exec, input, *cache);
  } else if (extent == Extent::kAll) {
    surface = detail::assemble_surface(input, detail::mesh_body(exec, input));
  } else {
    Builder builder{input};
    for (const CutCell& cell : fragments->cells)
      mesh_cell(builder, slot_node(model.anatomy.lattice, cell.slot));
    surface = detail::assemble_surface(input, builder.output.points);
  }
  surface.fragments = fragments;
  if (extent == Extent::kAll)
    surface.plan = detail::make_surface_plan(exec, model, cuts, surface, cache ? &cache->terms : nullptr);
  return surface;
}

std::vector<Vec3d> rest_points(const Model& model, const BodySurface& surface) {
  std::vector<Vec3d> points;
  points.reserve(surface.rest.size());
  for (const Vec3 x : surface.rest)
    points.push_back(model.anatomy.grid.origin + model.anatomy.grid.axes * Vec3d(x));
  return points;
}

}  // namespace turgor::lattice
