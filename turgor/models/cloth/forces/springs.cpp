#include "turgor/models/cloth/forces/springs.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "turgor/core/assert.hpp"
#include "turgor/geometry/surface_edges.hpp"

namespace turgor::cloth {

namespace {

/// Stiffness per width at the angle θ to the warp [N/m]:
///
///   E = cos²2θ · (warp or weft) + sin²2θ · shear
///
/// with the warp's stiffness for cos 2θ > 0, else the weft's. [docs/models/cloth.md]
double stiffness_along(const Fabric& fabric, Vec3d edge, Vec3d normal) {
  const Vec3d warp = fabric.direction - normal * dot(fabric.direction, normal);
  if (!(norm(warp) > 1e-6 * norm(fabric.direction))) return fabric.warp;
  const double c = dot(normalized(edge), normalized(warp)), cos2 = 2 * c * c - 1;
  return cos2 * cos2 * (cos2 > 0 ? fabric.warp : fabric.weft) + (1 - cos2 * cos2) * fabric.shear;
}

struct Faces {
  const TriMesh& mesh;

  Vec3d at(int v) const { return Vec3d(mesh.vertices[std::size_t(v)]); }
  /// Normal with the length of twice the area [m²].
  Vec3d normal(int t) const {
    const auto [a, b, c] = mesh.triangles[std::size_t(t)];
    return cross(at(b) - at(a), at(c) - at(a));
  }
  int opposite(const EdgeUse& use) const {
    return mesh.triangles[std::size_t(use.triangle)][(use.side + 2) % 3];
  }
};

/// Spring with the energy ½ k (L − L₀)² and k = E (A₁ + A₂)/L², A the areas of the incident triangles. With
/// it, a strip of square or equilateral triangles has the stiffness of the fabric. [docs/models/cloth.md]
Spring make_spring(int a, int b, double length, double stiffness, double area) {
  TURGOR_CHECK(length > 0, "a spring has a length");
  return {std::min(a, b), std::max(a, b), Real(length), Real(stiffness * area / (length * length))};
}

void add_edge(const Faces& faces, const Fabric& fabric, std::span<const EdgeUse> uses,
              std::vector<Spring>& springs) {
  const auto [a, b] = std::pair(uses[0].a, uses[0].b);
  // area and normal of the incident triangles
  double area = 0;
  Vec3d normal;
  for (const EdgeUse& use : uses) {
    const Vec3d n = faces.normal(use.triangle);
    area += norm(n) / 2;
    normal += use.forward == uses[0].forward ? n : -n;
  }
  // spring along the edge
  const Vec3d edge = faces.at(b) - faces.at(a);
  springs.push_back(make_spring(a, b, norm(edge), stiffness_along(fabric, edge, normalized(normal)), area));
  // springs across the edge
  for (std::size_t m = 0; m < uses.size(); m++)
    for (std::size_t n = m + 1; n < uses.size(); n++) {
      const int p = faces.opposite(uses[m]), q = faces.opposite(uses[n]);
      const double length = norm(faces.at(p) - faces.at(q));
      const double areas =
          norm(faces.normal(uses[m].triangle)) / 2 + norm(faces.normal(uses[n].triangle)) / 2;
      if (p != q && length > 1e-3 * norm(edge) &&
          fabric.bend > 0)  // triangles folded onto each other have no fold angle to resist
        springs.push_back(make_spring(p, q, length, fabric.bend, areas));
    }
}

}  // namespace

void merge(std::vector<Spring>& springs) {
  std::stable_sort(springs.begin(), springs.end(),
                   [](const Spring& s, const Spring& t) { return std::tie(s.a, s.b) < std::tie(t.a, t.b); });
  std::size_t last = 0;
  for (std::size_t s = 1; s < springs.size(); s++)
    if (springs[s].a == springs[last].a && springs[s].b == springs[last].b)
      springs[last].stiffness += springs[s].stiffness, springs[last].bend += springs[s].bend;
    else
      springs[++last] = springs[s];
  springs.resize(springs.empty() ? 0 : last + 1);
}

std::vector<Spring> make_springs(const TriMesh& mesh, const Fabric& fabric) {
  const Faces faces{mesh};
  const std::vector<EdgeUse> uses = sorted_edges(mesh.triangles);
  std::vector<Spring> springs;
  for_each_edge(uses, [&](std::span<const EdgeUse> edge) { add_edge(faces, fabric, edge, springs); });
  merge(springs);
  TURGOR_CHECK(std::all_of(springs.begin(), springs.end(), [](const Spring& s) { return s.a < s.b; }),
               "a spring joins two vertices, the smaller first");
  return springs;
}

}  // namespace turgor::cloth
