// Smooth surfaces by subdivision.
#include "turgor/geometry/loop_subdivision.hpp"

#include <algorithm>
#include <map>

#include <gtest/gtest.h>

#include "turgor/geometry/ball_mesh.hpp"

namespace turgor {
namespace {

/// Largest angle between the normals of two triangles at an edge [radians].
double sharpest_edge(const std::vector<Vec3>& x, const std::vector<Int3>& triangles) {
  std::map<std::pair<int, int>, Vec3> seen;
  double sharpest = 0;
  for (const Int3 t : triangles) {
    const Vec3 a = x[std::size_t(t.x)], b = x[std::size_t(t.y)], c = x[std::size_t(t.z)];
    const Vec3 n = normalized(cross(b - a, c - a));
    for (int corner = 0; corner < 3; corner++) {
      const int p = t[corner], q = t[(corner + 1) % 3];
      const auto [at, is_new] = seen.try_emplace({std::min(p, q), std::max(p, q)}, n);
      if (!is_new)
        sharpest = std::max(sharpest, std::acos(std::clamp(double(dot(n, at->second)), -1.0, 1.0)));
    }
  }
  return sharpest;
}

std::vector<Vec3> positions(const SmoothSurface& surface, const std::vector<Vec3>& coarse) {
  std::vector<Vec3> x;
  for (std::size_t v = 0; v < surface.size(); v++)
    x.push_back(interpolated(surface, v, std::span<const Vec3>(coarse)));
  return x;
}

// A dented ball becomes smooth: sixteen times the triangles, edges at most half as sharp, and a size within
// the known shrinkage of the scheme.
TEST(LoopSubdivision, SmoothsDentedBall) {
  TriMesh ball = ball_mesh(1, 2);
  for (std::size_t v = 0; v < ball.vertices.size(); v += 7) ball.vertices[v] = ball.vertices[v] * 0.85f;
  const SmoothSurface surface = loop_subdivision(ball.triangles, 2);
  const std::vector<Vec3> x = positions(surface, ball.vertices);
  EXPECT_EQ(surface.triangles.size(), 16 * ball.triangles.size());
  EXPECT_EQ(x.size(), surface.triangles.size() / 2 + 2) << "a closed surface, by Euler's formula";
  EXPECT_LT(sharpest_edge(x, surface.triangles), 0.5 * sharpest_edge(ball.vertices, ball.triangles));
  for (const Vec3 p : x) EXPECT_NEAR(norm(p), 0.9, 0.1);
}

// Weights sum to one, so that a surface that moves as a whole, or is stretched, does so exactly.
TEST(LoopSubdivision, FollowsAffineMotion) {
  const TriMesh ball = ball_mesh(1, 1);
  const SmoothSurface surface = loop_subdivision(ball.triangles, 2);
  const auto moved = [](Vec3 p) { return Vec3{2 * p.x + p.y + 3, p.y - 1, 0.5f * p.z + p.x}; };
  std::vector<Vec3> coarse;
  for (const Vec3 p : ball.vertices) coarse.push_back(moved(p));
  const std::vector<Vec3> x = positions(surface, ball.vertices), y = positions(surface, coarse);
  for (std::size_t v = 0; v < x.size(); v++) {
    EXPECT_LT(norm(y[v] - moved(x[v])), 1e-5f);
    const Vec3 on = on_coarse(surface, v, std::span<const Vec3>(ball.vertices));
    EXPECT_LT(norm(on_coarse(surface, v, std::span<const Vec3>(coarse)) - moved(on)), 1e-5f);
    EXPECT_GT(norm(on), norm(x[v])) << "smoothing shrinks a ball";
  }
}

// The border of an open sheet stays on its straight line, and its corners are rounded. Unused vertices are
// left out.
TEST(LoopSubdivision, KeepsStraightBorders) {
  std::vector<Vec3> coarse;
  std::vector<Int3> triangles;
  for (int j = 0; j < 3; j++)
    for (int i = 0; i < 4; i++) coarse.push_back({Real(i), Real(j), j == 1 ? Real(0.3) : 0});
  coarse.push_back({9, 9, 9});
  for (int j = 0; j < 2; j++)
    for (int i = 0; i < 3; i++) {
      const int a = 4 * j + i;
      triangles.push_back({a, a + 1, a + 5}), triangles.push_back({a, a + 5, a + 4});
    }
  const SmoothSurface surface = loop_subdivision(triangles, 1);
  const std::vector<Vec3> x = positions(surface, coarse);
  EXPECT_EQ(x.size(), 7u * 5u);
  int on_border = 0;
  for (const Vec3 p : x) {
    EXPECT_LT(p.x, 3.001f);
    if (p.y > 1e-6f) continue;
    on_border++;
    EXPECT_EQ(p.z, 0) << p.x;
  }
  EXPECT_EQ(on_border, 5) << "seven without the corners";
}

// Every mesh gets as many levels as keep it below the budget: at least ten times the triangles of meshes
// below 25 000 in a window, among them the liver of scenes/forceps.toml with 6228, and below 100 000 in
// pictures.
TEST(LoopSubdivision, LevelsForDrawingUseTheBudget) {
  for (const std::size_t most : {kMostInWindow, kMostInPictures})
    for (const std::size_t triangles :
         {std::size_t(20), std::size_t(6228), std::size_t(24999), std::size_t(25000), std::size_t(50000),
          std::size_t(99999), std::size_t(100000), std::size_t(360000), std::size_t(1000000)}) {
      const int levels = levels_for_drawing(triangles, most);
      std::size_t drawn = triangles;
      for (int level = 0; level < levels; level++) drawn *= 4;
      if (levels > 0) {
        EXPECT_LT(drawn, most);
      }
      if (levels < 2) {
        EXPECT_GE(4 * drawn, most);
      }
      if (triangles < (most == kMostInWindow ? 25000u : 100000u)) {
        EXPECT_GE(drawn, 10 * triangles);
      }
    }
}

}  // namespace
}  // namespace turgor
