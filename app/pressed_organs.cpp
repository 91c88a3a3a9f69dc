#include "app/pressed_organs.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "app/pressed_block.hpp"
#include "turgor/contact/touch.hpp"
#include "turgor/geometry/hex_block.hpp"
#include "turgor/geometry/organ_mesh.hpp"
#include "turgor/geometry/phantom.hpp"
#include "turgor/geometry/quadratic.hpp"
#include "turgor/models/sfem/expected_error.hpp"

namespace turgor {

namespace {

/// Approximate surface of a tongue: an ellipsoid that is thicker at one end.
TriMesh tongue_surface() {
  constexpr int kRows = 24, kColumns = 48;
  constexpr Vec3d kHalf{0.024, 0.030, 0.014};
  TriMesh surface;
  const auto add = [&](double polar, double around) {
    const Vec3d x{std::sin(polar) * std::cos(around), std::sin(polar) * std::sin(around), std::cos(polar)};
    surface.vertices.push_back(Vec3(hadamard(kHalf, {x.x, x.y, x.z * (1 + 0.25 * x.y)})));
  };
  constexpr double kPi = std::numbers::pi;
  add(0, 0);
  for (int row = 1; row < kRows; row++)
    for (int c = 0; c < kColumns; c++) add(kPi * row / kRows, 2 * kPi * c / kColumns);
  add(kPi, 0);
  const int last = int(surface.vertices.size()) - 1;
  const auto at = [&](int row, int c) { return 1 + (row - 1) * kColumns + c % kColumns; };
  for (int c = 0; c < kColumns; c++) {
    surface.triangles.push_back({0, at(1, c), at(1, c + 1)});
    surface.triangles.push_back({last, at(kRows - 1, c + 1), at(kRows - 1, c)});
    for (int row = 1; row + 1 < kRows; row++) {
      surface.triangles.push_back({at(row, c), at(row + 1, c), at(row + 1, c + 1)});
      surface.triangles.push_back({at(row, c), at(row + 1, c + 1), at(row, c + 1)});
    }
  }
  return surface;
}

sfem::Body held_organ(const PressedOrgan& organ, double poisson) {
  double low = INFINITY, high = -INFINITY;
  for (const Vec3d x : organ.mesh.vertices)
    low = std::min(low, dot(x, organ.down)), high = std::max(high, dot(x, organ.down));
  sfem::Body body = held(organ.mesh, {3e3, poisson},
                         [&](Vec3d x) { return dot(x, organ.down) > high - 0.3 * (high - low); });
  body.mesh.regions.clear();
  return body;
}

double press_along(const sfem::Patch& patch, const PressPoint& point, const PressedOrgan& organ) {
  contact::TouchState state = contact::make_touch_state(patch, 1, {.capacity = 512});
  const std::vector<contact::Tool> tools{{contact::Sphere{organ.radius}, 0.0}};
  std::vector<contact::ToolPose> poses(1);
  std::vector<contact::ToolForce> forces(1);
  for (int step = 1; step <= 12; step++) {
    const double depth = organ.depth * std::min(1.0, step / 10.0);
    poses[0].pose.position = point.x + point.normal * (organ.radius - depth);
    contact::solve_touch_tick(patch, state, tools, poses, 1e-3, forces);
  }
  return dot(forces[0].force, point.normal);
}

/// Patch at a press point. A patch without refinement needs only the surface elements.
sfem::Patch patch_on(const Exec& exec, sfem::Model& model, const PressPoint& point, double radius,
                     int refinement) {
  if (refinement > 1) return patch_at(exec, model, point.x, {radius, refinement});
  const std::vector<Vec3d> touches{point.x};
  const std::vector<int>& outer = model.surface.element;
  std::vector<int> elements = sfem::patch_elements(model, touches, radius), vertices;
  std::erase_if(elements, [&](int e) { return std::find(outer.begin(), outer.end(), e) == outer.end(); });
  for (const int e : elements)
    for (const int v : element(model.body.mesh, std::size_t(e))) vertices.push_back(v);
  sfem::fetch_columns(exec, model, vertices);
  return sfem::build_patch(model, elements, refinement, touches).value();
}

}  // namespace

Result<PressedOrgan> pressed_tongue(const Exec& exec, double edge) {
  Result<OrganMesh> made = mesh_of_surface(exec, tongue_surface(), edge);
  if (!made) return made.error();
  return PressedOrgan{"tongue", std::move(made->mesh), {0, 0, -1}, 0.010, 0.003, 0.014};
}

Result<PressedOrgan> pressed_liver(const Exec& exec, double edge) {
  LabelVolume labels;
  make_phantom(exec, {.size = {192, 192, 112}, .spacing = {2.1e-3, 2.1e-3, 2.7e-3}}, &labels);
  Result<OrganMesh> made = mesh_of_labels(exec, labels, std::vector<int>{5, kNoduleLabel}, edge);
  if (!made) return made.error();
  return PressedOrgan{"liver", std::move(made->mesh), {0, 1, 0}, 0.020, 0.004, 0.024};
}

PressedOrgan pressed_tet_block(double cell) {
  const int n = int(std::lround(0.08 / cell));
  return {"block", tetrahedralize(hex_block({0.08, 0.08, 0.04}, {n, n, n / 2})), {0, 0, -1}, 0.010, 0.003,
          0.014};
}

std::vector<PressPoint> press_points(const PressedOrgan& organ) {
  const SolidSurface outer = surface(organ.mesh);
  Vec3d middle, extent;
  for (const Vec3d x : organ.mesh.vertices) middle += x / double(organ.mesh.vertices.size());
  for (const Vec3d x : organ.mesh.vertices)
    for (int axis = 0; axis < 3; axis++)
      extent[axis] = std::max(extent[axis], std::abs(x[axis] - middle[axis]));
  std::vector<PressPoint> points;
  for (const Vec3d fraction : {Vec3d{0, 0, 0}, Vec3d{0.35, 0.2, 0.25}, Vec3d{-0.3, 0.3, -0.2}}) {
    Vec3d above = middle + hadamard(fraction, extent);
    above += organ.down * dot(middle - above, organ.down);
    PressPoint best{{}, {}};
    double nearest = INFINITY;
    for (const Int3 t : outer.triangles) {
      const auto x = [&](int v) { return organ.mesh.vertices[std::size_t(v)]; };
      const Vec3d normal = normalized(cross(x(t.y) - x(t.x), x(t.z) - x(t.x))),
                  m = (x(t.x) + x(t.y) + x(t.z)) / 3;
      const Vec3d off = m - above, aside = off - organ.down * dot(off, organ.down);
      if (dot(normal, organ.down) < -0.5 && norm(aside) < nearest) nearest = norm(aside), best = {m, normal};
    }
    points.push_back(best);
  }
  return points;
}

double press_flops(const PressedOrgan& organ, const ElementChoice& choice) {
  constexpr double kRest = 2e10;        // columns, contact, factorization of the body
  constexpr double kTetsPerNode = 5.5;  // of a mesh of linear tetrahedra
  const int subdivisions = choice.refinement * (choice.cut_all ? 2 : 1) * (choice.quadratic ? 2 : 1);
  double flops = kRest;
  for (const PressPoint& point : press_points(organ)) {
    double within = 0;
    for (std::size_t e = 0; e < element_count(organ.mesh); e++)
      within += norm(centroid(organ.mesh, e) - point.x) < choice.reach * organ.patch ? 1 : 0;
    const double unknowns = choice.refinement > 1 ? 3 * within * std::pow(subdivisions, 3) / kTetsPerNode : 0;
    flops += std::pow(unknowns, 3) / 3;
  }
  return flops;
}

Result<OrganForces> press_organ(const Exec& exec, const PressedOrgan& organ, const ElementChoice& choice,
                                double poisson) {
  sfem::Body body = held_organ(organ, poisson);
  if (choice.cut_all) body = sfem::with_middles(std::move(body)), body.mesh = linear_subdivision(body.mesh);
  if (choice.quadratic) body = sfem::with_middles(std::move(body));
  const sfem::Params params{.formulation = choice.formulation, .touch_depth = 2 * organ.patch};
  Result<sfem::Model> model = solved(exec, std::move(body), params, true);
  if (!model) return model.error();
  OrganForces found{{}, 0, int(model->vertex.size()), sfem::green_cost(*model)};
  for (const PressPoint& point : press_points(organ)) {
    const double radius = choice.reach * organ.patch;
    const sfem::Patch patch = patch_on(exec, *model, point, radius, choice.refinement);
    found.force.push_back(press_along(patch, point, organ));
    found.expected_error = std::max(
        found.expected_error, sfem::expected_error({.corners = model->body.mesh.corners,
                                                    .formulation = choice.formulation,
                                                    .poisson = poisson,
                                                    .edge = sfem::mean_edge(model->body.mesh, patch.elements),
                                                    .refinement = choice.refinement,
                                                    .patch = radius,
                                                    .contact = std::sqrt(organ.radius * organ.depth)}));
  }
  return found;
}

}  // namespace turgor
