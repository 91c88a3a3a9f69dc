#include <algorithm>
#include <cmath>
#include <string>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/core/number_text.hpp"
#include "turgor/models/rhombus/rhombus.hpp"

namespace turgor::rhombus {

namespace {

Status check(const Body& body, const Params& params) {
  if (!(params.bulge >= 0 && params.bulge <= 1))
    return Error{"bulge: expected a fraction from 0 to 1, found " + number_text(params.bulge)};
  if (!(params.tear > 0 && std::isfinite(params.tear)))
    return Error{"the force at which tissue tears: expected more than 0 N, found " +
                 number_text(params.tear)};
  // viscosity
  for (const PronyPair& pair : params.viscosity.pairs) {
    if (!(pair.ratio >= 0 && std::isfinite(pair.ratio)))
      return Error{"viscous stiffening: expected 0 or more, found " + number_text(pair.ratio)};
    if (!(pair.time > 0 && std::isfinite(pair.time)))
      return Error{"relaxation time: expected more than 0 s, found " + number_text(pair.time)};
  }
  // stiffness of the vertices
  if (!body.stiffness.empty() && body.stiffness.size() != body.vertices.size())
    return Error{"stiffness: expected one number for each of the " + std::to_string(body.vertices.size()) +
                 " vertices, found " + std::to_string(body.stiffness.size())};
  for (std::size_t v = 0; v < body.stiffness.size(); v++)
    if (!(body.stiffness[v] > 0 && std::isfinite(body.stiffness[v])))
      return Error{"stiffness of vertex " + std::to_string(v) + ": expected a number above 0, found " +
                   number_text(body.stiffness[v])};
  return Done{};
}

/// Gradient of a piecewise linear function on the surface: the area-weighted mean over the triangles at each
/// vertex.
std::vector<Vec3d> surface_gradient(const Surface& s, const std::vector<double>& value) {
  TURGOR_CHECK(value.size() == s.vertices.size(), "every vertex has a value");
  std::vector<Vec3d> gradient(s.vertices.size());
  std::vector<double> area(s.vertices.size());
  for (std::size_t t = 0; t < s.triangles.size(); t++) {
    const auto x = [&](int corner) { return corner_position(s, int(t), corner); };
    const Vec3d n = cross(x(1) - x(0), x(2) - x(0));
    Vec3d sum;  // twice the area times the gradient, rotated by the unit normal below
    for (int i = 0; i < 3; i++) sum += (x(i + 2) - x(i + 1)) * value[std::size_t(s.triangles[t][i])];
    const Vec3d twice = cross(normalized(n), sum);
    for (int i = 0; i < 3; i++) {
      const auto v = std::size_t(s.triangles[t][i]);
      gradient[v] += twice, area[v] += norm(n);
    }
  }
  TURGOR_CHECK(std::all_of(area.begin(), area.end(), [](double a) { return a > 0; }),
               "every vertex has an area");
  for (std::size_t v = 0; v < gradient.size(); v++) gradient[v] = gradient[v] / area[v];
  return gradient;
}

std::vector<double> vertex_areas(const Surface& s) {
  std::vector<double> area(s.vertices.size());
  for (std::size_t t = 0; t < s.triangles.size(); t++) {
    const auto x = [&](int corner) { return corner_position(s, int(t), corner); };
    const double third = norm(cross(x(1) - x(0), x(2) - x(0))) / 6;
    for (int i = 0; i < 3; i++) area[std::size_t(s.triangles[t][i])] += third;
  }
  return area;
}

}  // namespace

Result<Model> build(Body body, const Params& params) {
  if (const Status good = check(body, params); !good) return good.error();
  // chain and surface
  Result<Chain> chain = build_chain(params.chain);
  if (!chain) return chain.error();
  Result<Surface> surface = build_surface(std::move(body.vertices), std::move(body.triangles));
  if (!surface) return surface.error();
  // search tree, areas, stiffness
  Model model{.params = params, .chain = *chain, .surface = std::move(*surface)};
  model.tree = build_triangle_tree(model.surface.vertices, model.surface.triangles);
  model.area = vertex_areas(model.surface);
  model.stiffness = std::move(body.stiffness);
  if (!model.stiffness.empty()) model.stiffness_gradient = surface_gradient(model.surface, model.stiffness);
  return model;
}

State make_state(const Model& model, std::size_t tool_count) {
  TURGOR_ASSERT(tool_count <= std::size_t(kMaxTouches), "at most kMaxTouches tools touch an organ");
  State state;
  state.touches.resize(tool_count);
  state.distances.resize(tool_count);
  state.displacement.resize(model.surface.vertices.size());
  state.ring.resize(model.surface.vertices.size());
  state.listed.resize(model.surface.vertices.size());
  return state;
}

double stiffness_at(const Model& model, const TrianglePoint& at) {
  if (model.stiffness.empty()) return 1;
  const Int3 t = model.surface.triangles[std::size_t(at.triangle)];
  const auto& k = model.stiffness;
  TURGOR_CHECK(sums_to_one(at.weights), "the weights of a position in a triangle sum to one");
  return k[std::size_t(t.x)] * at.weights.x + k[std::size_t(t.y)] * at.weights.y +
         k[std::size_t(t.z)] * at.weights.z;
}

}  // namespace turgor::rhombus
