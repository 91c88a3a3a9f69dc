// The superposed patch: every coarse element near a tool, subdivided `refinement` times along each edge. Fine
// functions are added to the coarse ones, u = u_G + u_L, where u_L is zero on the patch's border inside the
// body and at the coarse nodes; the coupled system is condensed to the surface of the patch with one dense
// factor, S = K_L − K_LG Ξ K_GL. [SFEM; docs/models/sfem.md]
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "turgor/models/sfem/sfem.hpp"

namespace turgor::sfem {

struct PatchParams {
  double radius = 0.02;  // elements whose centroid is nearer to a touch than this are in the patch [m]
  int refinement = 2;    // parts an edge: 1 = coarse only, 2 … 4
};

/// A point of the patch's surface: how it hangs on the coarse nodes, and whether it has a function of its
/// own.
struct PatchPoint {
  Vec3d x;                         // at rest [m]
  std::uint64_t key = 0;           // equal for the same point of another patch
  std::array<int, 8> coarse{};     // indices into Patch::coarse
  std::array<double, 8> weight{};  // of each; zero = not used
};

/// The surface near the tools, and how it answers. All matrices are column-major.
struct Patch {
  std::vector<int> elements;  // coarse ones that are subdivided, ascending
  std::vector<int> coarse;    // their vertices
  std::vector<PatchPoint> points;
  std::vector<Int3> triangles;  // of points, counter-clockwise seen from outside
  std::vector<double>
      compliance;  // 3·points square: displacements of all points to a unit force at one [m/N]
  std::vector<double> resultant;  // 3·coarse × 3·points: the same force as the coarse body feels it [1]
  int local_nodes = 0;            // fine nodes with a function of their own
};

/// The coarse elements near the touches: centroid within the radius, at least those behind the nearest
/// triangle. Ascending.
std::vector<int> patch_elements(const Model& model, std::span<const Vec3d> touches, double radius);

/// Builds the patch over these elements. Needs Model::green with the columns of all their vertices.
Patch build_patch(const Model& model, std::span<const int> elements, int refinement);

}  // namespace turgor::sfem
