// Rigid bodies with large rotations: mass, inertia and motion over one step.
//
// The state has the center of mass c, the unit quaternion q of the rotation R from rest, the velocity v and
// the angular momentum L about c, both in the world. Over a step of h seconds with the impulse p and the
// angular impulse l,
//
//     v ← v + p/m,   L ← L + l,   c ← c + h v,   q ← the torque-free rotation with constant L
//
// The rotation is the composition of rotations about the principal axes of inertia, which are the exact flows
// of the terms of H = Σ L_i²/(2 J_i) [Dullweber, Leimkuhler, McLachlan 1997], composed to the fourth order
// [Yoshida 1990]. L stays exactly constant, and the energy error is bounded. Together with constraints at the
// end of a step, this is the SHAKE method, so that v and L are those of the middle of the step.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "turgor/core/result.hpp"
#include "turgor/core/vec.hpp"
#include "turgor/geometry/pose.hpp"
#include "turgor/geometry/quaternion.hpp"

namespace turgor::rigid {

/// Mass, center of mass and inertia about it.
struct MassProperties {
  double mass = 0;         // [kg]
  Vec3d center;            // [m]
  Mat3d axes;              // principal axes of inertia, orthonormal
  Vec3d moments{1, 1, 1};  // principal moments [kg m²]
};

/// A ball or a capsule: all points within `radius` of a segment. A radius of 0 means another shape.
struct RoundShape {
  double radius = 0;          // [m]
  std::array<Vec3d, 2> ends;  // of the segment; equal for a ball [m]
};

/// Shape and mass at rest.
struct Model {
  std::vector<Vec3d> vertices;  // [m]
  std::vector<Int3> triangles;  // counter-clockwise seen from outside
  RoundShape round;             // shape of which the surface is a picture
  MassProperties mass;
  bool is_fixed = false;  // true: the body does not move
};

struct State {
  Vec3d center;                     // of mass [m]
  Quaternion rotation{1, 0, 0, 0};  // from rest, unit
  Vec3d velocity;                   // of the center of mass [m/s]
  Vec3d momentum;                   // angular, about the center of mass, in the world [kg m²/s]
};

/// Properties of a closed surface filled with a material, by integrals over the tetrahedra between its
/// triangles and one point. Error: no volume.
Result<MassProperties> mass_of_mesh(std::span<const Vec3d> vertices, std::span<const Int3> triangles,
                                    double density);
/// The same of a ball or a capsule.
MassProperties mass_of_round(const RoundShape& shape, double density);
/// Scales mass and inertia to a mass [kg].
MassProperties with_mass(MassProperties properties, double mass);

/// State at rest with a velocity of the center of mass [m/s] and an angular velocity [rad/s].
State make_state(const Model& model, Vec3d velocity = {}, Vec3d spin = {});

/// Pose that takes positions at rest to their present ones.
Pose pose_of(const Model& model, const State& state);
/// Inverse of the inertia about the center of mass in the world; 0 for a body that does not move [1/(kg m²)].
Mat3d inverse_inertia(const Model& model, const Quaternion& rotation);
/// Angular velocity in the world [rad/s].
Vec3d spin_of(const Model& model, const State& state);
/// Kinetic energy [J].
double kinetic_energy(const Model& model, const State& state);
/// Upper bound of the speed of every point [m/s].
double largest_speed(const Model& model, const State& state);

/// State after a step of `dt` seconds under an impulse [N s] and an angular impulse about the center of mass
/// [N m s], both at its beginning. A body that does not move stays as it is.
State moved(const Model& model, const State& state, Vec3d impulse, Vec3d angular_impulse, double dt);

/// Unit quaternion of a rotation by |turn| rad about `turn`.
Quaternion rotation_of(Vec3d turn);
/// Rotation by `b`, then by `a`.
Quaternion product(const Quaternion& a, const Quaternion& b);

}  // namespace turgor::rigid
