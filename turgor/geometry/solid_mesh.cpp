#include "turgor/geometry/solid_mesh.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "turgor/core/disjoint_sets.hpp"
#include "turgor/geometry/quadratic.hpp"

namespace turgor {

namespace {

constexpr std::array<std::array<int, 4>, 4> kTetFaces{
    {{0, 2, 1, -1}, {0, 1, 3, -1}, {1, 2, 3, -1}, {2, 0, 3, -1}}};
constexpr std::array<std::array<int, 4>, 6> kHexFaces{
    {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}}};

std::size_t face_size(const SolidMesh& mesh) { return mesh.corners == 8 ? 4 : 3; }

/// A face of an element: its sorted vertices, which identify the face from both elements, then the element
/// and the number of the face.
using Face = std::array<int, 6>;
constexpr std::size_t kElement = 4, kNumber = 5;

bool same_vertices(const Face& a, const Face& b) { return std::equal(a.begin(), a.begin() + 4, b.begin()); }

std::vector<Face> sorted_faces(const SolidMesh& mesh) {
  const auto table = element_faces(mesh);
  std::vector<Face> faces;
  faces.reserve(element_count(mesh) * table.size());
  for (std::size_t e = 0; e < element_count(mesh); e++)
    for (std::size_t f = 0; f < table.size(); f++) {
      Face face{-1, -1, -1, -1, int(e), int(f)};
      for (std::size_t c = 0; c < face_size(mesh); c++) face[c] = element(mesh, e)[std::size_t(table[f][c])];
      for (std::size_t i = 1; i < face_size(mesh); i++)
        for (std::size_t k = i; k > 0 && face[k] < face[k - 1]; k--) std::swap(face[k], face[k - 1]);
      faces.push_back(face);
    }
  std::sort(faces.begin(), faces.end());
  return faces;
}

/// Jacobian determinant of a hexahedron's trilinear map at a point of the cube [-1, 1]³.
double hex_jacobian(const SolidMesh& mesh, std::size_t e, Vec3d p) {
  static constexpr std::array<Vec3d, 8> kCorner{
      {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1}, {-1, -1, 1}, {1, -1, 1}, {1, 1, 1}, {-1, 1, 1}}};
  Mat3d map{{{}, {}, {}}};
  for (std::size_t c = 0; c < 8; c++) {
    const Vec3d x = mesh.vertices[std::size_t(element(mesh, e)[c])], s = kCorner[c];
    const Vec3d t{1 + s.x * p.x, 1 + s.y * p.y, 1 + s.z * p.z};
    map.column[0] += x * (s.x * t.y * t.z / 8);
    map.column[1] += x * (s.y * t.x * t.z / 8);
    map.column[2] += x * (s.z * t.x * t.y / 8);
  }
  return determinant(map);
}

/// The Jacobian determinant is cubic, so a rule with five points (negative weight at the centroid) is exact.
double quadratic_volume(const SolidMesh& mesh, std::size_t e) {
  const auto jacobian = [&](const std::array<double, 4>& linear) {
    const std::array<Vec3d, 10> slope = quadratic_slopes(linear);
    Mat3d map{{{}, {}, {}}};
    for (std::size_t c = 0; c < 10; c++)
      for (int axis = 0; axis < 3; axis++)
        map.column[axis] += mesh.vertices[std::size_t(element(mesh, e)[c])] * slope[c][axis];
    return determinant(map) / 6;
  };
  double sum = -0.8 * jacobian({0.25, 0.25, 0.25, 0.25});
  for (std::size_t c = 0; c < 4; c++) {
    std::array<double, 4> linear{1.0 / 6, 1.0 / 6, 1.0 / 6, 1.0 / 6};
    linear[c] = 0.5;
    sum += 0.45 * jacobian(linear);
  }
  return sum;
}

/// Triangles of a face, as node numbers of the element.
std::vector<Int3> face_triangles(const SolidMesh& mesh, const std::array<int, 4>& face) {
  const auto [a, b, c, d] = face;
  if (mesh.corners == 4) return {{a, b, c}};
  if (mesh.corners == 8) return {{a, b, c}, {a, c, d}};
  const int ab = node_between(a, b), bc = node_between(b, c), ca = node_between(c, a);
  return {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}};
}

}  // namespace

