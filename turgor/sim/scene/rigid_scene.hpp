// [body.NAME] with model = "rigid", as plain structs. docs/scene/rigid.md lists keys, units and defaults.
// Nothing is loaded here.
#pragma once

#include <string>
#include <variant>

#include "turgor/sim/scene/rhombus_scene.hpp"
#include "turgor/sim/scene/sfem_scene.hpp"

namespace turgor {

/// Edges of a box around the origin.
struct BoxSize {
  Vec3d size{0.02, 0.02, 0.02};  // [m]
};
using RigidShape = std::variant<BoxSize, BallTool, RodTool, SurfaceFile>;

struct RigidScene {
  std::string name;
  std::string source_location;  // "scene.toml:7:1: body.stone", for errors found later
  RigidShape shape;
  Vec3d at;            // position of the shape's origin [m]
  Vec3d turn;          // rotation vector about it, before it is moved there [rad]
  double density = 0;  // [kg/m³]
  double mass = 0;     // instead of the density; 0 = by density [kg]
  Vec3d velocity;      // of the center of mass at the beginning [m/s]
  Vec3d spin;          // angular velocity at the beginning [rad/s]
  bool is_fixed = false;
  double touch_stiffness = 2000;  // of a point that a tool touches [N/m]
  TextureScene texture;
};

}  // namespace turgor
