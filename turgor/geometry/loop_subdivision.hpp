// Smooth surface over a coarse triangle mesh by Loop's subdivision, for pictures. Every vertex is a weighted
// sum of coarse vertices, so that it follows their displacements. [Loop 1987; weights of Warren 1995]
#pragma once

#include <span>
#include <vector>

#include "turgor/core/vec.hpp"

namespace turgor {

struct SmoothSurface {
  std::vector<Int3> triangles;
  std::vector<int> begin;     // by vertex, and the end: indices into `coarse` and `weight`
  std::vector<int> coarse;    // vertices of the coarse mesh
  std::vector<float> weight;  // the sum over a vertex is 1
  // by vertex: the corners of a coarse triangle on which it lies before smoothing, and its weights there
  std::vector<Int3> on;
  std::vector<Vec3> on_weight;
  std::size_t size() const { return on.size(); }
};

/// Subdivides every triangle into four, `levels` times. Edges of one triangle, or of more than two, stay
/// creases. Coarse vertices without triangles are left out. The four follow each other.
SmoothSurface loop_subdivision(std::span<const Int3> triangles, int levels);
/// Triangle that these four replace.
constexpr Int3 triangle_of_four(const Int3* four) { return {four[0].x, four[1].y, four[2].z}; }

/// Triangles of a surface that is drawn: at most these.
constexpr std::size_t kMostInWindow = 400'000, kMostInPictures = 1'600'000;
/// Levels that give a mesh sixteen times as many triangles while it stays below `most`; 1 or 0 for finer
/// meshes.
int levels_for_drawing(std::size_t triangles, std::size_t most);

/// Smooth weighted sum of values of the coarse vertices at one vertex.
template <class T>
T interpolated(const SmoothSurface& surface, std::size_t vertex, std::span<const T> values) {
  T sum{};
  for (int n = surface.begin[vertex]; n < surface.begin[vertex + 1]; n++)
    sum += values[std::size_t(surface.coarse[std::size_t(n)])] * surface.weight[std::size_t(n)];
  return sum;
}

/// Values of the coarse vertices where a vertex lies on the coarse mesh, linear on each triangle.
template <class T>
T on_coarse(const SmoothSurface& surface, std::size_t vertex, std::span<const T> values) {
  const Int3 t = surface.on[vertex];
  const Vec3 w = surface.on_weight[vertex];
  return values[std::size_t(t.x)] * w.x + values[std::size_t(t.y)] * w.y + values[std::size_t(t.z)] * w.z;
}

}  // namespace turgor
