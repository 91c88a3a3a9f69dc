// Where the drawn surface is now. A vertex follows its node and the gradient of the displacement around it,
// taken over uncut edges alone: smooth where tissue stretches, and blind to what is across a cut.
#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "turgor/models/lattice/cut_tet.hpp"
#include "turgor/models/lattice/surface.hpp"

namespace turgor::lattice {

namespace {

/// A node and its weight in a fit.
struct Sample {
  Vec3 rest, displacement;  // [m]
  Real weight;
};
using Samples = std::array<Sample, 125>;

/// A linear fit to displacements: mean + gradient · (x − centre).
struct LocalFit {
  Vec3 centre, mean, gradient[3];

  Vec3 at(Vec3 x) const {
    const Vec3 d = x - centre;
    return mean + gradient[0] * d.x + gradient[1] * d.y + gradient[2] * d.z;
  }
};

/// Weighted least squares. A direction in which there are no nodes has no gradient.
LocalFit fit_samples(const Samples& samples, std::size_t count) {
  LocalFit fit;
  Real total = 0;
  for (std::size_t n = 0; n < count; n++) {
    total += samples[n].weight;
    fit.centre += samples[n].rest * samples[n].weight;
    fit.mean += samples[n].displacement * samples[n].weight;
  }
  fit.centre = fit.centre / total, fit.mean = fit.mean / total;
  Eigen::Matrix3f normal = Eigen::Matrix3f::Zero(), right = Eigen::Matrix3f::Zero();
  for (std::size_t n = 0; n < count; n++) {
    const Vec3 d = samples[n].rest - fit.centre, du = samples[n].displacement - fit.mean;
    const Eigen::Vector3f distance(d.x, d.y, d.z);
    normal += samples[n].weight * distance * distance.transpose();
    right += samples[n].weight * distance * Eigen::Vector3f(du.x, du.y, du.z).transpose();
  }
  if (!(normal.trace() > 0)) return fit;
  normal.diagonal().array() += 1e-4f * normal.trace();
  const Eigen::Matrix3f g = normal.inverse() * right;  // row a = ∂u/∂x_a
  for (int axis = 0; axis < 3; axis++) fit.gradient[axis] = {g(axis, 0), g(axis, 1), g(axis, 2)};
  return fit;
}

Sample sample_at(const CutBody& body, Int3 node, Real weight) {
  const Lattice& l = body.model.lattice;
  return {rest_position(l, node), body.state.u[std::size_t(node_slot(l, node))], weight};
}

/// Over a node and the neighbours that it holds together with.
LocalFit fit_around(const CutBody& body, Int3 node) {
  Samples samples;
  std::size_t count = 0;
  samples[count++] = sample_at(body, node, 1);
  for (const Int3 offset : kFamilies)
    for (const Int3 way : {offset, -offset})
      if (is_solid(body, node + way) && !is_cut(body, node, node + way))
        samples[count++] = sample_at(body, node + way, 1);
  return fit_samples(samples, count);
}

/// Beside a cut, points that nearly coincide hang on different nodes. A fit to all nodes near the point on
/// its side of the blade gives them the same displacement. [moving least squares, Lancaster and Salkauskas
/// 1981]
Vec3 displacement_beside_cut(const CutBody& body, const CutLevel& level, Int3 node, Vec3 x) {
  const Lattice& l = body.model.lattice;
  const Vec3 at{x.x / l.step.x, x.y / l.step.y, x.z / l.step.z};
  const Int3 middle{int(std::lround(at.x)), int(std::lround(at.y)), int(std::lround(at.z))};
  Samples samples;
  std::size_t count = 0;
  for (int k = -2; k <= 2; k++)
    for (int j = -2; j <= 2; j++)
      for (int i = -2; i <= 2; i++) {
        const Int3 other = middle + Int3{i, j, k};
        const Vec3 apart = Vec3(other) - at;
        const Real fade = 1 - dot(apart, apart) / 4;  // two steps
        if (fade <= 0 || !contains(l, other) || !is_solid(body, other) || level.at(Vec3d(other)) >= 0)
          continue;
        samples[count++] = sample_at(body, other, fade * fade);
      }
  return count > 0 ? fit_samples(samples, count).at(x) : body.state.u[std::size_t(node_slot(l, node))];
}

/// Displacement of every vertex, lattice frame [m].
std::vector<Vec3> displacements(const Model& model, const State& state, const BodySurface& surface) {
  struct Carrier {
    LocalFit fit;
    std::optional<CutLevel> level;
  };
  const CutBody body = make_cut_body(model, state);
  std::vector<int> known(model.tissue.size(), -1);  // by slot: index into carriers
  std::vector<Carrier> carriers;
  std::vector<Vec3> result(surface.rest.size());
  for (std::size_t v = 0; v < result.size(); v++) {
    const Int3 node = slot_node(model.lattice, surface.slot[v]);
    int& index = known[std::size_t(surface.slot[v])];
    if (index < 0) {
      index = int(carriers.size());
      carriers.push_back({fit_around(body, node), level_beside(body, node)});
    }
    const Carrier& carrier = carriers[std::size_t(index)];
    result[v] = carrier.level ? displacement_beside_cut(body, *carrier.level, node, surface.rest[v])
                              : carrier.fit.at(surface.rest[v]);
  }
  return result;
}

Vec3 area_vector(const std::vector<Vec3>& x, Int3 t) {
  const Vec3 a = x[std::size_t(t.x)];
  return cross(x[std::size_t(t.y)] - a, x[std::size_t(t.z)] - a);
}

/// Area-weighted; the two lips of a cut that is hardly open share theirs, so that it does not show.
std::vector<Vec3> smooth_normals(const BodySurface& surface, const std::vector<Vec3>& x, Real step) {
  std::vector<Vec3> sums(x.size());
  for (const Int3 t : surface.triangles)
    for (int corner = 0; corner < 3; corner++) sums[std::size_t(t[corner])] += area_vector(x, t);
  std::vector<Vec3> normals = sums;
  for (std::size_t v = 0; v < x.size(); v++) {
    if (surface.twin[v] >= 0) {
      const auto twin = std::size_t(surface.twin[v]);
      normals[v] += sums[twin] * std::max(Real(0), 1 - norm(x[twin] - x[v]) / step);
    }
    normals[v] = normalized(normals[v]);
  }
  return normals;
}

/// Area now over area in the CT, less one, of the skin around each vertex. Triangles that a cut has torn open
/// had no area.
std::vector<float> stretches(const BodySurface& surface, const std::vector<Vec3>& x, Real step) {
  std::vector<float> now(x.size()), rest(x.size());
  for (int n = 0; n < surface.skin_triangles; n++) {
    const Int3 t = surface.triangles[std::size_t(n)];
    const float area_rest = norm(area_vector(surface.rest, t)), area_now = norm(area_vector(x, t));
    if (area_rest < 1e-5f * step * step) continue;
    for (int corner = 0; corner < 3; corner++) {
      rest[std::size_t(t[corner])] += area_rest;
      now[std::size_t(t[corner])] += area_now;
    }
  }
  for (std::size_t v = 0; v < x.size(); v++) now[v] = rest[v] > 0 ? now[v] / rest[v] - 1 : 0;
  return now;
}

}  // namespace

TriMesh deformed_surface(const Model& model, const State& state, const BodySurface& surface, Shown shown) {
  const std::vector<Vec3> u = displacements(model, state, surface);
  std::vector<Vec3> x(u.size());
  for (std::size_t v = 0; v < x.size(); v++) x[v] = surface.rest[v] + u[v];

  const Real step = std::min({model.lattice.step.x, model.lattice.step.y, model.lattice.step.z});
  TriMesh mesh{.vertices = {},
               .triangles = surface.triangles,
               .normals = smooth_normals(surface, x, step),
               .scalars = {}};
  if (shown == Shown::kStretch) mesh.scalars = stretches(surface, x, step);
  if (shown == Shown::kDisplacement)
    for (const Vec3 d : u) mesh.scalars.push_back(norm(d));

  const Mat3d& axes = model.grid.axes;
  mesh.vertices.reserve(x.size());
  for (const Vec3 p : x) mesh.vertices.push_back(Vec3(model.grid.origin + axes * Vec3d(p)));
  for (Vec3& n : mesh.normals) n = Vec3(axes * Vec3d(n));
  if (determinant(axes) < 0)  // mirrored: what was counter-clockwise is not
    for (Int3& t : mesh.triangles) std::swap(t.y, t.z);
  return mesh;
}

}  // namespace turgor::lattice
