// How often a triangle surface winds around a point: 1 inside, 0 outside of a closed one, in between near the
// holes of an open one, 2 where it encloses a place twice. Unlike the side of the nearest triangle it has a
// meaning on surfaces that cross themselves. Far triangles are taken together. [Barill et al. 2018]
#pragma once

#include <vector>

#include "turgor/geometry/triangle_tree.hpp"

namespace turgor {

/// What the triangles of each node of TriangleTree::boxes are from afar.
struct WindingNodes {
  struct Node {
    Vec3d middle;     // of their areas [m]
    Vec3d area;       // sum of areas along their normals [m²]
    double far2 = 0;  // squared distance from the middle where that is exact enough [m²]
  };
  std::vector<Node> nodes;
};

WindingNodes winding_nodes(const TriangleTree& tree);
double winding_number(const TriangleTree& tree, const WindingNodes& winding, Vec3d p);

}  // namespace turgor
