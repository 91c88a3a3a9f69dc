#include "turgor/models/lattice/surface.hpp"

#include <algorithm>
#include <optional>

#include "turgor/models/lattice/cut_tet.hpp"
#include "turgor/models/lattice/tet_surface.hpp"

namespace turgor::lattice {

namespace {

constexpr int kSkin = 0, kFirstCap = 1, kWall = 7,
              kParts = 8;  // each part has vertices, and so normals, of its own

/// Numbers keys in the order of their first appearance.
class KeyIndex {
 public:
  int find_or_add(std::uint64_t key) {
    if (2 * (keys_ + 1) > table_.size()) grow();
    Entry& entry = place(key);
    if (entry.value < 0) entry = {key, int(keys_++)};
    return entry.value;
  }

 private:
  struct Entry {
    std::uint64_t key = 0;
    int value = -1;
  };
  Entry& place(std::uint64_t key) {
    std::size_t at = (key * 0x9e3779b97f4a7c15ull) >> 20 & (table_.size() - 1);
    while (table_[at].value >= 0 && table_[at].key != key) at = (at + 1) & (table_.size() - 1);
    return table_[at];
  }
  void grow() {
    std::vector<Entry> old(std::max<std::size_t>(1024, 2 * table_.size()));
    old.swap(table_);
    for (const Entry& entry : old)
      if (entry.value >= 0) place(entry.key) = entry;
  }
  std::vector<Entry> table_;
  std::size_t keys_ = 0;
};

/// A point of a cut line: where the blade crossed the skin between two skin points, or the middle of three.
/// Found when the skin is smooth.
struct Blend {
  int point;
  std::array<int, 3> of;
  std::optional<CutLevel> level;  // none: the middle
};

struct Builder {
  CutBody body;
  KeyIndex index;
  std::vector<Vec3> rest;                    // by point [m]
  std::vector<int> slot;                     // by point
  std::vector<std::uint8_t> border;          // by point: bit 2 axis + end = lies where the lattice ends
  std::vector<std::array<int, 2>> segments;  // of skin, between skin points
  std::vector<std::array<int, 2>> gaps;      // clip points that face each other
  std::vector<Blend> blends;
  std::vector<std::array<int, 2>> skin_points;  // point, slot of its node
  std::array<std::vector<Int3>, kParts> triangles;
};

/// One tetrahedron: its corners, and what the polygons' points are in the whole surface.
struct Tet {
  int kind;  // index into kKuhnTets
  TetNodes nodes;
  std::array<int, 4> slots;
  TetPattern pattern;
  bool any_cut = false, any_removed = false;
};

std::uint8_t border_of(const Lattice& l, Int3 p) {
  int mask = 0;
  for (int axis = 0; axis < 3; axis++) {
    if (p[axis] == 0) mask |= 1 << (2 * axis);
    if (p[axis] == l.size[axis] - 1) mask |= 2 << (2 * axis);
  }
  return std::uint8_t(mask);
}

/// How far from the solid node towards the other one the skin is.
Real skin_fraction(const Model& model, std::size_t solid, std::size_t other) {
  const auto threshold = Real(model.params.tissue.air_max);
  const auto a = Real(model.hu[solid]), b = Real(model.hu[other]);
  if (is_body(model.tissue[other]) || a < threshold || b >= threshold) return Real(0.5);
  return std::clamp((a - threshold) / (a - b), Real(0.05), Real(0.95));
}

std::uint64_t key_of(const Tet& tet, TetPoint p) {
  const auto offset = [&](int corner) {
    const Int3 d = tet.nodes[std::size_t(corner)] - tet.nodes[std::size_t(p.i)];
    return std::uint64_t((d.x + 1) + 3 * (d.y + 1) + 9 * (d.z + 1));
  };
  const std::uint64_t own = is_middle(p) ? std::uint64_t(tet.kind) : 7;  // middles belong to one tetrahedron
  return ((std::uint64_t(tet.slots[std::size_t(p.i)]) * 32 + offset(p.j)) * 32 + offset(p.b)) * 8 + own;
}

int point_index(Builder& builder, const Tet& tet, TetPoint p);

Vec3 blended(const Builder& builder, const Blend& blend) {
  const Vec3 a = builder.rest[std::size_t(blend.of[0])], b = builder.rest[std::size_t(blend.of[1])];
  if (!blend.level) return (a + b + builder.rest[std::size_t(blend.of[2])]) / Real(3);
  const Vec3 step = builder.body.model.lattice.step;
  const auto level_at = [&](Vec3 x) { return blend.level->at({x.x / step.x, x.y / step.y, x.z / step.z}); };
  const double from = level_at(a), to = level_at(b);
  const double t = from < 0 && to > 0 ? from / (from - to)
                   : from >= 0        ? 0
                                      : 1;  // the blade may miss the segment beside air
  return a + (b - a) * Real(std::clamp(t, 0.01, 0.99));
}

/// Notes what a clip or middle point depends on; both sides of a cut note the same. The first place is a
/// guess until the skin is smooth.
Vec3 blend_point(Builder& builder, const Tet& tet, TetPoint p, int point) {
  Blend blend{.point = point, .of = {}, .level = {}};
  if (is_clip(p)) {
    const auto [i, j] = std::minmax(
        p.i, p.j, [&](int a, int b) { return tet.slots[std::size_t(a)] < tet.slots[std::size_t(b)]; });
    const Int3 nodes[3] = {tet.nodes[std::size_t(i)], tet.nodes[std::size_t(j)], tet.nodes[std::size_t(p.b)]};
    const int signs[3] = {-1, 1, 0};
    blend.of = {point_index(builder, tet, skin_point(i, p.b)), point_index(builder, tet, skin_point(j, p.b)),
                0};
    blend.level = fit_level(builder.body, nodes, signs);
  } else {
    std::size_t n = 0;
    for (int corner = 0; corner < 4; corner++)
      if (corner != p.b) blend.of[n++] = point_index(builder, tet, skin_point(corner, p.b));
    std::sort(blend.of.begin(), blend.of.end());
  }
  builder.blends.push_back(blend);
  return blended(builder, blend);
}

int point_index(Builder& builder, const Tet& tet, TetPoint p) {
  const int point = builder.index.find_or_add(key_of(tet, p));
  if (std::size_t(point) < builder.rest.size()) return point;

  const Lattice& l = builder.body.model.lattice;
  const auto i = std::size_t(p.i), j = std::size_t(p.j), b = std::size_t(p.b);
  const Vec3 from = rest_position(l, tet.nodes[i]);
  const auto towards = [&](std::size_t other, Real t) {
    return from + (rest_position(l, tet.nodes[other]) - from) * t;
  };
  builder.rest.push_back(from);
  builder.slot.push_back(tet.slots[i]);
  builder.border.push_back(border_of(l, tet.nodes[i]) & border_of(l, tet.nodes[b]));
  Vec3 at = from;
  if (is_skin_point(p)) builder.skin_points.push_back({point, tet.slots[i]});
  if (is_skin_point(p))
    at = towards(b, skin_fraction(builder.body.model, std::size_t(tet.slots[i]), std::size_t(tet.slots[b])));
  else if (is_crossing(p))
    at = towards(j, crossing(builder.body, tet.nodes[i], tet.nodes[j]));
  else if (!is_corner(p))
    at = blend_point(builder, tet, p, point);
  builder.rest[std::size_t(point)] = at;
  return point;
}

/// A fan; a quadrangle is cut along its shorter diagonal.
void add_polygon(Builder& builder, const Tet& tet, const TetPolygon& polygon, int part) {
  std::array<int, 16> p;
  for (int n = 0; n < polygon.count; n++) p[std::size_t(n)] = point_index(builder, tet, polygon.at(n));
  const auto distance = [&](std::size_t a, std::size_t b) {
    return norm(builder.rest[std::size_t(p[a])] - builder.rest[std::size_t(p[b])]);
  };
  if (polygon.count == 4 && distance(1, 3) < distance(0, 2))
    std::rotate(p.begin(), p.begin() + 1, p.begin() + 4);
  auto& triangles = builder.triangles[std::size_t(part)];
  for (int n = 2; n < polygon.count; n++)
    triangles.push_back({p[0], p[std::size_t(n - 1)], p[std::size_t(n)]});
}

void add_polygons(Builder& builder, const Tet& tet, const TetPolygons& polygons, int part) {
  for (int n = 0; n < polygons.count; n++) add_polygon(builder, tet, polygons.polygons[std::size_t(n)], part);
}

/// Skin segments lie on faces, which two tetrahedra walk in opposite directions: one of them counts, and both
/// do where the lattice ends.
void add_outline(Builder& builder, const Tet& tet, const TetPolygon& outline) {
  for (int n = 0; n < outline.count; n++) {
    const TetPoint from = outline.at(n), to = outline.at(n + 1);
    const int a = point_index(builder, tet, from), b = point_index(builder, tet, to);
    if (a < b || (builder.border[std::size_t(a)] & builder.border[std::size_t(b)]))
      builder.segments.push_back({a, b});
    if (from.i != to.i && tet.pattern.cut[std::size_t(from.i)][std::size_t(to.i)])
      builder.gaps.push_back({point_index(builder, tet, clip_point(from.i, to.i, from.b)),
                              point_index(builder, tet, clip_point(to.i, from.i, from.b))});
  }
}

void add_caps(Builder& builder, const Tet& tet) {
  const Lattice& l = builder.body.model.lattice;
  for (int face = 0; face < 4; face++) {
    int mask = 63;
    for (const int corner : kTetFaces[std::size_t(face)])
      mask &= border_of(l, tet.nodes[std::size_t(corner)]);
    for (int plane = 0; plane < 6; plane++)
      if (mask >> plane & 1) add_polygons(builder, tet, face_polygons(tet.pattern, face), kFirstCap + plane);
  }
}

void add_tet(Builder& builder, Int3 cell, int kind) {
  Tet tet{.kind = kind, .nodes = {}, .slots = {}, .pattern = {}};
  int solids = 0, border = 0;
  for (std::size_t n = 0; n < 4; n++) {
    tet.nodes[n] = cell + kKuhnTets[std::size_t(kind)][n];
    tet.slots[n] = node_slot(builder.body.model.lattice, tet.nodes[n]);
    tet.pattern.solid[n] = builder.body.solid[std::size_t(tet.slots[n])] != 0;
    tet.any_removed |= !tet.pattern.solid[n] && is_body(builder.body.model.tissue[std::size_t(tet.slots[n])]);
    solids += tet.pattern.solid[n];
    border |= border_of(builder.body.model.lattice, tet.nodes[n]);
  }
  if (solids == 0) return;
  if (!builder.body.state.cut_edges.empty())
    for (std::size_t a = 0; a < 4; a++)
      for (std::size_t b = 0; b < a; b++) {
        const bool cut = is_cut(builder.body, tet.nodes[a], tet.nodes[b]);
        tet.pattern.cut[a][b] = tet.pattern.cut[b][a] = cut;
        tet.any_cut |= cut;
      }
  if (solids < 4) {
    TetPolygon outline;
    const TetPolygons skin = skin_polygons(tet.pattern, outline);
    add_polygons(builder, tet, skin, tet.any_removed ? kWall : kSkin);
    add_outline(builder, tet, outline);
  }
  if (border) add_caps(builder, tet);
  if (tet.any_cut) add_polygons(builder, tet, wall_polygons(tet.pattern), kWall);
}

/// Cells that are not all air and not all whole tissue.
void add_cells(Builder& builder) {
  const Lattice& l = builder.body.model.lattice;
  const auto& solid = builder.body.solid;
  std::vector<std::uint8_t> touched(solid.size());  // by slot of the lower corner: an edge of the cell is cut
  for (const CutEdge& edge : builder.body.state.cut_edges) {
    const Int3 a = slot_node(l, edge.slot);
    for (int c = 0; c < 8; c++)
      if (const Int3 cell = a - Int3{c & 1, c >> 1 & 1, c >> 2}; contains(l, cell))
        touched[std::size_t(node_slot(l, cell))] = 1;
  }
  for (int k = 0; k + 1 < l.size.z; k++)
    for (int j = 0; j + 1 < l.size.y; j++)
      for (int i = 0; i + 1 < l.size.x; i++) {
        const int lower = node_slot(l, i, j, k);
        int solids = 0;
        for (int c = 0; c < 8; c++)
          solids += solid[std::size_t(lower + slot_offset(l, {c & 1, c >> 1 & 1, c >> 2}, i & 1))];
        const bool border =
            i == 0 || j == 0 || k == 0 || i + 2 == l.size.x || j + 2 == l.size.y || k + 2 == l.size.z;
        if (solids == 0 || (solids == 8 && !border && !touched[std::size_t(lower)])) continue;
        for (int t = 0; t < 6; t++) add_tet(builder, {i, j, k}, t);
      }
}

/// Takes the stairs of the lattice out of the skin: umbrella steps forth and back, which keep the volume
/// [Taubin 1995]. Points where the lattice ends move along its end.
void smooth_skin(Builder& builder) {
  constexpr int kRounds = 4;
  std::vector<Vec3> sum(builder.rest.size());
  std::vector<Real> count(builder.rest.size());
  const auto add = [&](int to, int from) {
    if ((builder.border[std::size_t(from)] & builder.border[std::size_t(to)]) !=
        builder.border[std::size_t(to)])
      return;
    sum[std::size_t(to)] += builder.rest[std::size_t(from)];
    count[std::size_t(to)] += 1;
  };
  for (int round = 0; round < kRounds; round++)
    for (const Real step : {Real(0.5), Real(-0.53)}) {
      std::fill(sum.begin(), sum.end(), Vec3{});
      std::fill(count.begin(), count.end(), Real(0));
      for (const auto& [a, b] : builder.segments) add(a, b), add(b, a);
      for (std::size_t n = 0; n < sum.size(); n++)
        if (count[n] > 0) builder.rest[n] += (sum[n] / count[n] - builder.rest[n]) * step;
    }
}

/// A skin point of a node beside a cut belongs on that node's side of the blade; where the edge that it lies
/// on leads across, to air, it moves back along the skin, so that the lips are as straight as the blade.
void keep_to_sides(Builder& builder) {
  const CutBody& body = builder.body;
  const Lattice& l = body.model.lattice;
  constexpr double kMargin = 0.05;  // [steps]
  std::vector<Vec3> normals(builder.rest.size());
  for (const Int3 t : builder.triangles[kSkin]) {
    const Vec3 a = builder.rest[std::size_t(t.x)];
    const Vec3 n = cross(builder.rest[std::size_t(t.y)] - a, builder.rest[std::size_t(t.z)] - a);
    for (int corner = 0; corner < 3; corner++) normals[std::size_t(t[corner])] += n;
  }
  for (const auto& [point, solid] : builder.skin_points) {
    const std::optional<CutLevel> level = level_beside(body, slot_node(l, solid));
    if (!level) continue;
    Vec3& x = builder.rest[std::size_t(point)];
    const double beyond = level->at(Vec3d{x.x / l.step.x, x.y / l.step.y, x.z / l.step.z}) + kMargin;
    if (beyond <= 0) continue;
    const Vec3d across{level->gradient.x / l.step.x, level->gradient.y / l.step.y,
                       level->gradient.z / l.step.z};
    const Vec3d n(normalized(normals[std::size_t(point)]));
    const Vec3d along_skin = across - n * dot(n, across);
    if (dot(along_skin, along_skin) > 0.1 * dot(across, across))
      x -= Vec3(along_skin * (beyond / dot(along_skin, across)));
  }
}

/// From points to vertices, part by part.
BodySurface take_parts(const Builder& builder) {
  BodySurface surface;
  std::vector<int> vertex(builder.rest.size());
  for (int part = 0; part < kParts; part++) {
    std::fill(vertex.begin(), vertex.end(), -1);
    const auto vertex_of = [&](int point) {
      int& v = vertex[std::size_t(point)];
      if (v < 0) {
        v = int(surface.rest.size());
        surface.rest.push_back(builder.rest[std::size_t(point)]);
        surface.slot.push_back(builder.slot[std::size_t(point)]);
      }
      return v;
    };
    for (const auto& [a, b, c] : builder.triangles[std::size_t(part)])
      surface.triangles.push_back({vertex_of(a), vertex_of(b), vertex_of(c)});
    if (part != kWall) surface.skin_triangles = int(surface.triangles.size());
    surface.twin.resize(surface.rest.size(), -1);
    if (part != kSkin) continue;
    for (const auto& [a, b] : builder.gaps) {
      const int va = vertex[std::size_t(a)], vb = vertex[std::size_t(b)];
      if (va >= 0 && vb >= 0) surface.twin[std::size_t(va)] = vb, surface.twin[std::size_t(vb)] = va;
    }
  }
  return surface;
}

}  // namespace

BodySurface build_surface(const Model& model, const State& state) {
  Builder builder{.body = make_cut_body(model, state),
                  .index = {},
                  .rest = {},
                  .slot = {},
                  .border = {},
                  .segments = {},
                  .gaps = {},
                  .blends = {},
                  .skin_points = {},
                  .triangles = {}};
  add_cells(builder);
  smooth_skin(builder);
  if (!state.cut_edges.empty()) keep_to_sides(builder);
  for (const Blend& blend : builder.blends) builder.rest[std::size_t(blend.point)] = blended(builder, blend);
  return take_parts(builder);
}

std::vector<Vec3d> rest_points(const Model& model, const BodySurface& surface) {
  std::vector<Vec3d> points;
  points.reserve(surface.rest.size());
  for (const Vec3 x : surface.rest) points.push_back(model.grid.origin + model.grid.axes * Vec3d(x));
  return points;
}

}  // namespace turgor::lattice
