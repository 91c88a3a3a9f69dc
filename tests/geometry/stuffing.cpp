#include "turgor/geometry/stuffing.hpp"

#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "tests/geometry/mesh_checks.hpp"
#include "turgor/core/hash.hpp"
#include "turgor/geometry/mesh_quality.hpp"

namespace turgor {
namespace {

SolidMesh stuffed(const SignedDistance& shape, double size, const Exec& exec = Exec(2)) {
  return stuff(exec, sample(exec, shape, lattice_around(shape, size, 0)));
}

SignedDistance sphere(Vec3d center, double radius) {
  const Vec3d r{radius, radius, radius};
  return {[=](Vec3d p) { return norm(p - center) - radius; }, center - r, center + r};
}

SignedDistance torus(double ring, double tube) {
  const Vec3d high{ring + tube, ring + tube, tube};
  return {[=](Vec3d p) { return std::hypot(std::hypot(p.x, p.y) - ring, p.z) - tube; }, -high, high};
}

SignedDistance box(Vec3d half) {
  return {[=](Vec3d p) {
            const Vec3d d = max(p, -p) - half;
            return norm(max(d, Vec3d{})) + std::min(0.0, std::max({d.x, d.y, d.z}));
          },
          -half, half};
}

/// Noise inside a ball, with features of about the lattice spacing. Nothing is resolved, so every sign
/// pattern occurs.
SignedDistance noisy_ball(unsigned seed, double wavelength) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::vector<std::pair<Vec3d, double>> waves;
  for (int i = 0; i < 24; i++) {
    const Vec3d k{normal(random), normal(random), normal(random)};
    waves.emplace_back(k * (2 * std::numbers::pi / wavelength / 1.7), 6.28 * normal(random));
  }
  return {[=](Vec3d p) {
            double sum = 0;
            for (const auto& [k, phase] : waves) sum += std::sin(dot(k, p) + phase);
            return std::max(norm(p) - 1, sum * 0.05 * wavelength);
          },
          {-1, -1, -1},
          {1, 1, 1}};
}

// A stuffed ball has the volume of the ball, and its surface vertices lie on the sphere.
TEST(Stuffing, BallVolumeAndSurface) {
  for (const double size : {0.4, 0.2, 0.1}) {
    const SolidMesh mesh = stuffed(sphere({0.1, 0.2, 0.3}, 1), size);
    const double exact = 4 * std::numbers::pi / 3;
    EXPECT_NEAR(volume(mesh), exact, 0.35 * size * size * exact) << size;
    for (const Int3 t : surface(mesh).triangles)
      for (int c = 0; c < 3; c++)
        EXPECT_NEAR(norm(mesh.vertices[std::size_t(t[c])] - Vec3d{0.1, 0.2, 0.3}), 1, 1e-6);
    test::expect_sound(mesh);
    EXPECT_EQ(test::euler_characteristic(mesh), 2);
  }
}

// A torus keeps its hole and its volume.
TEST(Stuffing, TorusKeepsHoleAndVolume) {
  const SolidMesh mesh = stuffed(torus(1, 0.4), 0.1);
  const double exact = 2 * std::numbers::pi * std::numbers::pi * 0.16;
  EXPECT_NEAR(volume(mesh), exact, 0.02 * exact);
  test::expect_sound(mesh);
  EXPECT_EQ(test::euler_characteristic(mesh), 0);
}

// A box keeps its volume within 2 %, although its edges are blunted.
TEST(Stuffing, BoxKeepsVolume) {
  const SolidMesh mesh = stuffed(box({0.5, 0.4, 0.3}), 0.05);
  EXPECT_NEAR(volume(mesh), 8 * 0.5 * 0.4 * 0.3, 0.02 * 8 * 0.5 * 0.4 * 0.3);
  test::expect_sound(mesh);
  EXPECT_EQ(test::euler_characteristic(mesh), 2);
}

// Dihedral angles stay within the paper's bounds for shapes with details below the lattice spacing.
TEST(Stuffing, UnresolvedShapes_KeepAngleBounds) {
  double least = 180, largest = 0;
  std::size_t elements = 0;
  for (unsigned seed = 0; seed < 24; seed++) {
    const SolidMesh mesh = stuffed(noisy_ball(seed, 0.15 + 0.025 * seed), seed % 3 == 0 ? 0.11 : 0.17);
    ASSERT_NO_FATAL_FAILURE(test::expect_sound(mesh)) << seed;
    const MeshQuality quality = measure_quality(mesh);
    least = std::min(least, quality.min_dihedral), largest = std::max(largest, quality.max_dihedral);
    elements += element_count(mesh);
  }
  EXPECT_GE(least, kLeastStuffedDihedral);
  EXPECT_LE(largest, kLargestStuffedDihedral);
  RecordProperty("least dihedral angle", std::to_string(least));
  RecordProperty("largest dihedral angle", std::to_string(largest));
  RecordProperty("elements", std::to_string(elements));
}

// A level offsets the surface.
TEST(Stuffing, LevelOffsetsSurface) {
  const Exec exec(1);
  const LatticeSamples samples = sample(exec, sphere({}, 1), lattice_around(sphere({}, 1), 0.2, 0.1));
  const SolidMesh mesh = stuff(exec, samples, 0.1);
  for (const Int3 t : surface(mesh).triangles) EXPECT_NEAR(norm(mesh.vertices[std::size_t(t.x)]), 1.1, 1e-6);
}

// One, two and five threads give the same bits.
TEST(Stuffing, EqualBitsOnAnyThreads) {
  const auto hash = [](int threads) {
    const SolidMesh mesh = stuffed(noisy_ball(3, 0.3), 0.1, Exec(threads));
    return hash_values<int>(mesh.elements, hash_values<Vec3d>(mesh.vertices));
  };
  EXPECT_EQ(hash(1), hash(2));
  EXPECT_EQ(hash(1), hash(5));
}

// A shape smaller than the lattice spacing may give no elements.
TEST(Stuffing, TinyShapeMayBeEmpty) {
  EXPECT_EQ(element_count(stuffed(sphere({0.013, 0.02, 0.03}, 1e-3), 1.0)), 0u);
}

}  // namespace
}  // namespace turgor
