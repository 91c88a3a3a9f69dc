// Look of bodies in pictures and windows: their cut-away, and which surfaces are wet.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "turgor/core/vec.hpp"
#include "turgor/geometry/box.hpp"
#include "turgor/sim/scene/body_id.hpp"

namespace turgor {

/// [output.cutaway]: one side of a plane, or a wedge, of a body is not drawn.
struct CutawayScene {
  BodyId body;
  bool by_fraction = true;
  Vec3d at{0.5, 0.5, 0.5};       // point of the planes [m], or in fractions of the body's box at rest
  Vec3d normal{0, -1, 0};        // towards the removed side; any length
  std::optional<Vec3d> wedge;    // of a second plane; only what is on both removed sides is left out
  bool cuts_inclusions = false;  // else they stand out of the section
  bool operator==(const CutawayScene&) const = default;
};

/// Point and unit normals of a cut-away's planes.
struct CutawayPlanes {
  Vec3d at;  // [m]
  std::vector<Vec3d> normals;
};
/// The planes for a body with this box at rest.
CutawayPlanes cutaway_planes(const CutawayScene& cutaway, const Box& box);

struct LookScene {
  std::optional<CutawayScene> cutaway;
  std::map<std::string, bool> wet;  // by body, if its scene says so
  std::string window = "abdomen";   // of gray values, as output.window
};

}  // namespace turgor
