// Ends of drawn cuts at rest: what closes there when the surface is drawn (close_ends.hpp). It depends only
// on the surface, so it is part of its plan.
#pragma once

#include <cstddef>
#include <vector>

#include "turgor/models/lattice/surface/surface.hpp"

namespace turgor::lattice::detail {

struct SurfacePlan;

/// Vertices of both sides of a cut that coincide at rest.
struct ClosingGroup {
  std::vector<std::size_t> vertices;  // at least two
  Real inside;                        // 0 at the end of the cut, 1 where the lips do not close any more
};

/// Vertex of a cut that coincides with no other one, and those that may move it.
struct VertexBeside {
  struct Mover {
    int index;  // into the vertices of all groups, one after another
    Vec3 away;  // from it to this vertex at rest [m]
  };
  std::size_t vertex;
  std::vector<Mover> movers;
};

/// Skin at one position near an end, away from the lips.
struct SkinPoint {
  Real weight;                        // of the smoothed displacement [1]
  std::vector<std::size_t> vertices;  // that coincide at rest
  std::vector<std::size_t> beside;    // neighbors on the skin
};

/// End of a cut inside the body, with no other cut near it.
struct CutEnd {
  std::size_t left, right;  // vertices of the last lip
  std::vector<ClosingGroup> groups;
  std::vector<VertexBeside> beside;
  std::vector<SkinPoint> skin;
};

/// Corner where the ends of two cuts meet and neither goes on.
struct CutCorner {
  struct Near {
    std::size_t vertex;
    Real inside;  // 0 at the corner, 1 where nothing closes any more
  };
  std::size_t first, second;      // vertices of both outer lips nearest to it
  std::vector<std::size_t> lips;  // vertices of the lips of both cuts at the corner
  std::vector<Near> near;
};

struct CutEnds {
  std::vector<CutEnd> ends;
  std::vector<CutCorner> corners;
};

/// Ends of all cuts of a surface. `plan` has the triangles around its vertices; `step`: smallest spacing [m].
CutEnds find_cut_ends(const BodySurface& surface, const SurfacePlan& plan, Real step);

}  // namespace turgor::lattice::detail
