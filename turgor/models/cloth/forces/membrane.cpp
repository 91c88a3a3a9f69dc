#include "turgor/models/cloth/forces/membrane.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/geometry/surface_edges.hpp"
#include "turgor/models/cloth/forces/membrane_tension.hpp"
#include "turgor/models/cloth/model/state.hpp"

namespace turgor::cloth {

namespace {

/// Gradients of the shape functions of the second and third corner, along warp and weft [1/m].
std::array<std::array<double, 2>, 2> slopes_at_rest(Vec3d p, Vec3d q, const Weave& weave) {
  const double p1 = dot(p, weave.warp), p2 = dot(p, weave.weft), q1 = dot(q, weave.warp),
               q2 = dot(q, weave.weft);
  const double twice = p1 * q2 - p2 * q1;
  TURGOR_CHECK(twice != 0, "a triangle has an area at rest");
  return {{{q2 / twice, -q1 / twice}, {-p2 / twice, p1 / twice}}};
}

struct Corners {
  Vec3d a, p, q;  // first corner, vectors to the second and the third [m]
};
Corners corners(const TriMesh& mesh, Int3 t) {
  const auto at = [&mesh](int v) { return Vec3d(mesh.vertices[std::size_t(v)]); };
  return {at(t.x), at(t.y) - at(t.x), at(t.z) - at(t.x)};
}

/// Spring stiffness along a triangle's sides that is an upper bound of its stiffness [N/m]. The energy is a
/// quadratic form K of the three elongations, and the diagonal Σ_f |K_ef| √(K_ee/K_ff) dominates it.
std::array<double, 3> side_stiffness(const MembraneLaw& m, const Corners& c, const Weave& weave) {
  const Vec3d sides[3] = {c.p, c.q - c.p, -c.q};
  double strain[3][3];  // strain of a unit elongation of side s: warp, weft, warp-weft
  // strains of the sides' directions, and their inverse
  double rows[3][3];
  for (int s = 0; s < 3; s++) {
    const Vec3d t = normalized(sides[s]);
    const double x = dot(t, weave.warp), y = dot(t, weave.weft);
    rows[s][0] = x * x, rows[s][1] = y * y, rows[s][2] = 2 * x * y;
  }
  for (int s = 0; s < 3; s++) {  // columns of the inverse
    const double *a = rows[(s + 1) % 3], *b = rows[(s + 2) % 3];
    const double n[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
    const double along = rows[s][0] * n[0] + rows[s][1] * n[1] + rows[s][2] * n[2];
    for (int k = 0; k < 3; k++) strain[s][k] = n[k] / along / norm(sides[s]);
  }
  // quadratic form of the elongations
  const double area = norm(cross(c.p, c.q)) / 2;
  TURGOR_CHECK(area > 0, "a triangle has an area");
  double form[3][3];
  for (int r = 0; r < 3; r++)
    for (int s = 0; s < 3; s++) {
      const double *a = strain[r], *b = strain[s];
      form[r][s] = area * (double(m.warp) * a[0] * b[0] + double(m.weft) * a[1] * b[1] +
                           double(m.both) * (a[0] * b[1] + a[1] * b[0]) + 4 * double(m.shear) * a[2] * b[2]);
    }
  // dominating diagonal
  std::array<double, 3> stiffness{};
  for (int r = 0; r < 3; r++)
    for (int s = 0; s < 3; s++)
      if (form[r][r] > 0 && form[s][s] > 0)
        stiffness[std::size_t(r)] += std::abs(form[r][s]) * std::sqrt(form[r][r] / form[s][s]);
  return stiffness;
}

/// Plane-stress law: D₁₁ = warp/(1 − ν² weft/warp), D₂₂ = weft/(…), D₁₂ = ν D₂₂, G = shear [N/m].
MembraneLaw material(const Fabric& fabric) {
  const double other = fabric.poisson * fabric.weft / fabric.warp, rest = 1 - fabric.poisson * other;
  TURGOR_CHECK(rest > 0, "Poisson's ratio is less than the root of warp over weft");
  MembraneLaw m;
  m.warp = Real(fabric.warp / rest), m.weft = Real(fabric.weft / rest);
  m.both = Real(fabric.poisson * fabric.weft / rest), m.shear = Real(fabric.shear);
  return m;
}

/// Slot of `other` in the row of `vertex`, relative to the first of its batch.
std::uint16_t slot_of(const Rows& rows, int vertex, int other) {
  const std::size_t batch = std::size_t(vertex) / std::size_t(kLanes),
                    l = std::size_t(vertex) % std::size_t(kLanes);
  for (int s = rows.slot_begin[batch]; s < rows.slot_begin[batch + 1]; s++)
    if (rows.stiffness[std::size_t(s) * std::size_t(kLanes) + l] > 0 && neighbor(rows, s, int(l)) == other)
      return std::uint16_t(s - rows.slot_begin[batch]);
  TURGOR_ASSERT(false, "every side of a triangle is in the rows of its ends");
  return 0;
}

/// Tensions around one chunk of vertices. Each triangle is evaluated once for all its corners in the chunk.
struct TensionChunk {
  const Model& model;
  SheetView sheet;
  MembraneView membrane;

  void operator()(std::size_t chunk) const {
    const std::size_t begin = chunk * kChunk, end = std::min(begin + kChunk, sheet.size);
    const std::vector<int>& slots = model.rows.slot_begin;
    std::fill(sheet.across + slots[begin / std::size_t(kLanes)] * kLanes,
              sheet.across + slots[end / std::size_t(kLanes)] * kLanes, Real(0));
    const ChunkTriangles& chunks = model.chunk_triangles;
    for (int n = chunks.begin[chunk]; n < chunks.begin[chunk + 1]; n += kLanes)
      batch(&chunks.triangle[std::size_t(n)], std::min(kLanes, chunks.begin[chunk + 1] - n), begin, end);
  }

  /// Processes up to sixteen triangles; missing ones repeat the last.
  void batch(const int* triangle, int count, std::size_t begin, std::size_t end) const {
    // corners and rest gradients
    const Membrane& m = model.membrane;
    int item[kLanes], corner[3][kLanes];
    for (int l = 0; l < kLanes; l++) {
      item[l] = triangle[std::min(l, count - 1)];
      for (int k = 0; k < 3; k++) corner[k][l] = membrane.triangles[item[l]][k];
    }
    const auto gather = [this](const int* v) {
      return Lanes3{gather_lanes(sheet.x.x, v), gather_lanes(sheet.x.y, v), gather_lanes(sheet.x.z, v)};
    };
    // tensions
    const Lanes3 a = gather(corner[0]);
    const tension::Slopes<Lanes> g{
        {gather_lanes(m.second[0].data(), item), gather_lanes(m.second[1].data(), item)},
        {gather_lanes(m.third[0].data(), item), gather_lanes(m.third[1].data(), item)}};
    const tension::Sides<Lanes> found = tensions(m.law, g, gather(corner[1]) - a, gather(corner[2]) - a);
    // scatter to the entries of this chunk
    for (int l = 0; l < count; l++)
      for (int side = 0; side < 3; side++) {
        const auto i = std::size_t(corner[side][l]), j = std::size_t(corner[(side + 1) % 3][l]);
        const Real tension = found.side[side][l];
        if (i >= begin && i < end) sheet.across[membrane.entry(sheet, i, item[l], 2 * side)] += tension;
        if (j >= begin && j < end) sheet.across[membrane.entry(sheet, j, item[l], 2 * side + 1)] += tension;
      }
  }
};

}  // namespace

Weave weave_at(Vec3d direction, Vec3d normal) {
  const Vec3d n = normalized(normal), along = normalized(direction);
  TURGOR_CHECK(is_unit(n) && is_unit(along), "a weave has a normal and a direction");
  Vec3d warp = along - n * dot(along, n);
  if (!(norm(warp) > 1e-6)) {
    const Vec3d other = std::abs(n.x) < 0.9 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0};
    warp = other - n * dot(other, n);
  }
  return {normalized(warp), cross(n, normalized(warp))};
}

Membrane make_membrane(const TriMesh& mesh, const Fabric& fabric, std::span<const char> is_sliver) {
  TURGOR_ASSERT(is_sliver.size() == mesh.triangles.size(), "every triangle is a sliver or not");
  Membrane m{.law = material(fabric)};
  const std::size_t count = mesh.triangles.size(), size = padded(count);
  for (int k = 0; k < 2; k++) m.second[k].resize(size), m.third[k].resize(size);
  for (std::size_t t = 0; t < count; t++) {
    const Corners c = corners(mesh, mesh.triangles[t]);
    const auto g = slopes_at_rest(c.p, c.q, weave_at(fabric.direction, cross(c.p, c.q)));
    if (is_sliver[t]) continue;  // gradients of 0: no force
    for (std::size_t k = 0; k < 2; k++) m.second[k][t] = Real(g[0][k]), m.third[k][t] = Real(g[1][k]);
  }
  return m;
}

std::vector<Spring> membrane_springs(const TriMesh& mesh, const Fabric& fabric,
                                     std::span<const char> is_sliver) {
  TURGOR_ASSERT(is_sliver.size() == mesh.triangles.size(), "every triangle is a sliver or not");
  // stiffness of the sides of each triangle
  const MembraneLaw m = material(fabric);
  std::vector<std::array<double, 3>> stiffness;
  for (std::size_t t = 0; t < mesh.triangles.size(); t++) {
    const Corners c = corners(mesh, mesh.triangles[t]);
    const Weave weave = weave_at(fabric.direction, cross(c.p, c.q));
    stiffness.push_back(is_sliver[t] ? std::array<double, 3>{} : side_stiffness(m, c, weave));
  }
  // sum over the triangles of each edge
  std::vector<Spring> springs;
  const std::vector<EdgeUse> uses = sorted_edges(mesh.triangles);
  for_each_edge(uses, [&](std::span<const EdgeUse> edge) {
    double sum = 1e-6 * fabric.warp;  // a stiffness of 0 would mean no neighbor
    for (const EdgeUse& use : edge) sum += stiffness[std::size_t(use.triangle)][std::size_t(use.side)];
    springs.push_back({.a = edge[0].a, .b = edge[0].b, .stiffness = Real(sum)});
  });
  return springs;
}

void find_slots(const std::vector<Int3>& triangles, const Rows& rows, Membrane& membrane) {
  // width of the slot numbers
  const auto most = [&rows] {
    int slots = 0;
    for (std::size_t b = 0; b < batch_count(rows); b++)
      slots = std::max(slots, rows.slot_begin[b + 1] - rows.slot_begin[b]);
    return slots;
  };
  const bool is_wide = most() > 256;
  (is_wide ? membrane.wide_slot.resize(triangles.size()) : membrane.slot.resize(triangles.size()));
  const auto set = [&](std::size_t t, int n, std::uint16_t slot) {
    if (is_wide)
      membrane.wide_slot[t][std::size_t(n)] = slot;
    else
      membrane.slot[t][std::size_t(n)] = std::uint8_t(slot);
  };
  // slots of both ends of every side
  for (std::size_t t = 0; t < triangles.size(); t++)
    for (int side = 0; side < 3; side++) {
      const int i = triangles[t][side], j = triangles[t][(side + 1) % 3];
      set(t, 2 * side, slot_of(rows, i, j)), set(t, 2 * side + 1, slot_of(rows, j, i));
    }
}

void find_tensions(const Exec& exec, const Model& model, State& state) {
  TURGOR_CHECK(model.chunk_triangles.begin.size() == (state.x.size() + kChunk - 1) / kChunk + 1,
               "every vertex is in a chunk");
  parallel_for(exec, model.chunk_triangles.begin.size() - 1,
               TensionChunk{model, view(model, state), view(model.membrane, model.triangles)});
}

TriangleTension triangle_tension(const Model& model, const State& state, std::size_t triangle) {
  TURGOR_CHECK(triangle < model.triangles.size(), "the triangle is of the cloth");
  const Membrane& m = model.membrane;
  const Int3 t = model.triangles[triangle];
  const auto at = [&state](int v) { return Vec3d(state.x[std::size_t(v)]); };
  const tension::Slopes<double> g{{double(m.second[0][triangle]), double(m.second[1][triangle])},
                                  {double(m.third[0][triangle]), double(m.third[1][triangle])}};
  const tension::Sides<double> found = tensions(m.law, g, at(t.y) - at(t.x), at(t.z) - at(t.x));
  return {{found.side[0], found.side[1], found.side[2]}, found.energy};
}

}  // namespace turgor::cloth
