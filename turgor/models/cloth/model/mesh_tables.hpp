// Tables of the mesh that never change: membrane, chunks of triangles, excluded pairs, large primitives,
// blocks of the two-level preconditioner.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "turgor/core/aligned.hpp"
#include "turgor/core/vec.hpp"

namespace turgor::cloth {

/// Orthotropic law σ = D ε along warp and weft: D₁₁, D₂₂, D₁₂, G [N/m].
struct MembraneLaw {
  Real warp = 0, weft = 0, both = 0, shear = 0;
};

/// Material law and rest triangles. Arrays are padded to whole batches of triangles.
struct Membrane {
  MembraneLaw law;
  /// Gradients of the shape functions of the second and third corner, along warp and weft [1/m].
  aligned_vector<Real> second[2], third[2];
  /// Entries of a triangle's sides in the rows: slots of both end vertices of sides 0, 1 and 2, relative to
  /// the first slot of their batch.
  std::vector<std::array<std::uint8_t, 6>> slot;
  std::vector<std::array<std::uint16_t, 6>> wide_slot;  // instead, if a batch has more than 256 slots

  /// True for a triangle without force (forces/slivers.hpp). Springs have no membrane, and no slivers.
  bool is_sliver(std::size_t triangle) const {
    const auto is_zero = [triangle](const aligned_vector<Real>& a) { return a[triangle] == 0; };
    return !second[0].empty() && is_zero(second[0]) && is_zero(second[1]) && is_zero(third[0]) &&
           is_zero(third[1]);
  }
};

constexpr std::size_t kChunk =
    256;  // vertices of a chunk, the unit of parallel work; a multiple of the batch size

/// Triangles that touch each chunk of vertices, ascending.
struct ChunkTriangles {
  std::vector<int> begin;     // size: chunks + 1
  std::vector<int> triangle;  // those of chunk c: begin[c] … begin[c + 1]
};

/// Lists of indices: those of vertex i are item[begin[i]] … item[begin[i + 1] − 1].
struct NeighborLists {
  std::vector<int> begin, item;
};

/// Triangles and edges longer than the thickness permits: vertex–vertex contacts alone would let vertices
/// through.
struct LargePrimitives {
  std::vector<Int3> triangles;
  std::vector<Int3> across;  // corner beyond the side that faces each corner; -1 = no large triangle there
  std::vector<std::array<int, 2>> edges;
  std::vector<std::array<int, 2>> facing;  // corners of large triangles that face each edge; -1 = none
  NeighborLists stars;  // neighbors of vertices whose triangles are all large; of others none
  Real longest = 0;     // longest edge at rest [m]
};

/// Blocks of vertices of the two-level preconditioner (solver/two_level.hpp).
struct Blocks {
  std::vector<int> of;             // block of each vertex
  std::vector<int> begin, vertex;  // vertices of each block, and the end
  std::vector<int> pair_begin;     // of each block, and the end
  std::vector<int> pair;           // the block itself and adjacent blocks with smaller numbers, ascending
};

}  // namespace turgor::cloth
