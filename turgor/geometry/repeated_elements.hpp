// Search for elements that a mesh lists more than once. Such a mesh has too much volume, and its surface has
// holes, because the faces of both copies cancel each other.
#pragma once

#include <cstddef>
#include <vector>

#include "turgor/geometry/solid_mesh.hpp"

namespace turgor {

/// Two elements whose corners have the same positions, in any order.
struct RepeatedElement {
  std::size_t first = 0, again = 0;  // first < again
};

/// All elements that repeat an earlier one, in ascending order of `again`. Vertices with equal coordinates
/// count as one.
std::vector<RepeatedElement> repeated_elements(const SolidMesh& mesh);

}  // namespace turgor
