#include "turgor/models/lattice/surface.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "turgor/models/lattice/skin_level.hpp"
#include "turgor/models/lattice/surface_parts.hpp"
#include "turgor/models/lattice/tet_surface.hpp"
#include "turgor/models/lattice/tip_cells.hpp"

namespace turgor::lattice {

namespace {

using detail::kFirstCap;
using detail::KnownPoints;
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

/// One tetrahedron of the fine lattice: its corners, and what the polygons' points are in the whole surface.
struct Tet {
  int kind = 0;  // index into kKuhnTets
  std::array<Int3, 4> nodes;
  std::array<int, 4> place;  // in the cell
  std::array<std::uint64_t, 4> index;
  TetPattern pattern;
  bool any_cut = false, any_removed = false;
};

struct Builder {
  const Model& model;
  const State& state;
  const SkinLevel& level;
  const Pieces& pieces;
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

Vec3d place_of(const Builder& builder, const Tet& tet, int corner) {
  return lattice_index(builder.fine(), tet.nodes[std::size_t(corner)]);
}

/// How far from the solid corner towards the other one the skin is.
double skin_fraction(const Builder& builder, const Tet& tet, int solid, int other) {
  const double a = double(builder.in_hand.level.at[std::size_t(tet.place[std::size_t(solid)])]);
  const double b = double(builder.in_hand.level.at[std::size_t(tet.place[std::size_t(other)])]);
  return std::clamp(a / (a - b), 0.02, 0.98);
}

Crossing crossing_of(const Builder& builder, const Tet& tet, int a, int b) {
  Crossing found =
      crossing(builder.pieces, builder.state, tet.nodes[std::size_t(a)], tet.nodes[std::size_t(b)]);
  found.fraction = std::clamp(found.fraction, Real(0.01), Real(0.99));
  return found;
}

/// Where the blade crosses the edges around some fine nodes.
std::vector<Vec3d> crossings_around(const Builder& builder, Int3 low, Int3 high) {
  const FineLattice& f = builder.fine();
  std::vector<Vec3d> places;
  for (int k = low.z; k <= high.z; k++)
    for (int j = low.y; j <= high.y; j++)
      for (int i = low.x; i <= high.x; i++)
        for (const Int3 way : kFamilies) {
          const Int3 a{i, j, k}, b = a + way;
          if (!contains(f, a) || !contains(f, b)) continue;
          if (const Crossing c = crossing(builder.pieces, builder.state, a, b); c.edge)
            places.push_back(lattice_index(f, a) +
                             (lattice_index(f, b) - lattice_index(f, a)) * double(c.fraction));
        }
  return places;
}

/// The blade inside a tetrahedron: a plane through where it crosses the edges; nothing where it ends. Where
/// it comes by a corner so closely that all crossings are there, its direction is that of the edges around.
struct BladePlane {
  Vec3d point, normal;  // [steps of the lattice]
};
std::optional<BladePlane> blade_in(const Builder& builder, const Tet& tet) {
  constexpr double kSmall = 0.05;  // area that tells no direction [squares of fine edges]
  std::array<Vec3d, 6> at;
  std::size_t count = 0;
  for (int a = 0; a < 4; a++)
    for (int b = a + 1; b < 4; b++)
      if (const Crossing c = crossing_of(builder, tet, a, b); c.edge) {
        const Vec3d from = place_of(builder, tet, a);
        at[count++] = from + (place_of(builder, tet, b) - from) * double(c.fraction);
      }
  if (count < 3) return {};
  const Vec3d normal = cross(at[1] - at[0], at[2] - at[0]), parts(builder.fine().parts);
  if (norm(cross(hadamard(at[1] - at[0], parts), hadamard(at[2] - at[0], parts))) > kSmall)
    return BladePlane{at[0], normal};
  Int3 low = tet.nodes[0], high = tet.nodes[0];
  for (const Int3 node : tet.nodes) low = min(low, node), high = max(high, node);
  return BladePlane{at[0], flattest_way(crossings_around(builder, low, high))};
}

/// Across the skin: how the level changes inside a tetrahedron.
Vec3d level_gradient(const Builder& builder, const Tet& tet) {
  const Vec3d x0 = place_of(builder, tet, 0);
  const auto level = [&](int n) {
    return double(builder.in_hand.level.at[std::size_t(tet.place[std::size_t(n)])]);
  };
  const Vec3d a = place_of(builder, tet, 1) - x0, b = place_of(builder, tet, 2) - x0,
              c = place_of(builder, tet, 3) - x0;
  return cross(b, c) * (level(1) - level(0)) + cross(c, a) * (level(2) - level(0)) +
         cross(a, b) * (level(3) - level(0));
}

/// Where the skin is on the edge from a solid corner to another one. Where the blade crosses that edge below
/// the skin, the place would lie on its other side: it moves back along the skin, onto the blade.
Vec3d skin_place(const Builder& builder, const Tet& tet, int solid, int other) {
  const Vec3d a = place_of(builder, tet, solid), b = place_of(builder, tet, other);
  const double fraction = skin_fraction(builder, tet, solid, other);
  const Vec3d place = a + (b - a) * fraction;
  if (builder.in_hand.cut == nullptr) return place;
  const Crossing c = crossing_of(builder, tet, solid, other);
  if (c.edge == nullptr || double(c.fraction) >= fraction) return place;
  const Vec3d on_blade = a + (b - a) * double(c.fraction);
  const std::optional<BladePlane> blade = blade_in(builder, tet);
  if (!blade) return on_blade;
  const Vec3d across = level_gradient(builder, tet);
  const Vec3d along = blade->normal - across * (dot(across, blade->normal) / dot(across, across));
  const double reach = dot(along, blade->normal), beyond = dot(place - blade->point, blade->normal);
  if (!(reach > 0.05 * dot(blade->normal, blade->normal))) return on_blade;  // the blade lies in the skin
  const Vec3d back = along * (beyond / reach);
  const bool is_near = dot(back, back) < dot(b - a, b - a);  // a curved blade is a plane for no longer way
  return is_near ? place - back : on_blade;
}

/// Which part of the way from a to c is nearest to where the blade crosses the edge ij.
double nearest_part(const Builder& builder, Vec3d a, Vec3d c, Vec3d i, Vec3d j, double fraction) {
  const Vec3d step(builder.fine().cells.step);
  const Vec3d way = hadamard(c - a, step), from = hadamard(i + (j - i) * fraction - a, step);
  return dot(way, way) > 0 ? dot(from, way) / dot(way, way) : fraction;
}

/// Where the blade crosses the skin between those of the edges ib and jb, i and j on its two sides: on the
/// line through where it crosses ij and the one of ib and jb that it must cross as well.
struct Clip {
  Vec3d place;       // [steps of the lattice]
  double along = 0;  // on the blade's path [m]
  std::uint8_t incision = 0;
  bool rightward = false;  // from i to j
};
Clip clip_between(const Builder& builder, const Tet& tet, int i, int j, int b) {
  const bool swapped = tet.index[std::size_t(i)] > tet.index[std::size_t(j)];  // the same for both sides
  if (swapped) std::swap(i, j);
  const Crossing across = crossing_of(builder, tet, i, j);
  const double t = double(across.fraction), from = skin_fraction(builder, tet, i, b),
               to = skin_fraction(builder, tet, j, b);
  const Crossing at_i = crossing_of(builder, tet, i, b), at_j = crossing_of(builder, tet, j, b);
  // In the triangle, x along ij and y along ib: the skin from (0, from) to (1 − to, to), the blade from (t,
  // 0) to (0, s) or (1 − s, s).
  double part = t, up = 0;
  bool known = false;
  Clip clip{.place = {},
            .along = double(across.edge->along),
            .incision = across.edge->incision,
            .rightward = across.rightward != swapped};
  const bool below_i = at_i.edge && double(at_i.fraction) < from,
             below_j = at_j.edge && double(at_j.fraction) < to;
  if (below_i || below_j) {
    part = below_i ? 0 : 1, up = 1, known = true;
    clip.along = double((below_i ? at_i : at_j).edge->along);
  } else if ((at_i.edge != nullptr) != (at_j.edge != nullptr)) {
    const double s = double(at_i.edge ? at_i.fraction : at_j.fraction);
    const double bx = (at_i.edge ? 0 : 1 - s) - t, by = s, sx = 1 - to, sy = to - from;
    const double det = bx * sy - by * sx;
    if (std::abs(det) > 1e-9) {
      part = (bx * (0 - from) - by * (t - 0)) / det, known = true;
      up = std::clamp((from + sy * part) / by, 0.0, 1.0);
    }
    clip.along += up * (double((at_i.edge ? at_i : at_j).edge->along) - clip.along);
  }
  const Vec3d a = skin_place(builder, tet, i, b), c = skin_place(builder, tet, j, b);
  if (!known) part = nearest_part(builder, a, c, place_of(builder, tet, i), place_of(builder, tet, j), t);
  clip.place = a + (c - a) * std::clamp(part, 0.0, 1.0);
  return clip;
}

Vec3d place_of(const Builder& builder, const Tet& tet, TetPoint p) {
  const Vec3d from = place_of(builder, tet, p.i);
  if (is_corner(p)) return from;
  if (is_skin_point(p)) return skin_place(builder, tet, p.i, p.b);
  if (is_crossing(p)) {
    const double t = double(crossing_of(builder, tet, p.i, p.j).fraction);
    return from + (place_of(builder, tet, p.j) - from) * t;
  }
  if (is_clip(p)) return clip_between(builder, tet, p.i, p.j, p.b).place;
  Vec3d sum;
  for (int corner = 0; corner < 4; corner++)
    if (corner != p.b) sum += skin_place(builder, tet, corner, p.b) / 3;
  return sum;
}

int point_index(Builder& builder, const Tet& tet, TetPoint p) {
  const std::uint64_t key = key_of(tet, p);
  const int point = builder.known.index.find_or_add(key);
  if (std::size_t(point) == builder.known.keys.size()) {
    builder.known.keys.push_back(key);
    const CellInHand& c = builder.in_hand;
    const auto i = std::size_t(p.i), b = std::size_t(p.b);
    SurfacePoint made;
    made.place = place_of(builder, tet, p);
    made.carrier = {c.slot, c.cut ? builder.pieces.label[c.cut->places + std::size_t(tet.place[i])] : -1};
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
    const Clip clip = clip_between(builder, tet, from.i, to.i, from.b);
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
  Tet tet;
  tet.kind = kind;
  int solids = 0, border = 0;
  for (std::size_t n = 0; n < 4; n++) {
    const Int3 at = local + kKuhnTets[std::size_t(kind)][n];
    tet.nodes[n] = c.first + at;
    tet.place[n] = place_in_cell(f, at);
    tet.index[n] = fine_index(f, tet.nodes[n]);
    tet.pattern.solid[n] = c.level.at[std::size_t(tet.place[n])] > 0;
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
    const int slot = c.slot + slot_offset(l, {n & 1, n >> 1 & 1, n >> 2}, cell.x & 1);
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

/// The same numbers in the same order for any number of threads.
Points look_at_all(const Exec& exec, const Builder& nothing) {
  const int layers = nothing.model.lattice.size.z - 1;
  std::vector<KnownPoints> slabs(std::size_t((layers + kSlab - 1) / kSlab));
  parallel_for(exec, slabs.size(), [&](std::size_t s) {
    Builder builder = nothing;
    look_at_slab(builder, int(s));
    slabs[s] = std::move(builder.known);
  });
  return detail::joined(slabs);
}

}  // namespace

BodySurface build_surface(const Model& model, const State& state, const CtVolume* ct, Extent extent,
                          const Exec& exec) {
  BodySurface surface;
  surface.pieces = make_pieces(model, state);
  const SkinLevel level(model, state, surface.pieces.fine, ct);
  Builder builder{
      .model = model, .state = state, .level = level, .pieces = surface.pieces, .known = {}, .in_hand = {}};
  if (extent == Extent::kAll) {
    builder.known.points = look_at_all(exec, builder);
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
