// [body.NAME] with model = "cloth": sheet, holds, obstacles and wind, as plain structs. docs/scene.md lists
// keys, units and defaults. Nothing is loaded here.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "turgor/geometry/up_axis.hpp"
#include "turgor/models/cloth/build/sheet.hpp"
#include "turgor/models/cloth/cloth.hpp"
#include "turgor/sim/scene/body_id.hpp"
#include "turgor/sim/scene/device.hpp"
#include "turgor/sim/scene/texture_scene.hpp"
#include "turgor/sim/scene/tissue_row.hpp"

namespace turgor {

/// A triangle surface from a file.
struct GarmentFile {
  std::filesystem::path file;
  double scale = 1;  // meters per unit of the file
  bool is_scale_given = false;
  UpAxis up = UpAxis::kZ;  // the file's axis that points up
  Vec3d shift;             // after scaling and turning [m]
};

struct BallScene {
  Vec3d center;         // [m]
  double radius = 0.1;  // [m]
};

/// Vertices held from `start` to `end`, moved along a path of displacements.
struct HoldScene {
  std::string name;
  std::vector<int> vertices;                // of the mesh
  std::optional<std::array<Vec3d, 2>> box;  // low and high corner; all vertices in it at rest [m]
  std::optional<BallScene> ball;            // all vertices in it at `start`
  double start = 0;                         // [s]
  double end = std::numeric_limits<double>::infinity();  // [s]
  std::vector<std::array<double, 4>> path;               // t, x, y, z, ascending [s] [m]; empty = fixed
};

struct PlaneScene {
  Vec3d through, normal{0, 0, 1};  // [m]
};
struct RodScene {
  Vec3d from, to;        // [m]
  double radius = 0.05;  // [m]
};
struct ObstacleScene {
  std::string name;
  std::variant<PlaneScene, BallScene, RodScene, GarmentFile, BodyId> shape;
  double friction = 0.3;  // [1]
  double gap = 0.002;     // distance that the cloth keeps [m]
};

/// Mean wind from a time on.
struct WindTurn {
  double time = 0;  // [s]
  Vec3d velocity;   // [m/s]

  bool operator==(const WindTurn&) const = default;
};

struct ClothScene {
  std::string name;
  std::string source_location;  // "scene.toml:7:1: body.flag", for errors found later
  std::variant<cloth::Sheet, GarmentFile> source;
  Device device = Device::kCpu;
  cloth::Params params;
  std::vector<TissueRow> tissues;  // laws and values with their source, for the report
  double stiffness_scale = 1;      // of membrane, springs and bending [1]
  TextureScene texture;
  cloth::Air air;
  std::vector<WindTurn> turns;
  std::vector<HoldScene> holds;
  std::vector<ObstacleScene> obstacles;
};

}  // namespace turgor
