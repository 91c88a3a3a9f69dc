#include "turgor/models/lattice/surface/surface.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/models/lattice/surface/ct_level_set.hpp"
#include "turgor/models/lattice/surface/surface_assembly.hpp"
#include "turgor/models/lattice/surface/tet_points.hpp"

namespace turgor::lattice {

namespace {

using detail::kFirstCap;
using detail::KnownPoints;
using detail::KnownSlabs;
using detail::kSkin;
using detail::kWall;
using detail::Points;
using detail::SurfacePoint;

/// One cell in hand.
struct CellInHand {
  Int3 cell, first;  // its first fine node
  int slot = 0;
  CellLevels level;
  const CutCell* cut = nullptr;  // near a cut
  bool has_removed = false;
};

/// One tetrahedron of the cell in hand.
struct Tet : FineTet {
  int kind = 0;                   // index into kKuhnTets
  std::array<int, 4> place = {};  // of its nodes in the cell
  TetPattern pattern = {};
  bool any_cut = false, any_removed = false;
};

struct Builder {
  const Model& model;
  const State& state;
  const CtLevelSet& level;
  const Fragments& pieces;
  KnownPoints known;
  CellInHand in_hand;

  const FineLattice& fine() const { return pieces.fine; }
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
  const std::uint64_t own = is_middle(p) ? std::uint64_t(tet.kind) : 7;  // middles belong to one tetrahedron
  return ((tet.index[std::size_t(p.i)] * 27 + offset(p.j)) * 27 + offset(p.b)) * 8 + own;
}

/// What carries points beside a corner of a tetrahedron.
Carrier carrier_of(const Builder& builder, const Tet& tet, std::size_t corner) {
  const CellInHand& c = builder.in_hand;
  if (c.cut == nullptr) return {c.slot, -1};
  const Fragments& pieces = builder.pieces;
  const int piece = piece_of(pieces.label.data(), *c.cut, tet.place[corner]);
  if (piece < c.cut->fragment_count) return {c.slot, piece};
  const GhostFragment& ghost = pieces.ghosts[std::size_t(c.cut->first_ghost + piece - c.cut->fragment_count)];
  return {pieces.cells[std::size_t(ghost.cell)].slot, ghost.piece};
}

int point_index(Builder& builder, const Tet& tet, TetPoint p) {
  const std::uint64_t key = key_of(tet, p);
  const int point = builder.known.index.find_or_add(key);
  if (std::size_t(point) == builder.known.keys.size()) {
    builder.known.keys.push_back(key);
    const auto i = std::size_t(p.i), b = std::size_t(p.b);
    SurfacePoint made;
    made.place = place_of(tet, p);
    made.carrier = carrier_of(builder, tet, i);
    made.border = border_of(builder.fine(), tet.nodes[i]) & border_of(builder.fine(), tet.nodes[b]);
    made.is_skin = is_skin_point(p);
    builder.known.points.all.push_back(made);
  }
  builder.known.points.all[std::size_t(point)].kept |= builder.in_hand.cut != nullptr;
  return point;
}

/// A fan; a quadrangle is cut along its shorter diagonal.
void add_polygon(Builder& builder, const Tet& tet, const TetPolygon& polygon, int part) {
  std::array<int, 16> p;
  for (int n = 0; n < polygon.count; n++) p[std::size_t(n)] = point_index(builder, tet, polygon.at(n));
  const auto distance = [&](std::size_t a, std::size_t b) {
    return norm(builder.known.points.all[std::size_t(p[a])].place -
                builder.known.points.all[std::size_t(p[b])].place);
  };
  if (polygon.count == 4 && distance(1, 3) < distance(0, 2))
    std::rotate(p.begin(), p.begin() + 1, p.begin() + 4);
  auto& triangles = builder.known.points.triangles[std::size_t(part)];
  for (int n = 2; n < polygon.count; n++)
    triangles.push_back({p[0], p[std::size_t(n - 1)], p[std::size_t(n)]});
}

void add_polygons(Builder& builder, const Tet& tet, const TetPolygons& polygons, int part) {
  for (int n = 0; n < polygons.count; n++) add_polygon(builder, tet, polygons.polygons[std::size_t(n)], part);
}

/// Where the skin's outline goes through a cut: two points of two lips.
void add_lips(Builder& builder, const Tet& tet, const TetPolygon& outline) {
  for (int n = 0; n < outline.count; n++) {
    const TetPoint from = outline.at(n), to = outline.at(n + 1);
    if (from.i == to.i || !tet.pattern.cut[std::size_t(from.i)][std::size_t(to.i)]) continue;
    const int here = point_index(builder, tet, clip_point(from.i, to.i, from.b)),
              there = point_index(builder, tet, clip_point(to.i, from.i, from.b));
    const Clip clip = clip_between(tet, from.i, to.i, from.b);
    builder.known.points.lips.push_back({.left = clip.rightward ? here : there,
                                         .right = clip.rightward ? there : here,
                                         .incision = clip.incision,
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

/// Is the edge between two corners of a tetrahedron cut?
bool is_cut(const Builder& builder, const Tet& tet, std::size_t a, std::size_t b) {
  const CutCell* cell = builder.in_hand.cut;
  if (cell == nullptr || !cell->is_cut) return false;
  const int family = family_of(tet.nodes[b] - tet.nodes[a]);
  const std::size_t lower = family >= 0 ? a : b;
  const int bit = family >= 0 ? family : family_of(tet.nodes[a] - tet.nodes[b]);
  return builder.pieces.cut[cell->places + std::size_t(tet.place[lower])] >> bit & 1;
}

/// Is the lattice's node nearest to a fine node a removed one?
bool is_removed(const Builder& builder, Int3 node) {
  const Vec3d at = lattice_index(builder.fine(), node);
  const Int3 nearest{int(std::lround(at.x)), int(std::lround(at.y)), int(std::lround(at.z))};
  return builder.state.removed[std::size_t(node_slot(builder.fine().cells, nearest))] != 0;
}

void add_tet(Builder& builder, Int3 local, int kind) {
  const FineLattice& f = builder.fine();
  const CellInHand& c = builder.in_hand;
  Tet tet{{.pieces = builder.pieces, .state = builder.state, .is_near_cut = c.cut != nullptr}, kind};
  int solids = 0, border = 0;
  for (std::size_t n = 0; n < 4; n++) {
    const Int3 at = local + kKuhnTets[std::size_t(kind)][n];
    tet.nodes[n] = c.first + at;
    tet.place[n] = place_in_cell(f, at);
    tet.index[n] = fine_index(f, tet.nodes[n]);
    tet.level[n] = double(c.level.at[std::size_t(tet.place[n])]);
    tet.pattern.solid[n] = tet.level[n] > 0;
    if (!tet.pattern.solid[n] && c.has_removed) tet.any_removed |= is_removed(builder, tet.nodes[n]);
    solids += tet.pattern.solid[n];
    border |= border_of(f, tet.nodes[n]);
  }
  if (solids == 0) return;
  for (std::size_t a = 0; a < 4; a++)
    for (std::size_t b = 0; b < a; b++) {
      const bool cut = tet.pattern.solid[a] && tet.pattern.solid[b] && is_cut(builder, tet, a, b);
      tet.pattern.cut[a][b] = tet.pattern.cut[b][a] = cut;
      tet.any_cut |= cut;
    }
  if (solids < 4) {
    TetPolygon outline;
    const TetPolygons skin = skin_polygons(tet.pattern, outline);
    add_polygons(builder, tet, skin, tet.any_removed ? kWall : kSkin);
    if (tet.any_cut) add_lips(builder, tet, outline);
  }
  if (border) add_caps(builder, tet);
  if (tet.any_cut) add_polygons(builder, tet, wall_polygons(tet.pattern), kWall);
}

/// Parts of a cell that are not all air and not all whole tissue.
void add_cell(Builder& builder, bool border) {
  const FineLattice& f = builder.fine();
  const CellInHand& c = builder.in_hand;
  const std::uint8_t* cut = c.cut && c.cut->is_cut ? &builder.pieces.cut[c.cut->places] : nullptr;
  for (int z = 0; z < f.parts.z; z++)
    for (int y = 0; y < f.parts.y; y++)
      for (int x = 0; x < f.parts.x; x++) {
        int solids = 0;
        bool any_cut = false;
        for (int n = 0; n < 8; n++) {
          const int place = place_in_cell(f, {x + (n & 1), y + (n >> 1 & 1), z + (n >> 2)});
          solids += c.level.at[std::size_t(place)] > 0;
          any_cut |= cut != nullptr && cut[place] != 0;
        }
        if (solids == 0 || (solids == 8 && !border && !any_cut)) continue;
        for (int t = 0; t < 6; t++) add_tet(builder, {x, y, z}, t);
      }
}

/// A cell, unless it is all air or all whole tissue.
void look_at_cell(Builder& builder, Int3 cell) {
  const Lattice& l = builder.fine().cells;
  CellInHand& c = builder.in_hand;
  c.cell = cell, c.slot = node_slot(l, cell), c.first = first_of_cell(builder.fine(), cell);
  int solids = 0;
  c.has_removed = false;
  for (int n = 0; n < 8; n++) {
    const int slot = c.slot + slot_offset(l, cell_corner(n), cell.x & 1);
    solids += is_solid(builder.model, builder.state, slot);
    c.has_removed |= builder.state.removed[std::size_t(slot)] != 0;
  }
  const bool border = cell.x == 0 || cell.y == 0 || cell.z == 0 || cell.x + 2 == l.size.x ||
                      cell.y + 2 == l.size.y || cell.z + 2 == l.size.z;
  c.cut = find_cell(builder.pieces, c.slot);
  if (solids == 0 || (solids == 8 && !border && !(c.cut && c.cut->is_cut))) return;
  c.level = builder.level(c.slot);
  add_cell(builder, border);
}

/// Layers of cells that one thread looks at: thin, so that what it must find again stays near.
constexpr int kSlab = 4;

void look_at_slab(Builder& builder, int slab) {
  const Int3 size = builder.model.lattice.size;
  for (int k = slab * kSlab; k < std::min((slab + 1) * kSlab, size.z - 1); k++)
    for (int j = 0; j + 1 < size.y; j++)
      for (int i = 0; i + 1 < size.x; i++) look_at_cell(builder, {i, j, k});
}

/// Is nothing cut or removed in a slab?
std::vector<std::uint8_t> whole_slabs(const Builder& builder, std::size_t count) {
  const Lattice& l = builder.model.lattice;
  std::vector<std::uint8_t> whole(count, 1);
  for (const CutCell& cell : builder.pieces.cells) whole[std::size_t(slot_node(l, cell.slot).z / kSlab)] = 0;
  for (std::size_t s = 0; s < count; s++) {
    const int top = std::min(int(s + 1) * kSlab, l.size.z - 1);  // the last layer of its nodes
    const auto removed = builder.state.removed.begin();
    const auto begin = removed + node_slot(l, 0, 0, int(s) * kSlab),
               end = removed + node_slot(l, 0, 0, top + 1);
    if (std::any_of(begin, end, [](auto is) { return is != 0; })) whole[s] = 0;
  }
  return whole;
}

/// The same numbers in the same order for any number of threads, and with whatever is known.
Points look_at_all(const Exec& exec, const Builder& nothing, KnownSlabs& known) {
  const auto count = std::size_t((nothing.model.lattice.size.z - 1 + kSlab - 1) / kSlab);
  known.slabs.resize(count), known.is_whole.resize(count);
  const std::vector<std::uint8_t> is_whole = whole_slabs(nothing, count);
  parallel_for(exec, count, [&](std::size_t s) {
    if (is_whole[s] && known.is_whole[s]) return;
    Builder builder = nothing;
    look_at_slab(builder, int(s));
    known.slabs[s] = std::move(builder.known);
  });
  known.is_whole = is_whole;
  return detail::joined(known.slabs);
}

}  // namespace

BodySurface build_surface(const Model& model, const State& state, const CtVolume* ct, Extent extent,
                          const Exec& exec, KnownSlabs* known) {
  BodySurface surface;
  surface.pieces = make_fragments(model, state);
  const CtLevelSet level(model, state, surface.pieces.fine, ct);
  Builder builder{
      .model = model, .state = state, .level = level, .pieces = surface.pieces, .known = {}, .in_hand = {}};
  if (extent == Extent::kAll) {
    KnownSlabs nothing;
    builder.known.points = look_at_all(exec, builder, known ? *known : nothing);
  } else {
    for (const CutCell& cell : surface.pieces.cells)
      look_at_cell(builder, slot_node(model.lattice, cell.slot));
  }
  detail::take_points(model, state, builder.known.points, surface);
  return surface;
}

std::vector<Vec3d> rest_points(const Model& model, const BodySurface& surface) {
  std::vector<Vec3d> points;
  points.reserve(surface.rest.size());
  for (const Vec3 x : surface.rest) points.push_back(model.grid.origin + model.grid.axes * Vec3d(x));
  return points;
}

}  // namespace turgor::lattice
