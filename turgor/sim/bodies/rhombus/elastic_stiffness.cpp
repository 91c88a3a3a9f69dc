#include "turgor/sim/bodies/rhombus/elastic_stiffness.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/models/rhombus/half_space.hpp"
#include "turgor/models/sfem/green.hpp"

namespace turgor {

namespace {

constexpr double kReach = 2;       // edges, of the pressure
constexpr double kMostStiff = 50;  // where the body is held [1]

/// A third of its triangles' areas at each vertex [m²].
std::vector<double> vertex_areas(const rhombus::Surface& s) {
  std::vector<double> area(s.vertices.size());
  for (std::size_t t = 0; t < s.triangles.size(); t++) {
    const auto x = [&](int corner) { return rhombus::corner_place(s, int(t), corner); };
    const double third = norm(cross(x(1) - x(0), x(2) - x(0))) / 6;
    for (int corner = 0; corner < 3; corner++) area[std::size_t(s.triangles[t][corner])] += third;
  }
  return area;
}

/// Vertices of a surface under a pressure around one of them, and the shares of the force that they bear.
struct Load {
  std::vector<int> vertices;  // of the solid
  std::vector<double> shares;
};

Load load_around(const rhombus::Surface& s, const SurfacePart& part, const std::vector<double>& area,
                 std::size_t middle, double radius) {
  Load load;
  double sum = 0;
  for (std::size_t v = 0; v < s.vertices.size(); v++) {
    const Vec3d away = s.vertices[v] - s.vertices[middle];
    const double inside = 1 - dot(away, away) / (radius * radius);
    if (!(inside > 0) || dot(s.normals[v], s.normals[middle]) <= 0) continue;
    load.vertices.push_back(part.vertices[v]);
    load.shares.push_back(area[v] * std::sqrt(inside));
    sum += load.shares.back();
  }
  for (double& share : load.shares) share /= sum;
  return load;
}

/// Mean way along the normal that a unit force makes there [m/N].
double compliance(const sfem::Model& model, const Load& load, Vec3d normal) {
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

SurfacePart surface_part(const sfem::Model& model) {
  SurfacePart part;
  std::vector<int> number(model.body.mesh.vertices.size(), -1);
  for (Int3 t : model.surface.triangles) {
    for (int corner = 0; corner < 3; corner++) {
      const int v = t[corner];
      int& n = number[std::size_t(v)];
      if (n < 0) {
        n = int(part.vertices.size());
        part.vertices.push_back(v);
        part.body.vertices.push_back(model.body.mesh.vertices[std::size_t(v)]);
      }
      t[corner] = n;
    }
    part.body.triangles.push_back(t);
  }
  return part;
}

Result<std::vector<double>> elastic_stiffness(const Exec& exec, const sfem::Model& model,
                                              const SurfacePart& part, const rhombus::Surface& surface,
                                              double disc) {
  if (model.green.single_values.empty() && model.green.double_values.empty())
    return Error{
        "Green's functions of the whole surface are needed, found columns on demand: a coarser "
        "resolution has them"};
  const double radius = std::max(kReach * surface.mean_edge, disc);
  const sfem::Material& material = model.body.materials[0];
  const double modulus = rhombus::contact_modulus(material.young, material.poisson);
  // Under Hertz's pressure P the mean way of a half space, weighted by the pressure, is 0.6 P / (E* r).
  const double hertz = 0.6 / (modulus * radius), touched = 1 / rhombus::disc_stiffness(modulus, disc);
  const std::vector<double> area = vertex_areas(surface);
  std::vector<double> stiffness(surface.vertices.size());
  parallel_for(
      exec, stiffness.size(),
      [&](std::size_t v) {
        stiffness[v] = kMostStiff;
        if (model.free_node[std::size_t(part.vertices[v])] < 0) return;  // held
        const Load load = load_around(surface, part, area, v, radius);
        const double way = touched + compliance(model, load, surface.normals[v]) - hertz;
        if (way > 0) stiffness[v] = std::clamp(touched / way, 1 / kMostStiff, kMostStiff);
      },
      8);
  return stiffness;
}

}  // namespace turgor
