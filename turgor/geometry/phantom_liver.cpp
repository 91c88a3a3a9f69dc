#include "turgor/geometry/phantom_liver.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include "turgor/core/assert.hpp"

namespace turgor {

namespace {

/// Squares along the edges of a box, whose surface then has 2 (xy + yz + zx) + 2 = 3116 grid points.
constexpr Int3 kPaperCells{33, 21, 16};

/// Maps a grid point of a box's surface to the unit sphere, without crowding at corners and edges.
Vec3d on_sphere(Int3 p, Int3 cells) {
  Vec3d x;
  for (int axis = 0; axis < 3; axis++)
    x[axis] = std::tan(std::numbers::pi / 4 * (2.0 * p[axis] / cells[axis] - 1));
  return normalized(x);
}

/// Maps the unit sphere to the liver: a wedge, thick on the patient's right (−x), concave below.
Vec3 liver_position(Vec3d u) {
  const double right = 0.5 * (1 - u.x);  // 0 at the tip of the left lobe, 1 at the right end
  const double width = 0.45 + 0.55 * std::sqrt(right), thickness = 0.35 + 0.65 * right;
  Vec3d x{0.11 * u.x, 0.082 * u.y * width, (u.z > 0 ? 0.070 : 0.046) * u.z * thickness};
  x.y += 0.02 * u.x * u.x;  // both lobes bend to the back
  const double hollow = std::max(0.0, -u.z) * (1 - u.x * u.x) * (1 - u.y * u.y);
  const double furrow = std::max(0.0, u.z) * std::exp(-60 * (u.x - 0.3) * (u.x - 0.3));  // of the ligament
  x.z += 0.022 * hollow - 0.004 * furrow;
  return Vec3(x);
}

/// Grid points of a box's surface, and its squares split into triangles.
class BoxSurface {
 public:
  explicit BoxSurface(Int3 cells) : cells_(cells) {
    for (int axis = 0; axis < 3; axis++)
      for (const bool far : {false, true}) add_face(axis, far);
  }
  std::vector<Int3> points;
  std::vector<Int3> triangles;

 private:
  int vertex(Int3 p) {
    const auto [at, is_new] = numbers_.try_emplace({p.x, p.y, p.z}, int(points.size()));
    if (is_new) points.push_back(p);
    return at->second;
  }
  void add_face(int axis, bool far) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (int i = 0; i < cells_[u]; i++)
      for (int j = 0; j < cells_[v]; j++) {
        const auto at = [&](int di, int dj) {
          Int3 p;
          p[axis] = far ? cells_[axis] : 0, p[u] = i + di, p[v] = j + dj;
          return vertex(p);
        };
        const int a = at(0, 0), b = at(1, 0), c = at(1, 1), d = at(0, 1);
        // Both triangles of a square meet on the diagonal that points to the center of its face.
        if ((2 * i < cells_[u]) == (2 * j < cells_[v]))
          add(a, b, c, far), add(a, c, d, far);
        else
          add(a, b, d, far), add(b, c, d, far);
      }
  }
  void add(int a, int b, int c, bool outward) {
    triangles.push_back(outward ? Int3{a, b, c} : Int3{a, c, b});
  }
  Int3 cells_;
  std::map<std::array<int, 3>, int> numbers_;
};

}  // namespace

TriMesh phantom_liver(double detail) {
  TURGOR_ASSERT(detail > 0.1 && detail < 100, "detail is between 0.1 and 100");
  const auto cells = [detail](int paper) { return std::max(1, int(std::lround(paper * detail))); };
  const Int3 size{cells(kPaperCells.x), cells(kPaperCells.y), cells(kPaperCells.z)};
  BoxSurface box(size);
  TriMesh mesh{.triangles = std::move(box.triangles)};
  for (const Int3 p : box.points) mesh.vertices.push_back(liver_position(on_sphere(p, size)));
  return mesh;
}

}  // namespace turgor
