// From the points that the fine lattice's tetrahedra gave to the vertices that are drawn: near cuts all of
// them, elsewhere one for each box of two thirds of a step, so that drawing costs no more than the lattice's
// own skin.
#pragma once

#include "turgor/models/lattice/key_index.hpp"
#include "turgor/models/lattice/surface/surface.hpp"

namespace turgor::lattice::detail {

constexpr int kSkin = 0, kFirstCap = 1, kWall = 7,
              kParts = 8;  // each part has vertices, and so normals, of its own

struct SurfacePoint {
  Vec3d place;  // [steps of the lattice]
  Carrier carrier;
  std::uint8_t border = 0;  // bit 2 axis + end = lies where the lattice ends
  bool is_skin = false;     // on an edge from tissue to air
  bool kept = false;        // near a cut
};

struct Points {
  std::vector<SurfacePoint> all;
  std::array<std::vector<Int3>, kParts> triangles;
  std::vector<Lip> lips;  // between points
};

/// What was found in some cells, in the order in which it was found.
struct KnownPoints {
  KeyIndex index;
  std::vector<std::uint64_t> keys;  // of the points
  Points points;
};
/// Of slabs of cells, one after the other. A whole slab, in which nothing is cut or removed, always has the
/// same points.
struct KnownSlabs {
  std::vector<KnownPoints> slabs;
  std::vector<std::uint8_t> is_whole;  // was it when it was looked at?
};
/// Of slabs of cells that lie on each other, as if they had been looked at one after the other: a point that
/// a slab shares with the one below it is the one found there.
Points joined(const std::vector<KnownPoints>& slabs);

/// Fills in everything but the pieces. Points are merged by where they are alone, so that what was closed
/// stays closed.
void take_points(const Model& model, const State& state, const Points& points, BodySurface& surface);

}  // namespace turgor::lattice::detail
