// Kinds of elements on organs' meshes, as a fingertip feels them and as they cost: which is near the
// converged force for the least computing beforehand?
#include <algorithm>
#include <cmath>
#include <numbers>

#include "app/pressed_block.hpp"
#include "app/validate_sfem.hpp"
#include "turgor/contact/touch.hpp"
#include "turgor/geometry/organ_mesh.hpp"
#include "turgor/geometry/phantom.hpp"
#include "turgor/geometry/quadratic.hpp"

namespace turgor {

namespace {

/// An organ's mesh, which way it is held, and the ball that presses it.
struct Organ {
  const char* name;
  SolidMesh mesh;
  Vec3d down;                               // to what holds it
  double radius = 0, depth = 0, patch = 0;  // of the ball, of its press, of the patch [m]
  std::vector<double> ratios;               // Poisson's
};

/// About a tongue: an ellipsoid that is thicker at one end.
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

Result<std::vector<Organ>> organs(const Exec& exec, bool quick) {
  std::vector<Organ> all;
  Result<OrganMesh> tongue = mesh_of_surface(exec, tongue_surface(), 0.009);
  if (!tongue) return tongue.error();
  all.push_back({"tongue, 9 mm", std::move(tongue->mesh), {0, 0, -1}, 0.010, 0.003, 0.014, {0.45}});
  if (quick) return all;
  all[0].ratios = {0.3, 0.45, 0.49};
  LabelVolume labels;
  make_phantom(exec, {.size = {192, 192, 112}, .spacing = {2.1e-3, 2.1e-3, 2.7e-3}}, &labels);
  Result<OrganMesh> liver = mesh_of_labels(exec, labels, std::vector<int>{5, kNoduleLabel}, 0.022);
  if (!liver) return liver.error();
  all.push_back({"liver, 22 mm", std::move(liver->mesh), {0, 1, 0}, 0.020, 0.004, 0.030, {0.45}});
  return all;
}

sfem::Body held_organ(const Organ& organ, double poisson) {
  double low = INFINITY, high = -INFINITY;
  for (const Vec3d x : organ.mesh.vertices)
    low = std::min(low, dot(x, organ.down)), high = std::max(high, dot(x, organ.down));
  sfem::Body body = held(organ.mesh, {3e3, poisson},
                         [&](Vec3d x) { return dot(x, organ.down) > high - 0.3 * (high - low); });
  body.mesh.regions.clear();
  return body;
}

/// Where a ball comes down on it: the middles of the triangles that lie highest above three places.
struct Place {
  Vec3d x, normal;
};
std::vector<Place> places_on(const Organ& organ) {
  const SolidSurface outer = surface(organ.mesh);
  Vec3d middle, extent;
  for (const Vec3d x : organ.mesh.vertices) middle += x / double(organ.mesh.vertices.size());
  for (const Vec3d x : organ.mesh.vertices)
    for (int axis = 0; axis < 3; axis++)
      extent[axis] = std::max(extent[axis], std::abs(x[axis] - middle[axis]));
  std::vector<Place> places;
  for (const Vec3d part : {Vec3d{0, 0, 0}, Vec3d{0.35, 0.2, 0.25}, Vec3d{-0.3, 0.3, -0.2}}) {
    Vec3d above = middle + hadamard(part, extent);
    above += organ.down * dot(middle - above, organ.down);
    Place best{{}, {}};
    double nearest = INFINITY;
    for (const Int3 t : outer.triangles) {
      const auto x = [&](int v) { return organ.mesh.vertices[std::size_t(v)]; };
      const Vec3d normal = normalized(cross(x(t.y) - x(t.x), x(t.z) - x(t.x))),
                  m = (x(t.x) + x(t.y) + x(t.z)) / 3;
      const Vec3d off = m - above, aside = off - organ.down * dot(off, organ.down);
      if (dot(normal, organ.down) < -0.5 && norm(aside) < nearest) nearest = norm(aside), best = {m, normal};
    }
    places.push_back(best);
  }
  return places;
}

double press_along(const sfem::Patch& patch, const Place& place, const Organ& organ) {
  contact::TouchState state = contact::make_touch_state(patch, 1, {.capacity = 400});
  const std::vector<contact::Tool> tools{{contact::Sphere{organ.radius}, 0.0}};
  std::vector<contact::ToolPose> poses(1);
  std::vector<contact::ToolForce> forces(1);
  for (int step = 1; step <= 12; step++) {
    const double depth = organ.depth * std::min(1.0, step / 10.0);
    poses[0].pose.position = place.x + place.normal * (organ.radius - depth);
    contact::touch(patch, state, tools, poses, 1e-3, forces);
  }
  return dot(forces[0].force, place.normal);
}

struct Kind {
  const char* name;
  bool cut;  // every tetrahedron in eight, all over
  bool quadratic;
  sfem::Formulation formulation;
  int refinement;  // of the patch
};
constexpr Kind kKinds[] = {
    {"standard, patch r = 2", false, false, sfem::Formulation::kStandard, 2},
    {"averaged, patch r = 2", false, false, sfem::Formulation::kAveraged, 2},
    {"averaged, cut in eight, patch r = 2", true, false, sfem::Formulation::kAveraged, 2},
    {"quadratic, no patch", false, true, sfem::Formulation::kStandard, 1},
    {"quadratic, patch r = 2", false, true, sfem::Formulation::kStandard, 2},
    {"quadratic, cut in eight", true, true, sfem::Formulation::kStandard, 1}};

/// The patch at a place. One that is no finer than the body needs the elements of the surface alone.
sfem::Patch patch_on(const Exec& exec, sfem::Model& model, const Place& place, double radius,
                     int refinement) {
  if (refinement > 1) return patch_at(exec, model, place.x, {radius, refinement});
  const std::vector<Vec3d> touches{place.x};
  const std::vector<int>& outer = model.surface.element;
  std::vector<int> elements = sfem::patch_elements(model, touches, radius), vertices;
  std::erase_if(elements, [&](int e) { return std::find(outer.begin(), outer.end(), e) == outer.end(); });
  for (const int e : elements)
    for (const int v : element(model.body.mesh, std::size_t(e))) vertices.push_back(v);
  sfem::fetch_columns(exec, model, vertices);
  return sfem::build_patch(model, elements, refinement, touches).value();
}

/// What it costs, and the force at every place.
Result<std::vector<double>> forces_of(const Exec& exec, const Organ& organ, const Kind& kind, double poisson,
                                      ElementsRow& row) {
  sfem::Body body = held_organ(organ, poisson);
  if (kind.cut) body = sfem::with_middles(std::move(body)), body.mesh = linear_parts(body.mesh);
  if (kind.quadratic) body = sfem::with_middles(std::move(body));
  const sfem::Params params{.formulation = kind.formulation, .touch_depth = 2 * organ.patch};
  Result<sfem::Model> model = solved(exec, std::move(body), params, true);
  if (!model) return model.error();
  const sfem::GreenCost cost = sfem::green_cost(*model);
  row.nodes = int(model->vertex.size());
  row.flops = cost.factor_flops + cost.solve_flops;
  row.store_bytes = double(cost.store_bytes), row.factor_bytes = double(cost.factor_bytes);
  std::vector<double> forces;
  for (const Place& place : places_on(organ))
    forces.push_back(press_along(patch_on(exec, *model, place, organ.patch, kind.refinement), place, organ));
  return forces;
}

}  // namespace

Result<std::vector<ElementsRow>> validate_elements(const Exec& exec, bool quick, const Progress& progress) {
  const Result<std::vector<Organ>> all = organs(exec, quick);
  if (!all) return all.error();
  std::vector<ElementsRow> rows;
  const std::size_t kinds = std::size(kKinds);
  std::size_t total = 0;
  for (const Organ& organ : *all) total += organ.ratios.size() * kinds;
  for (const Organ& organ : *all)
    for (const double poisson : organ.ratios) {
      std::vector<std::vector<double>> forces;
      for (const Kind& kind : kKinds) {
        ElementsRow row{organ.name, kind.name, poisson, int(element_count(organ.mesh))};
        Result<std::vector<double>> found = forces_of(exec, organ, kind, poisson, row);
        if (!found) return found.error();
        forces.push_back(std::move(*found));
        rows.push_back(row);
        if (progress) progress(double(rows.size()) / double(total));
      }
      for (std::size_t k = 0; k < kinds; k++)
        for (std::size_t p = 0; p < forces[k].size(); p++) {
          ElementsRow& row = rows[rows.size() - kinds + k];
          const double error = forces[k][p] / forces.back()[p] - 1;
          row.mean += error / double(forces[k].size());
          if (std::abs(error) > std::abs(row.worst)) row.worst = error;
        }
    }
  return rows;
}

}  // namespace turgor
