// [body.NAME] with model = "sfem", and [tool.NAME], as plain structs. docs/scene.md lists keys, units and
// defaults. Nothing is loaded here.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "turgor/contact/needle.hpp"
#include "turgor/contact/patch_follow.hpp"
#include "turgor/geometry/phantom.hpp"
#include "turgor/geometry/up_axis.hpp"
#include "turgor/models/sfem/law.hpp"
#include "turgor/models/sfem/sfem.hpp"
#include "turgor/sim/scene/body_id.hpp"
#include "turgor/sim/scene/device.hpp"
#include "turgor/sim/scene/texture_scene.hpp"
#include "turgor/sim/scene/tissue_row.hpp"

namespace turgor {

/// A file of tetrahedra or hexahedra.
struct SolidFile {
  std::filesystem::path file;
  double scale = 1;  // meters per unit of the file
  bool is_scale_given = false;
  UpAxis up = UpAxis::kZ;  // the file's axis that points to the head
};
/// Largest edge of quadratic tetrahedra that is chosen; their nodes are half as far apart [m].
constexpr double kUsualEdge = 0.02;
/// Closed surface that is meshed with tetrahedra.
struct ClosedSurface {
  std::filesystem::path file;
  double scale = 1;  // meters per unit of the file
  bool is_scale_given = false;
  UpAxis up = UpAxis::kZ;            // the file's axis that points to the head
  std::optional<double> resolution;  // edge of the tetrahedral lattice [m]; none: chosen by the volume
};
/// One label of a segmentation, meshed with tetrahedra.
struct LabeledOrgan {
  std::filesystem::path file;            // of labels
  std::optional<PhantomParams> phantom;  // instead of a file
  int label = 0;
  std::string label_note;            // set if label names are not from the file
  std::optional<double> resolution;  // edge of the tetrahedral lattice [m]; none: chosen by the volume
  bool are_cavities_filled = true;
  std::vector<int> of_others;  // labels of other bodies from the same segmentation
};
/// Hexahedra from `corner` to `corner` + `size`.
struct HexBlock {
  Vec3d size{0.1, 0.1, 0.1};  // [m]
  Vec3d corner;               // [m]
  Int3 count{10, 10, 10};
};
using SolidSource = std::variant<SolidFile, ClosedSurface, LabeledOrgan, HexBlock>;

/// Sides of the box around a body, in the patient frame: low and high x, y, z.
enum class Side : std::uint8_t { kRight, kLeft, kFront, kBack, kFeet, kHead };

/// Order of the shape functions: nodes at corners, or also at the midpoints of edges.
enum class Elements : std::uint8_t { kLinear, kQuadratic };

/// Fixed vertices of a body: those near sides of its box, or inside a box.
struct HeldBy {
  std::vector<Side> sides{Side::kBack};
  double depth = 0.1;                       // distance from a side, relative to the box's extent [1]
  std::optional<std::array<Vec3d, 2>> box;  // low and high corner, instead of sides [m or 1]
  bool by_fraction = false;                 // true if `box` is in fractions of the body's box
};

/// Toughness of a region that takes the needle's own.
constexpr double kNeedlesOwn = -1;
/// Elements of another material, selected by their label in the file or the segmentation.
struct InsideScene {
  std::string name;
  int label = 0;
  sfem::Material material;
  double toughness = kNeedlesOwn;  // against needles [J/m²]
};
/// A sphere of another material.
struct InclusionScene {
  std::string name;
  Vec3d center;  // [m or 1]
  bool by_fraction = false;
  double radius = 0.01;  // [m]
  sfem::Material material;
  double toughness = kNeedlesOwn;  // against needles [J/m²]
};

/// The superposed patch that follows the tools.
struct PatchScene {
  double radius = 0.02;                                    // [m]
  bool radius_is_open = false;                             // true if the scene does not set the radius
  int refinement = 2;                                      // 1 = none
  double hysteresis = contact::FollowParams{}.hysteresis;  // distance that the contact moves before the patch
                                                           // follows, relative to the radius [1]
};

struct SfemScene {
  Device device = Device::kCpu;  // computes Green's functions
  std::string name;
  std::string source_location;  // "scene.toml:7:1: body.liver", for errors found later
  SolidSource source;
  sfem::Material material;
  std::vector<TissueRow> tissues;  // laws and values with their source, for the report
  double stiffness_scale = 1;      // of all moduli [1]
  std::vector<InsideScene> inside;
  std::vector<InclusionScene> inclusions;
  HeldBy fixed;
  bool is_free = false;   // no vertex is fixed: inertia, attachments and other bodies hold it
  double density = 1050;  // of such a body [kg/m³]
  Elements elements = Elements::kLinear;
  sfem::Formulation formulation = sfem::Formulation::kStandard;
  sfem::Precision precision = sfem::Precision::kSingle;
  PatchScene patch;
  Prony viscosity = one_pair(0, 0.5);
  bool rotations = false;
  std::optional<sfem::Law> law;  // of the patch's elements; none = linear
  TextureScene texture;
  double memory =
      4;  // limit for Green's functions, beyond which columns are computed on demand, and for a patch [GB]
  int contacts = 48;            // contact sites solved per tick, all tools together
  std::filesystem::path cache;  // a folder
  bool cached = true;
  std::filesystem::path seen;  // finer surface embedded in the body; may be empty
  double seen_scale = 1;       // meters per unit of that file
  UpAxis seen_up = UpAxis::kZ;
};

/// Shape of a tool: a ball, a capsule along its z axis, or a closed mesh.
struct BallTool {
  double radius = 0.006;  // [m]
};
struct RodTool {
  double radius = 0.003, half_length = 0.02;  // [m]
};
struct MeshTool {
  std::filesystem::path file;
  double scale = 1;  // meters per unit of the file
};
/// Two jaws that close while the tool holds.
struct ForcepsTool {
  std::filesystem::path file;  // of both jaws; empty = the phantom
  double scale = 1;            // meters per unit of the file
  double opening = 0.012;      // distance between the tips when open [m]
  double closing = 0.3;        // duration from open to closed, and back [s]
};
/// A needle, with its tip at the tool's origin and its shaft along the z axis.
struct NeedleTool {
  contact::Needle needle;
};
using ToolShape = std::variant<BallTool, RodTool, MeshTool, ForcepsTool, NeedleTool>;

/// Pose of a tool at a time.
struct PathRow {
  double time = 0;  // [s]
  Vec3d position;   // of the tool's origin [m]
  bool hold = false;
  std::array<double, 4> orientation{1, 0, 0, 0};  // unit quaternion w, x, y, z
};
struct GivenPath {
  std::vector<PathRow> rows;
  bool smooth = true;  // cubic between the rows instead of linear
};
struct PathFile {
  std::filesystem::path file;  // .csv: t, x, y, z [, hold [, qw, qx, qy, qz]]
  bool smooth = true;
};
/// Press along the surface normal, slide, and retreat. Applies to every body.
struct Press {
  Vec3d at, to;  // on the surface [m or 1]
  bool by_fraction = false;
  double depth = 0.005;      // of the tool's tip below the surface at rest [m]
  double start = 0.1;        // [s]
  double duration = 0.5;     // from contact to `depth`, and back [s]
  double hold = 0.2;         // at `at` before sliding, and at `to` after it [s]
  double slide = 0;          // from `at` to `to`; 0 = no sliding [s]
  int times = 1;             // presses one after the other, each with its retreat
  double clearance = 0.002;  // height of the tip above the surface before and after a press [m]
};
/// Press along the surface normal, grasp, pull outward and sideways, and release. Applies to every body.
struct Grasp {
  Vec3d at;  // on the surface [m or 1]
  bool by_fraction = false;
  double depth = 0.003;   // depth of the tool's tip below the surface at rest when it grasps [m]
  double pull = 0.01;     // height of the tip above the surface at rest [m]
  Vec3d aside;            // additional displacement of the tip along the surface [m]
  double start = 0.1;     // [s]
  double duration = 0.5;  // of the approach, of the pull, and of the retreat [s]
  double hold = 0.4;      // pause at both ends, while jaws close and open [s]
};
/// Recorded hand motion, tick by tick: see sim/tools/hand.hpp.
struct HandFile {
  std::filesystem::path file;
};
using ToolMotion = std::variant<GivenPath, PathFile, Press, Grasp, HandFile>;

struct ToolScene {
  std::string name;
  std::string source_location;
  BodyId body;
  ToolShape shape;
  double friction = 0.3;  // [1]
  ToolMotion motion;
  std::string device;  // preset of a haptic device whose limits apply; empty: none
};

}  // namespace turgor
