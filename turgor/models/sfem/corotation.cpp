// Forces of rotated elements.
#include <algorithm>
#include <cmath>

#include "turgor/core/assert.hpp"
#include "turgor/geometry/quadratic.hpp"
#include "turgor/models/sfem/rotation.hpp"

namespace turgor::sfem {

namespace {

/// A matrix turned around an axis, by Rodrigues' formula.
Mat3d turned(const Mat3d& m, Vec3d axis, double angle) {
  Mat3d result;
  const double c = std::cos(angle), s = std::sin(angle);
  for (int i = 0; i < 3; i++) {
    const Vec3d v = m.column[i];
    result.column[i] = v * c + cross(axis, v) * s + axis * (dot(axis, v) * (1 - c));
  }
  return result;
}

/// Orthonormalizes a rotation, so that errors of many small steps do not accumulate.
Mat3d orthonormal(Mat3d r) {
  r.column[0] = normalized(r.column[0]);
  r.column[1] = normalized(r.column[1] - r.column[0] * dot(r.column[0], r.column[1]));
  r.column[2] = cross(r.column[0], r.column[1]);
  return r;
}

/// Gradient of each corner's shape function at the element's center. For a hexahedron: that of the box that
/// its face centers span.
std::vector<Vec3d> center_gradients(const SolidMesh& mesh, std::size_t e) {
  static constexpr std::array<Vec3d, 8> kCorner{
      {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1}, {-1, -1, 1}, {1, -1, 1}, {1, 1, 1}, {-1, 1, 1}}};
  static constexpr std::array<Vec3d, 4> kLinear{{{-1, -1, -1}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  const auto x = [&](std::size_t c) { return mesh.vertices[std::size_t(element(mesh, e)[c])]; };
  Mat3d map{{{}, {}, {}}};
  std::vector<Vec3d> slope(std::size_t(mesh.corners));
  for (std::size_t c = 0; c < slope.size(); c++) {
    if (mesh.corners == 8)
      slope[c] = kCorner[c] / 8;
    else if (mesh.corners == 4)
      slope[c] = kLinear[c];
    else if (c >= 4)  // at the center, the functions of a quadratic tetrahedron's corners have zero slope
      slope[c] = kLinear[std::size_t(kTetEdges[c - 4][0])] + kLinear[std::size_t(kTetEdges[c - 4][1])];
    for (int axis = 0; axis < 3; axis++) map.column[axis] += x(c) * slope[c][axis];
  }
  TURGOR_CHECK(determinant(map) != 0, "an element has a volume");
  const Mat3d to_space = transposed(inverse(map));
  for (Vec3d& g : slope) g = to_space * g;
  return slope;
}

/// For each corner of each element, the nodal volume of its vertex and the element's material.
std::vector<int> find_volumes(const Model& model, const NodalVolumes& volumes) {
  const SolidMesh& mesh = model.body.mesh;
  const std::vector<int> material = element_materials(model.body);
  const auto key = [&](int n) {
    return std::pair(volumes.center[std::size_t(n)], volumes.material[std::size_t(n)]);
  };
  std::vector<int> all(volumes.volume.size()), found;
  for (std::size_t n = 0; n < all.size(); n++) all[n] = int(n);
  for (std::size_t e = 0; e < element_count(mesh); e++)
    for (const int v : element(mesh, e))
      found.push_back(*std::lower_bound(all.begin(), all.end(), std::pair(v, material[e]),
                                        [&](int n, const auto& wanted) { return key(n) < wanted; }));
  TURGOR_CHECK(found.size() == mesh.elements.size(), "every corner of an element has a nodal volume");
  return found;
}

/// Displacements of all vertices from those of the free nodes.
std::vector<Vec3d> spread(const Model& model, std::span<const double> u) {
  TURGOR_CHECK(u.size() == 3 * model.vertex.size(), "every free node has three numbers");
  std::vector<Vec3d> all(model.free_node.size());
  for (std::size_t row = 0; row < model.vertex.size(); row++)
    all[std::size_t(model.vertex[row])] = {u[3 * row], u[3 * row + 1], u[3 * row + 2]};
  return all;
}

/// Displacement of each of an element's nodes, in the element's frame [m].
using Offsets = std::array<Vec3d, 10>;

/// Rᵀ (X + u) − X, without losing digits where it is small.
Offsets offsets_from_rest(const SolidMesh& mesh, std::span<const int> vertices,
                          const std::vector<Vec3d>& displacement, const Mat3d& rotation) {
  const Mat3d back = transposed(rotation);
  Mat3d turn = back;
  for (int axis = 0; axis < 3; axis++) turn.column[axis][axis] -= 1;
  const Vec3d origin = mesh.vertices[std::size_t(vertices[0])];
  Offsets offsets;
  for (std::size_t c = 0; c < vertices.size(); c++) {
    const auto v = std::size_t(vertices[c]);
    offsets[c] = back * displacement[v] + turn * (mesh.vertices[v] - origin);
  }
  return offsets;
}

/// Forces of elements on their corners in their own frames, and volume changes.
struct OwnForces {
  std::vector<Vec3d> force;      // of each element's corners [N]
  std::vector<double> swelling;  // of each element, relative to its volume
};

void deform(const Corotation& corotation, std::size_t corners, std::size_t e, const Offsets& offsets,
            OwnForces& own) {
  const std::size_t n = 3 * corners;
  const double* k = &corotation.matrices[n * n * e];
  std::array<double, 30> f{};
  for (std::size_t b = 0; b < n; b++) {
    const double offset = offsets[b / 3][int(b % 3)];
    for (std::size_t a = 0; a < n; a++) f[a] += k[b * n + a] * offset;
  }
  own.swelling[e] = 0;
  for (std::size_t c = 0; c < corners; c++) {
    own.force[corners * e + c] = {f[3 * c], f[3 * c + 1], f[3 * c + 2]};
    own.swelling[e] += dot(corotation.gradient[corners * e + c], offsets[c]);
  }
}

/// Pressure of averaged tetrahedra against changes of the nodal volumes.
void add_pressure(const Exec& exec, const SolidMesh& mesh, const Corotation& corotation, OwnForces& own) {
  TURGOR_CHECK(corotation.volume_of.size() == 4 * own.swelling.size(),
               "every corner of a tetrahedron has a nodal volume");
  const std::vector<int>& volume_of = corotation.volume_of;
  std::vector<double> pressure(corotation.bulk.size());  // of each nodal volume [Pa]
  parallel_for(
      exec, pressure.size(),
      [&](std::size_t n) {
        double swelling = 0;  // [m³]
        for (const int e : corotation.around[std::size_t(corotation.volumes.center[n])])
          for (std::size_t c = 4 * std::size_t(e); c < 4 * std::size_t(e) + 4; c++)
            if (volume_of[c] == int(n))
              swelling += own.swelling[std::size_t(e)] * volume(mesh, std::size_t(e)) / 4;
        pressure[n] = corotation.bulk[n] * swelling;
      },
      64);
  parallel_for(
      exec, own.swelling.size(),
      [&](std::size_t e) {
        double mean = 0;
        for (std::size_t c = 4 * e; c < 4 * e + 4; c++) mean += pressure[std::size_t(volume_of[c])] / 4;
        for (std::size_t c = 4 * e; c < 4 * e + 4; c++)
          own.force[c] += corotation.gradient[c] * (mean * volume(mesh, e));
      },
      64);
}

/// The mean over the elements around each element's corners.
std::vector<Mat3d> smoothed(const Exec& exec, const SolidMesh& mesh, const Corotation& corotation,
                            const std::vector<Mat3d>& of_element) {
  const auto add = [](Mat3d& sum, const Mat3d& m, double weight) {
    for (int axis = 0; axis < 3; axis++) sum.column[axis] += m.column[axis] * weight;
  };
  std::vector<Mat3d> of_vertex(mesh.vertices.size(), Mat3d{{{}, {}, {}}}),
      result(of_element.size(), Mat3d{{{}, {}, {}}});
  parallel_for(
      exec, of_vertex.size(),
      [&](std::size_t v) {
        double total = 0;
        for (const int e : corotation.around[v]) total += volume(mesh, std::size_t(e));
        for (const int e : corotation.around[v])
          add(of_vertex[v], of_element[std::size_t(e)], volume(mesh, std::size_t(e)) / total);
      },
      64);
  parallel_for(
      exec, result.size(),
      [&](std::size_t e) {
        for (const int v : element(mesh, e)) add(result[e], of_vertex[std::size_t(v)], 1.0 / mesh.corners);
      },
      64);
  return result;
}

/// Gathers the elements' forces at the free nodes; offsets_of(vertices, rotation) gives each element's own.
template <class OffsetsOf>
void forces_of(const Exec& exec, const Model& model, const Corotation& corotation,
               const std::vector<Mat3d>& rotation, std::span<double> forces, const OffsetsOf& offsets_of) {
  const SolidMesh& mesh = model.body.mesh;
  const auto corners = std::size_t(mesh.corners);
  TURGOR_CHECK(rotation.size() == element_count(mesh) && forces.size() == 3 * model.vertex.size(),
               "every element has a rotation, and every free node a force");
  OwnForces own{std::vector<Vec3d>(mesh.elements.size()), std::vector<double>(element_count(mesh))};
  parallel_for(
      exec, element_count(mesh),
      [&](std::size_t e) { deform(corotation, corners, e, offsets_of(element(mesh, e), rotation[e]), own); },
      64);
  if (!corotation.volume_of.empty()) add_pressure(exec, mesh, corotation, own);
  parallel_for(
      exec, model.vertex.size(),
      [&](std::size_t row) {
        const int v = model.vertex[row];
        Vec3d sum;
        for (const int e : corotation.around[std::size_t(v)]) {
          const auto vertices = element(mesh, std::size_t(e));
          const auto corner = std::size_t(std::find(vertices.begin(), vertices.end(), v) - vertices.begin());
          sum += rotation[std::size_t(e)] * own.force[corners * std::size_t(e) + corner];
        }
        for (int axis = 0; axis < 3; axis++) forces[3 * row + std::size_t(axis)] = sum[axis];
      },
      64);
}

}  // namespace

// Newton's method for the largest Σ r_c·f_c; where its matrix is not positive, the step of [Müller 2016].
Mat3d nearest_rotation(const Mat3d& f, Mat3d guess) {
  constexpr int kMostTurns = 40;
  constexpr double kSmallTurn = 1e-13, kLargeTurn = 0.7;  // [rad]
  for (int i = 0; i < kMostTurns; i++) {
    const Vec3d torque = cross(guess.column[0], f.column[0]) + cross(guess.column[1], f.column[1]) +
                         cross(guess.column[2], f.column[2]);
    const Mat3d stretch = f * transposed(guess), other = transposed(stretch);
    const double trace = stretch.column[0].x + stretch.column[1].y + stretch.column[2].z;
    Mat3d resistance;
    for (int c = 0; c < 3; c++)
      resistance.column[c] = resistance.column[c] * trace - (stretch.column[c] + other.column[c]) * 0.5;
    const double minor =
        resistance.column[0].x * resistance.column[1].y - resistance.column[0].y * resistance.column[1].x;
    const bool positive = resistance.column[0].x > 0 && minor > 0 && determinant(resistance) > 0;
    const Vec3d turn = positive ? inverse(resistance) * torque : torque / std::abs(trace);
    const double angle = std::min(norm(turn), kLargeTurn);
    if (!(angle > kSmallTurn)) break;
    guess = turned(guess, normalized(turn), angle);
  }
  return orthonormal(guess);
}

Corotation make_corotation(const Exec& exec, const Model& model, int averaging) {
  const Body& body = model.body;
  const std::vector<int> material = element_materials(body);
  Corotation c{.averaging = averaging};
  // stiffness and gradients of elements
  c.matrices = element_matrices(exec, body.mesh, body.materials, material, model.params.formulation);
  for (std::size_t e = 0; e < element_count(body.mesh); e++)
    for (const Vec3d g : center_gradients(body.mesh, e)) c.gradient.push_back(g);
  c.around = holders(element_lists(body.mesh), body.mesh.vertices.size());
  // nodal volumes
  if (!averages_nodes(body.mesh, model.params.formulation)) return c;
  c.volumes = nodal_volumes(body.mesh, material);
  c.volume_of = find_volumes(model, c.volumes);
  for (std::size_t n = 0; n < c.volumes.volume.size(); n++)
    c.bulk.push_back(moduli(body.materials[std::size_t(c.volumes.material[n])]).bulk / c.volumes.volume[n]);
  return c;
}

void update_rotations(const Exec& exec, const Model& model, const Corotation& corotation,
                      std::span<const double> u, std::vector<Mat3d>& rotation) {
  const SolidMesh& mesh = model.body.mesh;
  TURGOR_CHECK(rotation.size() == element_count(mesh), "every element has a rotation");
  const std::vector<Vec3d> displacement = spread(model, u);
  std::vector<Mat3d> gradient(rotation.size());  // the identity, to which displacements add
  parallel_for(
      exec, rotation.size(),
      [&](std::size_t e) {
        const std::span<const int> vertices = element(mesh, e);
        for (std::size_t c = 0; c < vertices.size(); c++)
          for (int axis = 0; axis < 3; axis++)
            gradient[e].column[axis] +=
                displacement[std::size_t(vertices[c])] * corotation.gradient[vertices.size() * e + c][axis];
      },
      64);
  for (int pass = 0; pass < corotation.averaging; pass++)
    gradient = smoothed(exec, mesh, corotation, gradient);
  parallel_for(
      exec, rotation.size(), [&](std::size_t e) { rotation[e] = nearest_rotation(gradient[e], rotation[e]); },
      64);
}

void element_forces(const Exec& exec, const Model& model, const Corotation& corotation,
                    const std::vector<Mat3d>& rotation, std::span<const double> u, std::span<double> forces) {
  const std::vector<Vec3d> displacement = spread(model, u);
  forces_of(exec, model, corotation, rotation, forces, [&](std::span<const int> vertices, const Mat3d& r) {
    return offsets_from_rest(model.body.mesh, vertices, displacement, r);
  });
}

void turned_stiffness_times(const Exec& exec, const Model& model, const Corotation& corotation,
                            const std::vector<Mat3d>& rotation, std::span<const double> u,
                            std::span<double> forces) {
  const std::vector<Vec3d> displacement = spread(model, u);
  forces_of(exec, model, corotation, rotation, forces, [&](std::span<const int> vertices, const Mat3d& r) {
    Offsets offsets;
    for (std::size_t c = 0; c < vertices.size(); c++)
      offsets[c] = transposed(r) * displacement[std::size_t(vertices[c])];
    return offsets;
  });
}

}  // namespace turgor::sfem
