#include "turgor/models/rigid/rigid.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"

namespace turgor::rigid {

namespace {

constexpr double kLargestTurn = 0.1;  // of the fastest principal axis in a substep [rad]
constexpr int kMostSubsteps = 10000;

/// Rotates about a principal axis by the flow of its term of the energy, of `dt` seconds.
void turn_about(const MassProperties& mass, Vec3d momentum, int axis, double dt, Quaternion& q) {
  const Vec3d a = mass.axes.column[axis];
  const double angle = dt * dot(axes_of(q) * a, momentum) / mass.moments[axis];
  q = product(q, rotation_of(a * angle));
}

/// Symmetric composition of second order.
void turn_symmetrically(const MassProperties& mass, Vec3d momentum, double dt, Quaternion& q) {
  turn_about(mass, momentum, 0, dt / 2, q), turn_about(mass, momentum, 1, dt / 2, q);
  turn_about(mass, momentum, 2, dt, q);
  turn_about(mass, momentum, 1, dt / 2, q), turn_about(mass, momentum, 0, dt / 2, q);
}

/// Torque-free rotation with constant momentum. The number of substeps depends on what the motion conserves.
Quaternion turned_freely(const MassProperties& mass, Vec3d momentum, double dt, Quaternion q) {
  const double least = std::min({mass.moments.x, mass.moments.y, mass.moments.z});
  const double turn = norm(momentum) / least * dt;
  if (!(turn > 0)) return q;
  const int count = int(std::min(double(kMostSubsteps), std::ceil(turn / kLargestTurn)));
  // fourth order by three steps [Yoshida 1990]
  const double outer = 1 / (2 - std::cbrt(2.0)), h = dt / count;
  for (int n = 0; n < count; n++)
    for (const double share : {outer, 1 - 2 * outer, outer}) turn_symmetrically(mass, momentum, share * h, q);
  return normalized(q);
}

/// Principal axes and moments of ∫ ρ x xᵀ about the center of mass.
void set_inertia(const Eigen::Matrix3d& second, MassProperties& properties) {
  const Eigen::Matrix3d inertia = second.trace() * Eigen::Matrix3d::Identity() - second;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(inertia);
  for (int axis = 0; axis < 3; axis++) {
    const Eigen::Vector3d a = solver.eigenvectors().col(axis);
    properties.axes.column[axis] = {a.x(), a.y(), a.z()};
    properties.moments[axis] = solver.eigenvalues()[axis];
  }
}

Eigen::Vector3d eigen_of(Vec3d v) { return {v.x, v.y, v.z}; }

}  // namespace

Quaternion rotation_of(Vec3d turn) {
  const double angle = norm(turn);
  // sin(φ/2)/φ, by its series where φ is small
  const double s = angle > 1e-4 ? std::sin(angle / 2) / angle : 0.5 - angle * angle / 48;
  return {std::cos(angle / 2), s * turn.x, s * turn.y, s * turn.z};
}

Quaternion product(const Quaternion& a, const Quaternion& b) {
  const Vec3d u{a[1], a[2], a[3]}, v{b[1], b[2], b[3]};
  const Vec3d w = a[0] * v + b[0] * u + cross(u, v);
  return {a[0] * b[0] - dot(u, v), w.x, w.y, w.z};
}

Result<MassProperties> mass_of_mesh(std::span<const Vec3d> vertices, std::span<const Int3> triangles,
                                    double density) {
  TURGOR_CHECK(all_indices(triangles, vertices.size()), "triangles have vertices of the mesh");
  // tetrahedra between a point near the body and every triangle
  const Vec3d origin = vertices.empty() ? Vec3d{} : vertices[0];
  double volume = 0;
  Eigen::Vector3d first = Eigen::Vector3d::Zero();   // ∫ x
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();  // ∫ x xᵀ
  for (const Int3 t : triangles) {
    Eigen::Vector3d corner[3], sum = Eigen::Vector3d::Zero();
    for (int n = 0; n < 3; n++) sum += corner[n] = eigen_of(vertices[std::size_t(t[n])] - origin);
    const double v = corner[0].dot(corner[1].cross(corner[2])) / 6;
    volume += v, first += v / 4 * sum;
    second += v / 20 * (sum * sum.transpose());
    for (const Eigen::Vector3d& x : corner) second += v / 20 * (x * x.transpose());
  }
  if (!(volume > 0)) return Error{"the surface encloses no volume"};
  // about the center of mass
  const Eigen::Vector3d center = first / volume;
  MassProperties made{
      .mass = density * volume, .center = origin + Vec3d{center.x(), center.y(), center.z()}, .axes = {}};
  set_inertia(density * (second - volume * center * center.transpose()), made);
  if (!(made.moments.x > 0)) return Error{"the surface encloses a body without inertia about an axis"};
  return made;
}

MassProperties mass_of_round(const RoundShape& shape, double density) {
  TURGOR_CHECK(shape.radius > 0, "a round shape has a radius");
  // a cylinder and two half balls
  const double r = shape.radius, length = norm(shape.ends[1] - shape.ends[0]), half = length / 2;
  const double cylinder = density * std::numbers::pi * r * r * length;
  const double ball = density * 4 / 3 * std::numbers::pi * r * r * r;
  // ∫ ρ x² along the axis and across it; the center of mass of a half ball is 3/8 r off its plane
  const double along = cylinder * half * half / 3 + ball * (half * half + 0.75 * half * r + r * r / 5);
  const double across = cylinder * r * r / 4 + ball * r * r / 5;
  const Vec3d axis = length > 0 ? (shape.ends[1] - shape.ends[0]) / length : Vec3d{0, 0, 1};
  MassProperties made{.mass = cylinder + ball, .center = 0.5 * (shape.ends[0] + shape.ends[1]), .axes = {}};
  const Eigen::Vector3d a = eigen_of(axis);
  set_inertia(across * Eigen::Matrix3d::Identity() + (along - across) * a * a.transpose(), made);
  return made;
}

MassProperties with_mass(MassProperties properties, double mass) {
  TURGOR_CHECK(properties.mass > 0 && mass > 0, "bodies have a positive mass");
  properties.moments *= mass / properties.mass;
  properties.mass = mass;
  return properties;
}

State make_state(const Model& model, Vec3d velocity, Vec3d spin) {
  State state{.center = model.mass.center, .velocity = velocity, .momentum = {}};
  for (int axis = 0; axis < 3; axis++) {
    const Vec3d a = model.mass.axes.column[axis];
    state.momentum += a * (model.mass.moments[axis] * dot(a, spin));
  }
  return state;
}

Pose pose_of(const Model& model, const State& state) {
  const Mat3d rotation = axes_of(state.rotation);
  return {state.center - rotation * model.mass.center, rotation};
}

Mat3d inverse_inertia(const Model& model, const Quaternion& rotation) {
  Mat3d sum{{{}, {}, {}}};
  if (model.is_fixed) return sum;
  const Mat3d axes = axes_of(rotation) * model.mass.axes;
  for (int axis = 0; axis < 3; axis++)
    for (int k = 0; k < 3; k++)
      sum.column[k] += axes.column[axis] * (axes.column[axis][k] / model.mass.moments[axis]);
  return sum;
}

Vec3d spin_of(const Model& model, const State& state) {
  return inverse_inertia(model, state.rotation) * state.momentum;
}

double kinetic_energy(const Model& model, const State& state) {
  return 0.5 * model.mass.mass * dot(state.velocity, state.velocity) +
         0.5 * dot(state.momentum, spin_of(model, state));
}

double largest_speed(const Model& model, const State& state) {
  double radius = 0;
  for (const Vec3d x : model.vertices) radius = std::max(radius, norm(x - model.mass.center));
  return norm(state.velocity) + norm(spin_of(model, state)) * radius;
}

State moved(const Model& model, const State& state, Vec3d impulse, Vec3d angular_impulse, double dt) {
  TURGOR_CHECK(is_step_length(dt), "a step has a positive length");
  if (model.is_fixed) return state;
  State next = state;
  next.velocity += impulse / model.mass.mass;
  next.momentum += angular_impulse;
  next.center += next.velocity * dt;
  next.rotation = turned_freely(model.mass, next.momentum, dt, state.rotation);
  return next;
}

}  // namespace turgor::rigid
