#include "turgor/models/cloth/build/sheet.hpp"

#include "turgor/core/assert.hpp"

namespace turgor::cloth {

TriMesh make_sheet(const Sheet& sheet) {
  TURGOR_ASSERT(sheet.columns > 0 && sheet.rows > 0, "a sheet has at least one column and one row");
  // vertices
  TriMesh mesh;
  const int stride = sheet.columns + 1;
  for (int j = 0; j <= sheet.rows; j++)
    for (int i = 0; i <= sheet.columns; i++)
      mesh.vertices.push_back(Vec3(sheet.corner + sheet.side * (double(i) / sheet.columns) +
                                   sheet.up * (double(j) / sheet.rows)));
  // triangles
  for (int j = 0; j < sheet.rows; j++)
    for (int i = 0; i < sheet.columns; i++) {
      const int a = j * stride + i, b = a + 1, c = a + stride + 1, d = a + stride;
      mesh.triangles.push_back({a, b, c});
      mesh.triangles.push_back({a, c, d});
    }
  return mesh;
}

}  // namespace turgor::cloth
