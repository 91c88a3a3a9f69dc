#include "turgor/geometry/hex_block.hpp"

#include <array>

namespace turgor {

namespace {

std::vector<double> equal_intervals(double length, int count) {
  std::vector<double> planes;
  for (int i = 0; i <= count; i++) planes.push_back(length * i / count);
  return planes;
}

}  // namespace

SolidMesh hex_block(std::span<const double> x, std::span<const double> y, std::span<const double> z) {
  SolidMesh mesh;
  mesh.corners = 8;
  for (const double c : z)
    for (const double b : y)
      for (const double a : x) mesh.vertices.push_back({a, b, c});
  const int nx = int(x.size()), ny = int(y.size()), nz = int(z.size());
  const auto vertex = [&](int i, int j, int k) { return (k * ny + j) * nx + i; };
  for (int k = 0; k + 1 < nz; k++)
    for (int j = 0; j + 1 < ny; j++)
      for (int i = 0; i + 1 < nx; i++)
        for (const Int3 c :
             {Int3{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}})
          mesh.elements.push_back(vertex(i + c.x, j + c.y, k + c.z));
  return mesh;
}

SolidMesh hex_block(Vec3d size, Int3 count) {
  return hex_block(equal_intervals(size.x, count.x), equal_intervals(size.y, count.y),
                   equal_intervals(size.z, count.z));
}

SolidMesh tetrahedralize(const SolidMesh& hexahedra) {
  static constexpr std::array<std::array<int, 4>, 6> kTets{
      {{0, 1, 2, 6}, {0, 2, 3, 6}, {0, 3, 7, 6}, {0, 7, 4, 6}, {0, 4, 5, 6}, {0, 5, 1, 6}}};
  SolidMesh mesh;
  mesh.vertices = hexahedra.vertices;
  for (std::size_t e = 0; e < element_count(hexahedra); e++)
    for (const auto& tet : kTets) {
      for (const int c : tet) mesh.elements.push_back(element(hexahedra, e)[std::size_t(c)]);
      if (!hexahedra.regions.empty()) mesh.regions.push_back(hexahedra.regions[e]);
    }
  return mesh;
}

}  // namespace turgor
