// Rigid tool shapes with signed distances, which are negative inside. Normals point from the tool toward the
// tissue.
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

/// Ball about the tool's origin.
struct Sphere {
  double radius = 0.005;  // [m]
};

/// Ball swept along the segment from -half_length to half_length on the tool's z axis.
struct Capsule {
  double radius = 0.005;      // [m]
  double half_length = 0.01;  // [m]
};

/// Closed surface, stored as distances on a regular grid and interpolated between its nodes. Sharp edges are
/// rounded by about one spacing.
struct MeshShape {
  Vec3d corner;        // of the grid [m]
  double spacing = 0;  // [m]
  Int3 size;           // number of grid nodes along each axis
  using Node = DistanceNode;
  std::vector<Node> nodes;     // x fastest
  std::vector<Vec3d> tips;     // points spread over the surface [m]
  double bounding_radius = 0;  // about the tool's origin [m]
  double tip_radius = 0;       // half of the shortest side of its bounding box [m]
};

using Shape = std::variant<Sphere, Capsule, MeshShape>;

/// Distance grid of a closed mesh in the tool's frame, with `resolution` cells along its longest side. Error:
/// no triangles, a vertex that is not finite, or an edge that is not shared by exactly two triangles.
Result<Shape> mesh_shape(const TriMesh& mesh, int resolution = 48);

/// True when the pose is finite and its axes are orthonormal and right-handed to 1e-3.
bool is_valid(const Pose& pose);

/// View of a mesh's distance grid as plain pointers.
inline DistanceGrid view(const MeshShape& m) { return {m.corner, m.spacing, m.size, m.nodes.data()}; }

/// Distance and normal in the shape's frame.
ShapeDistance distance(const Shape& shape, Vec3d x);
/// Distance and normal in the world frame.
ShapeDistance distance(const Shape& shape, const Pose& pose, Vec3d x);

/// Radius of a ball about the origin that contains the shape [m].
double bounding_radius(const Shape& shape);
/// Position of a tool: its origin, or the nearest point of the box around a mesh that lies beside its origin
/// [m].
Vec3d tool_position(const Shape& shape, const Pose& pose);
/// Radius of the shape's tip. Triangles with longer edges let the tool enter between their corners [m].
double tip_radius(const Shape& shape);
/// Test points for contact inside such large triangles, in the shape's frame: centers of balls that fill the
/// shape, or points of its surface.
int tip_count(const Shape& shape);
Vec3d tip(const Shape& shape, int index);

}  // namespace turgor::contact
