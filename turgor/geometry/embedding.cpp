#include "turgor/geometry/embedding.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "turgor/core/assert.hpp"
#include "turgor/geometry/element_coordinates.hpp"
#include "turgor/geometry/triangle_tree.hpp"

namespace turgor {

namespace {

using Weights = std::array<double, 8>;

std::array<Vec3d, 8> corners_of(const SolidMesh& mesh, int e) {
  std::array<Vec3d, 8> x{};
  const auto corners = element(mesh, std::size_t(e));
  for (std::size_t c = 0; c < corners.size(); c++) x[c] = mesh.vertices[std::size_t(corners[c])];
  return x;
}

Weights weights_in(const SolidMesh& mesh, int e, Vec3d p) {
  const std::array<Vec3d, 8> x = corners_of(mesh, e);
  Weights weight{};
  if (mesh.corners == 4) {
    const std::array<double, 4> linear = tet_coordinates(std::span(x).first<4>(), p);
    std::copy(linear.begin(), linear.end(), weight.begin());
  } else {
    std::array<Vec3d, 8> gradient{};
    trilinear(hex_coordinates(x, p), weight, gradient);
  }
  return weight;
}

BoxTree element_boxes(const SolidMesh& mesh) {
  std::vector<Box> boxes;
  for (std::size_t e = 0; e < element_count(mesh); e++) {
    const std::array<Vec3d, 8> x = corners_of(mesh, int(e));
    boxes.push_back(box_around(std::span(x).first(std::size_t(mesh.corners))));
  }
  return build_box_tree(boxes);
}

/// Lowest element that contains a point, within rounding error; -1 = none.
int element_at(const SolidMesh& mesh, const BoxTree& boxes, Vec3d p) {
  int found = -1;
  visit_meeting(boxes, {p, p}, [&](int e) {
    if (found >= 0 && e > found) return false;
    const Weights w = weights_in(mesh, e, p);
    if (std::all_of(w.begin(), w.begin() + mesh.corners, [](double v) { return v >= -1e-9; })) found = e;
    return false;
  });
  return found;
}

}  // namespace

Embedding embed(const Exec& exec, const TriMesh& fine, const SolidMesh& mesh) {
  TURGOR_ASSERT(element_count(mesh) > 0, "a surface is embedded in elements");
  const SolidSurface outer = surface(mesh);
  const TriangleTree tree = build_triangle_tree(mesh.vertices, outer.triangles);
  const BoxTree boxes = element_boxes(mesh);
  const std::size_t corners = std::size_t(mesh.corners), count = fine.vertices.size();
  Embedding result{fine.vertices, mesh.corners, std::vector<int>(count * corners),
                   std::vector<float>(count * corners), 0};
  std::vector<double> outside(count, 0);
  parallel_for(
      exec, count,
      [&](std::size_t v) {
        const Vec3d p(fine.vertices[v]);
        // containing element, else the one behind the nearest surface point
        int e = element_at(mesh, boxes, p);
        if (e < 0) {
          const TrianglePoint nearest = nearest_point(tree, p);
          e = outer.element[std::size_t(nearest.triangle)];
          outside[v] = nearest.distance;
        }
        // weights of its corners
        const Weights w = weights_in(mesh, e, p);
        for (std::size_t c = 0; c < corners; c++) {
          result.nodes[v * corners + c] = element(mesh, std::size_t(e))[c];
          result.weights[v * corners + c] = float(w[c]);
        }
      },
      64);
  for (const double d : outside) result.farthest_outside = std::max(result.farthest_outside, d);
  return result;
}

void move(const Embedding& embedding, std::span<const Vec3d> displacements, std::span<Vec3> vertices) {
  TURGOR_ASSERT(vertices.size() == embedding.rest.size(), "one position per vertex of the surface");
  const std::size_t corners = std::size_t(embedding.corners);
  for (std::size_t v = 0; v < vertices.size(); v++) {
    Vec3d u;
    for (std::size_t c = v * corners; c < (v + 1) * corners; c++)
      u += displacements[std::size_t(embedding.nodes[c])] * double(embedding.weights[c]);
    vertices[v] = Vec3(Vec3d(embedding.rest[v]) + u);
  }
}

}  // namespace turgor
