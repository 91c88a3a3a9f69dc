// [body.NAME] with model = "sfem", and [tool.NAME]: a body and what touches it, as the plain structs that a
// scene becomes. Keys, units and defaults are listed in docs/scene.md; nothing is loaded here.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "turgor/contact/patch_follow.hpp"
#include "turgor/geometry/phantom.hpp"
#include "turgor/geometry/up_axis.hpp"
#include "turgor/models/sfem/sfem.hpp"
#include "turgor/sim/scene/body_id.hpp"
#include "turgor/sim/scene/device.hpp"

namespace turgor {

/// A file of tetrahedra or hexahedra.
struct SolidFile {
  std::filesystem::path file;
  double scale = 1;        // metres a unit of the file
  UpAxis up = UpAxis::kZ;  // the file's axis that points to the head
};
/// A closed surface that is filled with tetrahedra.
struct ClosedSurface {
  std::filesystem::path file;
  double scale = 1;           // metres a unit of the file
  UpAxis up = UpAxis::kZ;     // the file's axis that points to the head
  double resolution = 0.012;  // of the tetrahedra's lattice [m]
};
/// One label of a segmentation that is filled with tetrahedra.
struct LabeledOrgan {
  std::filesystem::path file;            // of labels
  std::optional<PhantomParams> phantom;  // instead of a file
  int label = 0;
  std::string label_note;     // when names of labels were not the file's own
  double resolution = 0.012;  // of the tetrahedra's lattice [m]
};
/// Hexahedra from the origin to `size`.
struct HexBlock {
  Vec3d size{0.1, 0.1, 0.1};  // [m]
  Int3 count{10, 10, 10};
};
using SolidSource = std::variant<SolidFile, ClosedSurface, LabeledOrgan, HexBlock>;

/// Sides of the box around a body, in the patient frame: low and high x, y, z.
enum class Side : std::uint8_t { kRight, kLeft, kFront, kBack, kFeet, kHead };

/// The functions of an element: its corners move it, or the middles of its edges too.
enum class Elements : std::uint8_t { kLinear, kQuadratic };

/// What holds a body: the vertices near sides of its box, or inside a box of their own.
struct HeldBy {
  std::vector<Side> sides{Side::kBack};
  double depth = 0.1;                       // how far from a side, of the box's extent [1]
  std::optional<std::array<Vec3d, 2>> box;  // low and high corner, instead of sides [m or 1]
  bool by_fraction = false;                 // is `box` in fractions of the body's box?
};

/// Elements of another material: those with a number from the file or the segmentation.
struct InsideScene {
  std::string name;
  int label = 0;
  sfem::Material material;
};
/// A sphere of another material.
struct InclusionScene {
  std::string name;
  Vec3d center;  // [m or 1]
  bool by_fraction = false;
  double radius = 0.01;  // [m]
  sfem::Material material;
};

/// The superposed patch that follows the tools.
struct PatchScene {
  double radius = 0.02;  // [m]
  int refinement = 2;    // 1 = none
  double hysteresis = contact::FollowParams{}
                          .hysteresis;  // of the radius: how far a touch moves before the patch follows [1]
};

struct SfemScene {
  Device device = Device::kCpu;  // computes Green's functions
  std::string name;
  std::string place;  // "scene.toml:7:1: body.liver", for errors found later
  SolidSource source;
  sfem::Material material;
  std::vector<InsideScene> inside;
  std::vector<InclusionScene> inclusions;
  HeldBy fixed;
  Elements elements = Elements::kLinear;
  sfem::Formulation formulation = sfem::Formulation::kStandard;
  sfem::Precision precision = sfem::Precision::kSingle;
  PatchScene patch;
  double viscosity = 0;       // how much stiffer a sudden press is [1]
  double viscous_time = 0.5;  // in which that relaxes [s]
  bool rotations = false;
  double memory = 4;            // for Green's functions, beyond it, columns on demand; and for a patch [GB]
  int contacts = 32;            // places that are solved in a tick, of all tools together
  std::filesystem::path cache;  // a folder
  bool cached = true;
  std::filesystem::path seen;  // a finer surface that moves with the body; may be empty
  double seen_scale = 1;       // metres a unit of that file
  UpAxis seen_up = UpAxis::kZ;
};

/// The shape of a tool: a ball, a rod with round ends along its z axis, or a closed mesh.
struct BallTool {
  double radius = 0.006;  // [m]
};
struct RodTool {
  double radius = 0.003, half_length = 0.02;  // [m]
};
struct MeshTool {
  std::filesystem::path file;
  double scale = 1;  // metres a unit of the file
};
/// Two jaws that close while the tool holds.
struct ForcepsTool {
  std::filesystem::path file;  // of both jaws; empty = the phantom
  double scale = 1;            // metres a unit of the file
  double opening = 0.012;      // between the tips when open [m]
  double closing = 0.3;        // from open to closed, and back [s]
};
using ToolShape = std::variant<BallTool, RodTool, MeshTool, ForcepsTool>;

/// Where a tool is at a time.
struct PathRow {
  double time = 0;  // [s]
  Vec3d position;   // of the tool's origin [m]
  bool hold = false;
  std::array<double, 4> orientation{1, 0, 0, 0};  // unit quaternion w, x, y, z
};
struct GivenPath {
  std::vector<PathRow> rows;
  bool smooth = true;  // cubic between the rows instead of straight
};
struct PathFile {
  std::filesystem::path file;  // .csv: t, x, y, z [, hold [, qw, qx, qy, qz]]
  bool smooth = true;
};
/// Presses from outside along the surface's normal, slides, and leaves: fits every body.
struct Press {
  Vec3d at, to;  // on the surface [m or 1]
  bool by_fraction = false;
  double depth = 0.005;   // of the tool's tip below the surface at rest [m]
  double start = 0.1;     // [s]
  double duration = 0.5;  // from touching to `depth`, and back [s]
  double hold = 0.2;      // at `at` before sliding, and at `to` after it [s]
  double slide = 0;       // from `at` to `to`; 0 = no sliding [s]
};
/// Presses along the surface's normal, holds, pulls outwards and aside, and lets go: fits every body.
struct Grasp {
  Vec3d at;  // on the surface [m or 1]
  bool by_fraction = false;
  double depth = 0.003;   // of the tool's tip below the surface at rest when it takes hold [m]
  double pull = 0.01;     // of the tip above the surface at rest [m]
  Vec3d aside;            // of the tip along the surface, besides [m]
  double start = 0.1;     // [s]
  double duration = 0.5;  // of the way in, of the pull, and of the way out [s]
  double hold = 0.4;      // at the two ends, while jaws close and open [s]
};
/// A hand that was recorded, tick by tick: see sim/tools/hand.hpp.
struct HandFile {
  std::filesystem::path file;
};
using ToolMotion = std::variant<GivenPath, PathFile, Press, Grasp, HandFile>;

struct ToolScene {
  std::string name;
  std::string place;
  BodyId body;
  ToolShape shape;
  double friction = 0.3;  // [1]
  ToolMotion motion;
};

}  // namespace turgor
