#include "turgor/haptics/rotation.hpp"

#include <cmath>

#include "turgor/core/assert.hpp"

namespace turgor::haptics {

namespace {

/// Unit quaternion w + (x, y, z).
struct Quaternion {
  double w;
  Vec3d v;
};

/// Quaternion of a rotation matrix. The largest of the four components is computed first, so that no division
/// by a small number occurs (Shepperd 1978).
Quaternion quaternion(const Mat3d& m) {
  const auto& [a, b, c] = m.column;
  const double trace = a.x + b.y + c.z;
  // largest component first
  Quaternion q;
  if (trace >= a.x && trace >= b.y && trace >= c.z)
    q = {1 + trace, {b.z - c.y, c.x - a.z, a.y - b.x}};
  else if (a.x >= b.y && a.x >= c.z)
    q = {b.z - c.y, {1 + a.x - b.y - c.z, a.y + b.x, c.x + a.z}};
  else if (b.y >= c.z)
    q = {c.x - a.z, {a.y + b.x, 1 + b.y - a.x - c.z, b.z + c.y}};
  else
    q = {a.y - b.x, {c.x + a.z, b.z + c.y, 1 + c.z - a.x - b.y}};
  // normalize
  const double length = std::sqrt(q.w * q.w + dot(q.v, q.v));
  TURGOR_CHECK(length > 0, "a rotation matrix has a quaternion");
  return {q.w / length, q.v / length};
}

}  // namespace

Mat3d rotation(Vec3d turn) {
  const double angle = norm(turn);
  const Vec3d axis = normalized(turn);
  Mat3d m;
  for (Vec3d& e : m.column)  // Rodrigues
    e = e * std::cos(angle) + cross(axis, e) * std::sin(angle) +
        axis * (dot(axis, e) * (1 - std::cos(angle)));
  return m;
}

Vec3d rotation_vector(const Mat3d& m) {
  const Quaternion q = quaternion(m);
  const double sine = norm(q.v), angle = 2 * std::atan2(sine, std::abs(q.w));
  if (sine == 0) return {};
  return q.v * ((q.w < 0 ? -angle : angle) / sine);
}

}  // namespace turgor::haptics
