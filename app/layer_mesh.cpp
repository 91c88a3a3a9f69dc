#include "app/layer_mesh.hpp"

#include <cmath>
#include <numbers>

namespace turgor {

namespace {

/// Number of node k on circle i; circle 0 is the center.
int node_on(int i, int k) { return i == 0 ? 0 : 1 + 3 * i * (i - 1) + (k + 6 * i) % (6 * i); }

/// Triangles between the circles, counter-clockwise: in each of six sectors, circle i has i edges.
std::vector<Int3> round_triangles(int circles) {
  std::vector<Int3> triangles;
  for (int i = 1; i <= circles; i++)
    for (int sector = 0; sector < 6; sector++)
      for (int k = 0; k < i; k++) {
        const int outer = sector * i + k, inner = sector * (i - 1) + k;
        triangles.push_back({node_on(i, outer), node_on(i, outer + 1), node_on(i - 1, inner)});
        if (k + 1 < i)
          triangles.push_back({node_on(i - 1, inner), node_on(i, outer + 1), node_on(i - 1, inner + 1)});
      }
  return triangles;
}

/// Splits a prism over a triangle into three tetrahedra. The diagonal of every side starts at its lower
/// corner with the lower number, so that neighbors agree.
void add_prism(Int3 t, int below, int above, std::vector<int>& elements) {
  while (t.x > t.y || t.x > t.z) t = {t.y, t.z, t.x};  // starts with its lowest corner
  const auto [a, b, c] = t;
  if (b < c)
    for (const int v : {below + a, below + b, below + c, above + c, below + a, below + b, above + c,
                        above + b, below + a, above + b, above + c, above + a})
      elements.push_back(v);
  else
    for (const int v : {below + a, below + b, below + c, above + b, below + a, above + b, below + c,
                        above + c, below + a, above + b, above + c, above + a})
      elements.push_back(v);
}

}  // namespace

SolidMesh round_layer(std::span<const double> radii, std::span<const double> heights) {
  const int circles = int(radii.size());
  SolidMesh mesh;
  for (const double z : heights) {
    mesh.vertices.push_back({0, 0, z});
    for (int i = 1; i <= circles; i++)
      for (int k = 0; k < 6 * i; k++) {
        const double angle = 2 * std::numbers::pi * k / (6 * i);
        mesh.vertices.push_back(
            {radii[std::size_t(i - 1)] * std::cos(angle), radii[std::size_t(i - 1)] * std::sin(angle), z});
      }
  }
  const int in_plane = node_on(circles, 0) + 6 * circles;
  for (std::size_t layer = 0; layer + 1 < heights.size(); layer++)
    for (const Int3 t : round_triangles(circles))
      add_prism(t, int(layer) * in_plane, int(layer + 1) * in_plane, mesh.elements);
  return mesh;
}

}  // namespace turgor
