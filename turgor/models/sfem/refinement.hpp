// Subdivision of coarse elements along their edges: fine nodes with their coarse supports, and fine elements.
// Tetrahedra are divided into r³ by planes parallel to their faces and Kuhn's rule inside, hexahedra into r³
// along their own axes. Neighbors agree on their common face. Fine elements of a quadratic tetrahedron are
// quadratic and contain its functions, so the patch adds only its finer resolution.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "turgor/models/sfem/sfem.hpp"

namespace turgor::sfem {

/// A node of the fine mesh: u = Σ weight · u_G(coarse) + u_L. Fixed coarse vertices do not move and are left
/// out.
struct FineNode {
  Vec3d x;                          // at rest [m]
  std::uint64_t key = 0;            // equal for the same node seen from another element or patch
  std::array<int, 10> coarse{};     // vertices of the coarse mesh
  std::array<double, 10> weight{};  // of each
  int supports = 0;                 // how many of them
  bool at_vertex = false;           // of the coarse mesh
  bool on_border = false;           // on Γ_GL, where the patch ends inside the body
  bool fixed = false;               // on an outer face that is fixed
};

struct FineMesh {
  std::vector<FineNode> nodes;
  std::vector<int> corners;  // fine elements, as many nodes each as the coarse ones
  std::vector<int> parent;   // coarse element of each fine one, one coarse element after the other
  std::vector<int> shape;    // equal for congruent fine elements of one tetrahedron or box
  std::vector<Int3> outer;   // triangles of the body's outer surface, between neighboring nodes
};

FineMesh refine(const Model& model, std::span<const int> elements, int refinement);

}  // namespace turgor::sfem
