#include "turgor/sim/bodies/sfem/inner_parts.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "turgor/models/sfem/elements.hpp"

namespace turgor {

namespace {

/// The elements of one material, with the vertices of the whole.
SolidMesh elements_of(const SolidMesh& mesh, const std::vector<int>& material, int wanted) {
  SolidMesh part{mesh.vertices, mesh.corners, {}, {}};
  for (std::size_t e = 0; e < material.size(); e++)
    if (material[e] == wanted)
      part.elements.insert(part.elements.end(), element(mesh, e).begin(), element(mesh, e).end());
  return part;
}

InnerPart part_of(const std::string& name, const SolidMesh& mesh) {
  InnerPart part{.name = name, .vertices = {}, .triangles = surface(mesh).triangles, .center = {}};
  std::vector<int> place(mesh.vertices.size(), -1);
  for (const Int3 t : part.triangles)
    for (const int v : {t.x, t.y, t.z}) place[std::size_t(v)] = 0;
  for (std::size_t v = 0; v < place.size(); v++)
    if (place[v] == 0) place[v] = int(part.vertices.size()), part.vertices.push_back(int(v));
  for (Int3& t : part.triangles)
    for (int corner = 0; corner < 3; corner++) t[corner] = place[std::size_t(t[corner])];
  double whole = 0;
  for (std::size_t e = 0; e < element_count(mesh); e++) {
    const double one = volume(mesh, e);
    whole += one, part.center += centroid(mesh, e) * one;
  }
  if (whole > 0) part.center = part.center / whole;
  part.radius = std::cbrt(0.75 * whole / std::numbers::pi);
  return part;
}

}  // namespace

std::vector<InnerPart> inner_parts(const SfemScene& scene, const sfem::Body& body) {
  std::vector<std::string> names;  // as make_body numbers materials
  for (const InsideScene& inside : scene.inside) names.push_back(inside.name);
  for (const InclusionScene& inclusion : scene.inclusions) names.push_back(inclusion.name);
  if (names.empty()) return {};
  const std::vector<int> material = sfem::element_materials(body);
  std::vector<InnerPart> parts;
  for (std::size_t i = 0; i < names.size(); i++)
    if (SolidMesh mesh = elements_of(body.mesh, material, int(i) + 1); !mesh.elements.empty())
      parts.push_back(part_of(names[i], mesh));
  return parts;
}

}  // namespace turgor
