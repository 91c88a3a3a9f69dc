#include "turgor/sim/bodies/sfem/inner_regions.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "turgor/core/assert.hpp"
#include "turgor/models/sfem/elements.hpp"

namespace turgor {

namespace {

/// Elements of one material, with the vertices of the whole mesh.
SolidMesh elements_of(const SolidMesh& mesh, const std::vector<int>& material, int number) {
  TURGOR_CHECK(material.size() == element_count(mesh), "every element has a material");
  SolidMesh selected{mesh.vertices, mesh.corners, {}, {}};
  for (std::size_t e = 0; e < material.size(); e++)
    if (material[e] == number)
      selected.elements.insert(selected.elements.end(), element(mesh, e).begin(), element(mesh, e).end());
  return selected;
}

InnerRegion region_of(const std::string& name, int material, const SolidMesh& mesh) {
  InnerRegion region{
      .name = name, .material = material, .vertices = {}, .triangles = surface(mesh).triangles, .center = {}};
  // mark the vertices on the boundary
  std::vector<int> index_of(mesh.vertices.size(), -1);
  for (const Int3 t : region.triangles)
    for (const int v : {t.x, t.y, t.z}) index_of[std::size_t(v)] = 0;
  // number them and renumber the triangles
  for (std::size_t v = 0; v < index_of.size(); v++)
    if (index_of[v] == 0) index_of[v] = int(region.vertices.size()), region.vertices.push_back(int(v));
  for (Int3& t : region.triangles)
    for (int corner = 0; corner < 3; corner++) t[corner] = index_of[std::size_t(t[corner])];
  // centroid, and radius of a ball of equal volume
  double whole = 0;
  for (std::size_t e = 0; e < element_count(mesh); e++) {
    const double one = volume(mesh, e);
    whole += one, region.center += centroid(mesh, e) * one;
  }
  if (whole > 0) region.center = region.center / whole;
  region.radius = std::cbrt(0.75 * whole / std::numbers::pi);
  return region;
}

/// Names of materials in the order of make_body.
std::vector<std::string> region_names(const SfemScene& scene) {
  std::vector<std::string> names;
  for (const InsideScene& inside : scene.inside) names.push_back(inside.name);
  for (const InclusionScene& inclusion : scene.inclusions) names.push_back(inclusion.name);
  return names;
}

}  // namespace

std::vector<InnerRegion> named_regions(const SfemScene& scene) {
  std::vector<InnerRegion> regions;
  for (const std::string& name : region_names(scene)) regions.emplace_back().name = name;
  return regions;
}

std::vector<InnerRegion> inner_regions(const SfemScene& scene, const sfem::Body& body) {
  const std::vector<std::string> names = region_names(scene);
  if (names.empty()) return {};
  const std::vector<int> material = sfem::element_materials(body);
  std::vector<InnerRegion> regions;
  for (std::size_t i = 0; i < names.size(); i++)
    if (SolidMesh mesh = elements_of(body.mesh, material, int(i) + 1); !mesh.elements.empty())
      regions.push_back(region_of(names[i], int(i) + 1, mesh));
  return regions;
}

}  // namespace turgor
