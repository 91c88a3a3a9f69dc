// Where the drawn surface is now. A vertex follows its node and the gradient of the displacement around it,
// taken over uncut edges alone: smooth where tissue stretches, and blind to what is across a cut.
#include <Eigen/Dense>
#include <algorithm>

#include "turgor/models/lattice/cut_tet.hpp"
#include "turgor/models/lattice/surface.hpp"

namespace turgor::lattice {

namespace {

/// ∂u/∂x by columns, at one node.
struct Gradient {
  Vec3 column[3];

  Vec3 operator*(Vec3 d) const { return column[0] * d.x + column[1] * d.y + column[2] * d.z; }
};

/// Least squares over the neighbours; a direction in which there are none has no gradient.
Gradient gradient_at(const CutBody& body, int slot) {
  const Lattice& l = body.model.lattice;
  const Int3 node = slot_node(l, slot);
  const Vec3 here = body.state.u[std::size_t(slot)];
  Eigen::Matrix3f normal = Eigen::Matrix3f::Zero(), right = Eigen::Matrix3f::Zero();
  for (const Int3 offset : kFamilies)
    for (const Int3 way : {offset, -offset}) {
      const int other = slot + slot_offset(l, way, node.x & 1);
      if (!body.solid[std::size_t(other)] || is_cut(body, node, node + way)) continue;
      const Vec3 d = rest_position(l, way), du = body.state.u[std::size_t(other)] - here;
      const Eigen::Vector3f distance(d.x, d.y, d.z);
      normal += distance * distance.transpose();
      right += distance * Eigen::Vector3f(du.x, du.y, du.z).transpose();
    }
  if (!(normal.trace() > 0)) return {};
  normal.diagonal().array() += 1e-4f * normal.trace();
  const Eigen::Matrix3f g = normal.inverse() * right;  // row a = ∂u/∂x_a
  Gradient gradient;
  for (int axis = 0; axis < 3; axis++) gradient.column[axis] = {g(axis, 0), g(axis, 1), g(axis, 2)};
  return gradient;
}

/// Displacement of every vertex, lattice frame [m].
std::vector<Vec3> displacements(const Model& model, const State& state, const BodySurface& surface) {
  const CutBody body = make_cut_body(model, state);
  std::vector<int> known(model.tissue.size(), -1);  // by slot: index into gradients
  std::vector<Gradient> gradients;
  std::vector<Vec3> result(surface.rest.size());
  for (std::size_t v = 0; v < result.size(); v++) {
    const auto slot = std::size_t(surface.slot[v]);
    if (known[slot] < 0) {
      known[slot] = int(gradients.size());
      gradients.push_back(gradient_at(body, int(slot)));
    }
    const Vec3 from = rest_position(model.lattice, slot_node(model.lattice, int(slot)));
    result[v] = state.u[slot] + gradients[std::size_t(known[slot])] * (surface.rest[v] - from);
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
