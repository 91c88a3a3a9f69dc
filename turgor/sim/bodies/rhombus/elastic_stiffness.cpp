#include "turgor/sim/bodies/rhombus/elastic_stiffness.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/models/rhombus/half_space.hpp"
#include "turgor/models/sfem/green.hpp"

namespace turgor {

namespace {

constexpr double kReach = 2;       // radius of the pressure, in edges
constexpr double kMostStiff = 50;  // limit at fixed vertices [1]

/// Third of the adjacent triangle areas at each vertex [m²].
std::vector<double> vertex_areas(const rhombus::Surface& s) {
  std::vector<double> area(s.vertices.size());
  for (std::size_t t = 0; t < s.triangles.size(); t++) {
    const auto x = [&](int corner) { return rhombus::corner_position(s, int(t), corner); };
    const double third = norm(cross(x(1) - x(0), x(2) - x(0))) / 6;
    for (int corner = 0; corner < 3; corner++) area[std::size_t(s.triangles[t][corner])] += third;
  }
  return area;
}

/// Vertices under a pressure distribution, and their fractions of the force.
struct Load {
  std::vector<int> vertices;  // indices in the solid
  std::vector<double> shares;
};

Load load_around(const rhombus::Surface& s, const SolidBoundary& boundary, const std::vector<double>& area,
                 std::size_t middle, double radius) {
  Load load;
  double sum = 0;
  for (std::size_t v = 0; v < s.vertices.size(); v++) {
    const Vec3d away = s.vertices[v] - s.vertices[middle];
    const double inside = 1 - dot(away, away) / (radius * radius);
    if (!(inside > 0) || dot(s.normals[v], s.normals[middle]) <= 0) continue;
    load.vertices.push_back(boundary.vertices[v]);
    load.shares.push_back(area[v] * std::sqrt(inside));
    sum += load.shares.back();
  }
  TURGOR_CHECK(sum > 0, "pressure acts on an area");
  for (double& share : load.shares) share /= sum;
  return load;
}

/// Mean displacement along the normal per unit force [m/N].
double compliance(const sfem::Model& model, const Load& load, Vec3d normal) {
  TURGOR_CHECK(load.vertices.size() == load.shares.size() && is_unit(normal),
               "a load has shares and a direction");
  const std::size_t n = load.vertices.size();
  std::vector<double> green(9 * n * n);
  sfem::gather_green(model, load.vertices, green.data());
  double sum = 0;
  for (std::size_t b = 0; b < n; b++)
    for (std::size_t a = 0; a < n; a++)
      for (std::size_t i = 0; i < 9; i++)
        sum += load.shares[a] * load.shares[b] * normal[int(i / 3)] * normal[int(i % 3)] *
               green[(3 * b + i / 3) * 3 * n + 3 * a + i % 3];
  return sum;
}

}  // namespace

SolidBoundary solid_boundary(const sfem::Model& model) {
  SolidBoundary boundary;
  std::vector<int> number(model.body.mesh.vertices.size(), -1);
  for (Int3 t : model.surface.triangles) {
    for (int corner = 0; corner < 3; corner++) {
      const int v = t[corner];
      int& n = number[std::size_t(v)];
      // number the vertex at its first use
      if (n < 0) {
        n = int(boundary.vertices.size());
        boundary.vertices.push_back(v);
        boundary.body.vertices.push_back(model.body.mesh.vertices[std::size_t(v)]);
      }
      // renumber the triangle
      t[corner] = n;
    }
    boundary.body.triangles.push_back(t);
  }
  return boundary;
}

Result<std::vector<double>> elastic_stiffness(const Exec& exec, const sfem::Model& model,
                                              const SolidBoundary& boundary, const rhombus::Surface& surface,
                                              double disc) {
  if (model.green.single_values.empty() && model.green.double_values.empty())
    return Error{
        "expected Green's functions of the whole surface, found columns on demand: use a coarser "
        "resolution"};
  TURGOR_CHECK(boundary.vertices.size() == surface.vertices.size() && disc > 0,
               "the surface is that of the solid, and the disc has a radius");
  const double radius = std::max(kReach * surface.mean_edge, disc);
  const sfem::Material& material = model.body.materials[0];
  const double modulus = rhombus::contact_modulus(material.young, material.poisson);
  // mean displacement of a half space under Hertz's pressure P, weighted by the pressure: 0.6 P / (E* r)
  const double hertz_compliance = 0.6 / (modulus * radius),
               disc_compliance = 1 / rhombus::disc_stiffness(modulus, disc);
  const std::vector<double> area = vertex_areas(surface);
  std::vector<double> stiffness(surface.vertices.size());
  parallel_for(
      exec, stiffness.size(),
      [&](std::size_t v) {
        stiffness[v] = kMostStiff;
        if (model.free_node[std::size_t(boundary.vertices[v])] < 0) return;  // fixed
        const Load load = load_around(surface, boundary, area, v, radius);
        const double displacement =
            disc_compliance + compliance(model, load, surface.normals[v]) - hertz_compliance;
        if (displacement > 0)
          stiffness[v] = std::clamp(disc_compliance / displacement, 1 / kMostStiff, kMostStiff);
      },
      8);
  return stiffness;
}

}  // namespace turgor
