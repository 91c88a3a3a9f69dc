#include "turgor/geometry/rounded.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <numbers>

#include "turgor/geometry/ball_mesh.hpp"

namespace turgor {

namespace {

using Eigen::Matrix3d, Eigen::Vector3d;

/// Volume, center and second moments of a closed surface.
struct Solid {
  double volume = 0;
  Vector3d center = Vector3d::Zero();
  Matrix3d spread = Matrix3d::Zero();  // mean of (x − center)(x − center)ᵀ
};
Solid solid_of(const TriMesh& mesh) {
  Solid solid;
  if (mesh.vertices.empty()) return solid;
  const Vec3d from(mesh.vertices[0]);  // a nearby origin limits cancellation
  const auto corner = [&](int v) {
    const Vec3d x = Vec3d(mesh.vertices[std::size_t(v)]) - from;
    return Vector3d(x.x, x.y, x.z);
  };
  for (const auto [i, j, k] : mesh.triangles) {  // tetrahedra with `from`
    const Vector3d a = corner(i), b = corner(j), c = corner(k), sum = a + b + c;
    const double one = a.dot(b.cross(c)) / 6;
    solid.volume += one, solid.center += sum * (one / 4);
    solid.spread +=
        (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose()) * (one / 20);
  }
  if (!(solid.volume > 0)) return solid;
  solid.center /= solid.volume;
  solid.spread = solid.spread / solid.volume - solid.center * solid.center.transpose();
  solid.center += Vector3d(from.x, from.y, from.z);
  return solid;
}

}  // namespace

TriMesh rounded(const TriMesh& coarse) {
  static const TriMesh kBall = ball_mesh(1, 3);
  const Solid solid = solid_of(coarse);
  if (!(solid.volume > 0)) return coarse;
  const Eigen::SelfAdjointEigenSolver<Matrix3d> axes(solid.spread);
  if (!(axes.eigenvalues().minCoeff() > 0)) return coarse;
  const Vector3d half = axes.eigenvalues().cwiseSqrt();
  const double scale = std::cbrt(solid.volume / (4.0 / 3 * std::numbers::pi * half.prod()));
  const Matrix3d to_ellipsoid =
      axes.eigenvectors() * (half * scale).asDiagonal() * axes.eigenvectors().transpose();
  TriMesh round{.vertices = {}, .triangles = kBall.triangles, .normals = {}, .scalars = {}};
  for (const Vec3 p : kBall.vertices) {
    const Vector3d x = solid.center + to_ellipsoid * Vector3d(double(p.x), double(p.y), double(p.z));
    round.vertices.push_back(Vec3(Vec3d{x.x(), x.y(), x.z()}));
  }
  return round;
}

}  // namespace turgor
