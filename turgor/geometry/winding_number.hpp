// Generalized winding number of a triangle surface at a point: 1 inside and 0 outside of a closed one,
// fractional near the holes of an open one, 2 where it encloses a region twice. It is also defined on
// self-crossing surfaces, where the side of the nearest triangle is not. Distant triangles are approximated
// by dipoles in a tree. [Barill et al. 2018]
#pragma once

#include <vector>

#include "turgor/geometry/triangle_tree.hpp"

namespace turgor {

/// Far-field approximation of the triangles of each node of TriangleTree::boxes.
struct WindingNodes {
  struct Node {
    Vec3d middle;     // area-weighted centroid [m]
    Vec3d area;       // sum of area-weighted normals [m²]
    double far2 = 0;  // squared distance from which the approximation is used [m²]
  };
  std::vector<Node> nodes;
};

WindingNodes winding_nodes(const TriangleTree& tree);
double winding_number(const TriangleTree& tree, const WindingNodes& winding, Vec3d p);

}  // namespace turgor