double volume(const SolidMesh& mesh, std::size_t e) {
  const auto x = [&](std::size_t c) { return mesh.vertices[std::size_t(element(mesh, e)[c])]; };
  if (mesh.corners == 10) return quadratic_volume(mesh, e);
  if (mesh.corners == 4) return orientation(x(0), x(1), x(2), x(3)) / 6;
  const double g = 1 / std::sqrt(3.0);
  double sum = 0;
  for (const double a : {-g, g})
    for (const double b : {-g, g})
      for (const double c : {-g, g}) sum += hex_jacobian(mesh, e, {a, b, c});
  return sum;
}

double volume(const SolidMesh& mesh) {
  double sum = 0;
  for (std::size_t e = 0; e < element_count(mesh); e++) sum += volume(mesh, e);
  return sum;
}

Vec3d centroid(const SolidMesh& mesh, std::size_t e) {
  Vec3d sum;
  for (const int v : element(mesh, e)) sum += mesh.vertices[std::size_t(v)];
  return sum / double(mesh.corners);
}

std::span<const std::array<int, 4>> element_faces(const SolidMesh& mesh) {
  if (mesh.corners == 8) return kHexFaces;
  return kTetFaces;
}

std::vector<int> face_neighbors(const SolidMesh& mesh) {
  const std::size_t count = element_faces(mesh).size();
  std::vector<int> neighbors(element_count(mesh) * count, -1);
  const std::vector<Face> faces = sorted_faces(mesh);
  for (std::size_t i = 1; i < faces.size(); i++) {
    const Face &a = faces[i - 1], &b = faces[i];
    if (!same_vertices(a, b)) continue;
    neighbors[std::size_t(a[kElement]) * count + std::size_t(a[kNumber])] = b[kElement];
    neighbors[std::size_t(b[kElement]) * count + std::size_t(b[kNumber])] = a[kElement];
  }
  return neighbors;
}

SolidSurface surface(const SolidMesh& mesh) {
  const auto table = element_faces(mesh);
  const std::vector<int> neighbors = face_neighbors(mesh);
  SolidSurface result;
  for (std::size_t e = 0; e < element_count(mesh); e++)
    for (std::size_t f = 0; f < table.size(); f++) {
      if (neighbors[e * table.size() + f] >= 0) continue;
      const auto vertex = [&](int node) { return element(mesh, e)[std::size_t(node)]; };
      for (const Int3 t : face_triangles(mesh, table[f])) {
        result.triangles.push_back({vertex(t.x), vertex(t.y), vertex(t.z)});
        result.element.push_back(int(e));
      }
    }
  return result;
}

std::vector<int> connected_components(const SolidMesh& mesh) {
  const std::size_t count = element_count(mesh);
  std::vector<int> parent(count);
  std::iota(parent.begin(), parent.end(), 0);
  const std::vector<int> neighbors = face_neighbors(mesh);
  const std::size_t faces = element_faces(mesh).size();
  for (std::size_t i = 0; i < neighbors.size(); i++)
    if (neighbors[i] >= 0) join_sets(parent, int(i / faces), neighbors[i]);
  // number the components by size; equal sizes by their first element
  std::vector<int> size(count, 0), roots;
  for (std::size_t e = 0; e < count; e++) size[std::size_t(root_of(parent, int(e)))]++;
  for (std::size_t e = 0; e < count; e++)
    if (size[e] > 0) roots.push_back(int(e));
  std::stable_sort(roots.begin(), roots.end(),
                   [&](int a, int b) { return size[std::size_t(a)] > size[std::size_t(b)]; });
  std::vector<int> number(count, -1), component(count);
  for (std::size_t i = 0; i < roots.size(); i++) number[std::size_t(roots[i])] = int(i);
  for (std::size_t e = 0; e < count; e++) component[e] = number[std::size_t(root_of(parent, int(e)))];
  return component;
}

}  // namespace turgor
