// Points of a surface at which a vertex of another surface can touch it. Surfaces touch where their normals
// are opposite. A vertex of a sharp corner has many normals, the cone that the normals of its triangles span.
#pragma once

#include <vector>

#include "turgor/contact/pair_sites.hpp"

namespace turgor::contact {

/// A surface with what the search needs.
struct SearchedSurface {
  const PairSurface& surface;
  std::vector<int> vertices;        // of its triangles, ascending
  std::vector<Vec3d> normals;       // of every vertex of the mesh, weighted by the angles of its triangles
  std::vector<std::size_t> around;  // first entry of each vertex in `triangles`, and an end
  std::vector<int> triangles;       // around each vertex, ascending
  std::vector<Vec3d> faces;         // unit normal of each triangle
  TriangleTree tree;
  double edge = 0;  // mean [m]
};
SearchedSurface searched_surface(const PairSurface& surface);

/// A vertex and a point of the other surface.
struct FacingPoint {
  TrianglePoint point;
  Vec3d normal;       // of the other surface, or toward the vertex
  double height = 0;  // above the other surface, negative inside [m]
  bool faces = false;
};

/// Point of the other surface at which a position x touches it, with the normals of a vertex of its own
/// surface. It is the nearest point. Where that one does not face the vertex and is at the surface or above
/// it, it is the nearest point on triangles that face the vertex. Such a vertex is close to a sharp edge.
FacingPoint facing_point(const SearchedSurface& other, Vec3d x, const SearchedSurface& own, int vertex);

}  // namespace turgor::contact
