// What the hand holds, as contact sees it: a rigid shape that knows how far any point is from its surface.
// Distances are negative inside; normals point away from the tool, at the tissue.
#pragma once

#include <cstddef>
#include <variant>
#include <vector>

#include "turgor/core/result.hpp"
#include "turgor/core/vec.hpp"
#include "turgor/geometry/pose.hpp"
#include "turgor/geometry/shape_distance.hpp"
#include "turgor/geometry/tri_mesh.hpp"
#include "turgor/geometry/triangle_point.hpp"

namespace turgor::contact {

using turgor::closest_weights;
using turgor::Pose;
using turgor::ShapeDistance;
using turgor::to_tool;
using turgor::to_world;

/// About the tool's origin.
struct Sphere {
  double radius = 0.005;  // [m]
};

/// Around the segment from -half_length to half_length on the tool's z axis.
struct Capsule {
  double radius = 0.005;      // [m]
  double half_length = 0.01;  // [m]
};

/// A closed surface, kept as distances on a regular grid around it and interpolated between its nodes: sharp
/// edges are rounded by about one spacing.
struct MeshShape {
  Vec3d corner;        // of the grid [m]
  double spacing = 0;  // [m]
  Int3 size;           // nodes along each axis
  using Node = DistanceNode;
  std::vector<Node> nodes;     // x fastest
  std::vector<Vec3d> tips;     // some places of the surface, far from each other [m]
  double bounding_radius = 0;  // about the tool's origin [m]
  double tip_radius = 0;       // half of the shortest side of the box around it [m]
};

using Shape = std::variant<Sphere, Capsule, MeshShape>;

/// Distances of a closed mesh in the tool's frame, `resolution` grid cells along its longest side. Error: no
/// triangles, a vertex that is not finite, an edge that is not shared by two triangles.
Result<Shape> mesh_shape(const TriMesh& mesh, int resolution = 48);

/// Finite, with axes that are orthonormal and right-handed to 1e-3.
bool is_valid(const Pose& pose);

/// A mesh's distances as plain pointers.
inline DistanceGrid view(const MeshShape& m) { return {m.corner, m.spacing, m.size, m.nodes.data()}; }

/// All in the shape's frame.
ShapeDistance distance(const Shape& shape, Vec3d x);
/// All in the world.
ShapeDistance distance(const Shape& shape, const Pose& pose, Vec3d x);

/// No point of the shape is farther from its origin [m].
double bounding_radius(const Shape& shape);
/// Triangles with edges longer than this can be entered between their corners [m].
double tip_radius(const Shape& shape);
/// Places of the shape that are looked at against such triangles, in the shape's frame: centres of balls that
/// fill it, or places of its surface.
int tip_count(const Shape& shape);
Vec3d tip(const Shape& shape, int index);

}  // namespace turgor::contact
