// A thin layer on bone, such as cartilage or skin: a flat punch and a sphere against Hayes's integral
// equation.
#include <Eigen/Cholesky>
#include <cmath>

#include "app/hayes.hpp"
#include "app/layer_mesh.hpp"
#include "app/pressed_block.hpp"
#include "app/validate_sfem.hpp"
#include "turgor/core/sort_unique.hpp"

namespace turgor {

namespace {

constexpr double kThickness = 0.01, kYoung = 3e3;  // [m] [Pa]

/// Radii of circles that become denser towards `radius`, the edge of a punch, and then wider.
std::vector<double> circles(double radius) {
  constexpr int kInside = 4;
  constexpr double kCloser = 0.55, kWider = 1.5;
  std::vector<double> radii;
  double step = radius * (1 - kCloser) / (1 - std::pow(kCloser, kInside));
  for (double r = 0; int(radii.size()) < kInside; step *= kCloser) radii.push_back(r += step);
  radii.back() = radius, step /= kCloser;
  while (radii.back() < radius + 3 * kThickness) radii.push_back(radii.back() + step), step *= kWider;
  return radii;
}

/// Heights of the planes from the base to the surface at 0, densest at the surface.
std::vector<double> planes() {
  constexpr int kLayers = 4;
  std::vector<double> heights;
  for (int i = kLayers; i >= 0; i--) heights.push_back(-kThickness * i * i / (kLayers * kLayers));
  return heights;
}

/// Elements below the circle of this radius.
std::vector<int> elements_below(const sfem::Model& model, double radius) {
  std::vector<int> elements;
  for (std::size_t t = 0; t < model.surface.triangles.size(); t++) {
    const auto is_within = [&](int v) {
      const Vec3d x = model.body.mesh.vertices[std::size_t(v)];
      return x.z > -1e-9 && std::hypot(x.x, x.y) <= radius * (1 + 1e-9);
    };
    const Int3 corners = model.surface.triangles[t];
    if (is_within(corners.x) && is_within(corners.y) && is_within(corners.z))
      elements.push_back(model.surface.element[t]);
  }
  sort_unique(elements);
  return elements;
}

Result<sfem::Patch> layer_patch(const Exec& exec, double radius, double poisson) {
  const auto is_base = [](Vec3d x) { return x.z < -kThickness + 1e-9; };
  sfem::Body body = held(round_layer(circles(radius), planes()), {kYoung, poisson}, is_base);
  Result<sfem::Model> model = solved(exec, sfem::with_middles(std::move(body)), {}, true);
  if (!model) return model.error();
  const std::vector<int> elements = elements_below(*model, radius);
  std::vector<int> vertices;
  for (const int e : elements)
    for (const int v : element(model->body.mesh, std::size_t(e))) vertices.push_back(v);
  sfem::fetch_columns(exec, *model, vertices);
  return sfem::build_patch(*model, elements, 1);
}

/// Force that moves all points of a patch down by `depth`, without friction.
double punch_force(const sfem::Patch& patch, double depth) {
  const auto n = Eigen::Index(patch.points.size());
  Eigen::MatrixXd compliance(n, n);
  for (Eigen::Index j = 0; j < n; j++)
    for (Eigen::Index i = 0; i < n; i++)
      compliance(i, j) = patch.compliance[std::size_t((3 * j + 2) * 3 * n + 3 * i + 2)];
  return compliance.llt().solve(Eigen::VectorXd::Constant(n, depth)).sum();
}

}  // namespace

Result<std::vector<LayerRow>> validate_layer(const Exec& exec, bool quick, const Progress& progress) {
  std::vector<LayerRow> rows;
  const std::vector<double> ratios = quick ? std::vector<double>{1} : std::vector<double>{0.5, 1, 2};
  for (const double ratio : ratios)
    for (const double poisson : {0.3, 0.45}) {
      const BondedLayer layer{kThickness, {kYoung, poisson}};
      const double radius = ratio * kThickness, depth = 0.01 * kThickness;
      const Result<sfem::Patch> patch = layer_patch(exec, radius, poisson);
      if (!patch) return patch.error();
      const int points = int(patch->points.size());
      rows.push_back({"flat punch", ratio, poisson, points, hayes_punch(layer, radius, depth).force,
                      punch_force(*patch, depth)});
      // A sphere so large that its contact is flat, as the equation assumes; where the layer is displaced
      // sideways, a slope of 6 % changes the force by 3 %. The contact is slightly smaller than the patch.
      const double contact = 0.9 * radius, sphere = 60 * radius;
      const Indentation expected = hayes_sphere(layer, sphere, contact);
      rows.push_back({"sphere", 0.9 * ratio, poisson, points, expected.force,
                      press(*patch, {}, sphere, expected.depth, 4).back().second});
      if (progress) progress(double(rows.size()) / double(4 * ratios.size()));
    }
  return rows;
}

}  // namespace turgor
