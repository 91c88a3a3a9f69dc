// [attachment.NAME] and [contact.NAME]: bodies that hold on to each other, and bodies that touch, as plain
// structs. docs/scene/organs.md lists keys, units and defaults.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "turgor/core/vec.hpp"
#include "turgor/sim/scene/body_id.hpp"

namespace turgor {

/// Springs between points of two surfaces, or between points of a surface and the ground.
struct AttachmentScene {
  std::string name;
  std::string source_location;
  BodyId body;
  std::optional<BodyId> other;              // empty = the ground
  double distance = 0.003;                  // between the surfaces at rest, up to which points are tied [m]
  std::vector<Vec3d> at;                    // of a rigid body: these points are tied [m]
  std::optional<std::array<Vec3d, 2>> box;  // only points in it: low and high corner [m]
  double stiffness = 0;                     // of the whole attachment; 0 = by area [N/m]
  double stiffness_per_area = 0;            // [N/m³]
  double slack = 0;                         // [m]
  double break_force = 0;                   // of the whole attachment under even load; 0 = never [N]
  int points = 32;                          // at most
  bool is_optional = false;                 // left out where the bodies are too far apart
};

/// Contact with friction between the surfaces of two bodies.
struct BodyContactScene {
  std::string name;
  std::string source_location;
  BodyId body;
  std::optional<BodyId> other;     // empty = the ground
  Vec3d through, normal{0, 0, 1};  // of the ground's plane [m]
  double friction = 0.1;           // Coulomb's μ [1]
  double gap = 0;                  // distance that is kept between the surfaces [m]
  int sites = 64;                  // at most
  bool is_optional = false;
};

}  // namespace turgor
