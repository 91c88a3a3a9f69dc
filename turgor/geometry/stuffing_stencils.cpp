#include "turgor/geometry/stuffing_stencils.hpp"

#include <algorithm>

#include "turgor/core/assert.hpp"

namespace turgor::stuffing {

namespace {

constexpr int kFace[4][3] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};  // seen from outside

/// A polygon of the inner region's boundary; `diagonal` is the cut corner at which the diagonal of a
/// quadrilateral ends.
struct Polygon {
  std::array<Corner, 4> corner;
  int count = 0;
  int diagonal = -1;  // of a quadrilateral: the cut at one end of its diagonal

  void add(Corner c) { corner[std::size_t(count++)] = c; }
  bool has(const Corner& c) const {
    return std::find(corner.begin(), corner.begin() + count, c) != corner.begin() + count;
  }
};

/// Selects which inside corner a or b of a face has the cut edge (to n, outside) at which the diagonal ends.
/// If the face has one long cut edge, it is that edge. If both are short, a and b are neighbors in their
/// grid, and parity decides: seen from n, exactly one of them is below in an odd number of coordinates.
bool diagonal_ends_at_first(const BccPoint& a, const BccPoint& b, const BccPoint& n) {
  if (a.grid != b.grid) return a.grid == n.grid;
  int below = 0;
  for (int axis = 0; axis < 3; axis++) below += 2 * a.index[axis] + a.grid < 2 * n.index[axis] + n.grid;
  return below % 2 == 1;
}

/// Inner region of a face, in the order of its corners.
Polygon clip_face(const LatticeTet& tet, const int (&face)[3]) {
  Polygon polygon;
  for (int i = 0; i < 3; i++) {
    const std::size_t p = std::size_t(face[i]), q = std::size_t(face[(i + 1) % 3]);
    if (tet.side[p] != Side::kOutside) polygon.add({tet.id[p]});
    if (tet.side[p] == Side::kInside && tet.side[q] == Side::kOutside) polygon.add({tet.id[p], tet.id[q]});
    if (tet.side[p] == Side::kOutside && tet.side[q] == Side::kInside) polygon.add({tet.id[q], tet.id[p]});
  }
  return polygon;
}

/// Chooses the end of a quadrilateral's diagonal that is a cut.
void choose_diagonal(const LatticeTet& tet, const int (&face)[3], Polygon& polygon) {
  if (polygon.count < 4) return;
  int n = 0;
  while (tet.side[std::size_t(face[n])] != Side::kOutside) n++;
  const auto a = std::size_t(face[(n + 1) % 3]), b = std::size_t(face[(n + 2) % 3]);
  const std::size_t outer = std::size_t(face[n]);
  const bool first = diagonal_ends_at_first(tet.point[a], tet.point[b], tet.point[outer]);
  const Corner end{tet.id[first ? a : b], tet.id[outer]};
  polygon.diagonal =
      int(std::find(polygon.corner.begin(), polygon.corner.end(), end) - polygon.corner.begin());
}

/// A cut that sees the whole inner region without crossing a diagonal.
Corner choose_apex(const std::array<Polygon, 4>& faces) {
  for (const Polygon& face : faces)
    for (int i = 0; i < face.count; i++) {
      const Corner apex = face.corner[std::size_t(i)];
      if (apex.to >= 0 && std::all_of(faces.begin(), faces.end(), [&](const Polygon& other) {
            return other.count < 4 || !other.has(apex) || other.corner[std::size_t(other.diagonal)] == apex;
          }))
        return apex;
    }
  TURGOR_ASSERT(false, "the diagonals of a cut tetrahedron never run in a circle");
  return {};
}

}  // namespace

void append_inside(const LatticeTet& tet, std::vector<Corner>& corners) {
  const auto is = [&](Side side) { return std::count(tet.side.begin(), tet.side.end(), side); };
  if (is(Side::kInside) == 0) return;
  if (is(Side::kOutside) == 0) {
    for (const std::int64_t id : tet.id) corners.push_back({id});
    return;
  }
  std::array<Polygon, 4> faces;
  for (std::size_t f = 0; f < 4; f++) {
    faces[f] = clip_face(tet, kFace[f]);
    choose_diagonal(tet, kFace[f], faces[f]);
  }
  // A cone from the apex over every boundary triangle without it. Faces created by the surface contain the
  // apex.
  const Corner apex = choose_apex(faces);
  for (const Polygon& face : faces) {
    if (face.count < 3 || face.has(apex)) continue;
    const int first = face.count == 4 ? face.diagonal : 0;
    const auto at = [&](int i) { return face.corner[std::size_t((first + i) % face.count)]; };
    for (int i = 1; i + 1 < face.count; i++)
      for (const Corner& c : {at(0), at(i + 1), at(i), apex}) corners.push_back(c);
  }
}

}  // namespace turgor::stuffing
