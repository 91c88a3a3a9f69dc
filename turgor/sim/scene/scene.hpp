// Scene: the bodies, tools, cuts, duration and outputs of a run, as plain structs. Scenes are TOML files;
// docs/scene.md lists every key with unit and default. Nothing is loaded here.
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "turgor/core/result.hpp"
#include "turgor/io/files/image.hpp"
#include "turgor/io/mesh/mesh_files.hpp"
#include "turgor/models/lattice/cutting/incision.hpp"
#include "turgor/models/lattice/lattice.hpp"
#include "turgor/sim/scene/cloth_scene.hpp"
#include "turgor/sim/scene/ct_source.hpp"
#include "turgor/sim/scene/device.hpp"
#include "turgor/sim/scene/look_scene.hpp"
#include "turgor/sim/scene/organs_scene.hpp"
#include "turgor/sim/scene/rhombus_scene.hpp"
#include "turgor/sim/scene/rigid_scene.hpp"
#include "turgor/sim/scene/sfem_scene.hpp"
#include "turgor/sim/scene/suture_scene.hpp"
#include "turgor/sim/scene/texture_scene.hpp"
#include "turgor/sim/scene/tissue_row.hpp"

namespace turgor {

/// Resistance of a layer or region of a lattice to needles. Its tissue is given by exactly one of label, HU
/// and depth; a layer by depth comes before a label, a label before a range of HU. Layers by depth of
/// `layers` come last, and leave out bone.
struct NeedleLayerScene {
  std::string name;
  int label = 0;                            // of the segmentation; 0 = none
  std::optional<std::array<double, 2>> hu;  // [HU]
  double depth = 0;                // below the skin at rest, down to which it reaches; 0 = not given [m]
  double toughness = kNeedlesOwn;  // [J/m²]
  double friction = kNeedlesOwn;   // along the shaft, per length [N/m]
  bool is_of_layers = false;       // of `layers`, by depth
};

/// [body.NAME] with model = "lattice".
struct LatticeScene {
  std::string name;
  std::string source_location;  // "scene.toml:7:1: body.torso", for errors found later
  CtSource ct;
  std::filesystem::path labels;  // segmentation of the same patient; may be empty
  std::shared_ptr<const LabelVolume>
      given_labels;                       // labels given by the caller instead of a file; takes precedence
  std::filesystem::path direction_field;  // Langer's lines as a vector volume; may be empty
  std::filesystem::path fiber_field;      // directions of the cells' fibers, likewise
  double spacing = 0;                     // target spacing, instead of params.block; 0 = not given [m]
  std::string label_note;                 // set if label names are not from the file
  int only = 0;  // label whose largest component is the body, the rest becomes air; 0 = all tissue
  std::optional<HeldBy> held;  // additional fixed nodes, besides those of params
  bool has_gravity = true;
  double stiffness_scale = 1;  // of all moduli of the tissue [1]
  TextureScene texture;
  Device device = Device::kCpu;  // from the scene
  lattice::Params params;
  bool chooses_cells = false;      // the scene has tissue.partial_cells
  std::string whole_cells_reason;  // of whole cells that the scene does not choose
  std::vector<NeedleLayerScene> inside;
  std::vector<std::optional<Rgb>> layer_colors;  // of params.tissue.layers, on walls of wounds
  std::vector<TissueRow> tissues;                // laws and values with their source, for the report
};

/// [incision.NAME], or [excision.NAME] if the blade has one. Positions are in meters, or in fractions of the
/// box around the body.
struct IncisionScene {
  lattice::Incision blade;
  std::string source_location;
  int body = 0;  // index into Scene::lattice_bodies
  bool by_fraction = false;
};

/// Quantity that colors surfaces in pictures. Stretches exist on skin, of its area and of its most stretched
/// direction; pressure on touched bodies.
enum class SkinColor : std::uint8_t { kNone, kDisplacement, kStretch, kPressure, kPrincipalStretch };

/// [output]. File names are relative to the output folder; empty = not written.
struct OutputScene {
  double every = 0.5;             // interval of snapshots: meshes, recording, frames [s]
  int width = 720, height = 540;  // of pictures [pixels]
  SkinColor color = SkinColor::kDisplacement;
  std::string volume_rendering;  // tissue preset
  bool sections = true;
  std::string window = "abdomen";  // CT window of sections
  std::string deformed_ct, displacement, jacobian;
  std::optional<Int3> deformed_size;  // voxels; default: size of the CT
  bool conserve_mass = false;
  std::optional<std::pair<double, double>> color_range;  // limits of the color scale [m], [1] or [Pa]
  bool meshes = true;                                    // .vtu and .pvd
  bool vtkhdf = false;                                   // the same in one file per body
  bool obj = true;
  bool usd = false, gltf = false;  // surfaces of all snapshots in one file each
  MeshSpace mesh_space;            // of meshes, vtkhdf and obj
  bool recording = true;
  bool all_pictures = false;  // also whole bodies, color maps and sections of the whole CT
  bool frames = false;        // a picture of every view at every snapshot
  bool video = false;
  double video_speed = 1;   // simulated seconds per second of video
  bool video_full = false;  // full quality of pictures instead of the quick one
  bool legend = true;       // names of bodies and inclusions with their colors
};

/// [camera.NAME]: pictures from an additional camera.
struct CameraScene {
  std::string name;
  Vec3d from, at, up{0, 0, 1};  // [m], [m], any length
  double angle = 30;            // vertical field of view [degrees]
};

/// Value of a key as a report shows it.
struct SceneParameter {
  std::string key, value, unit;  // "body.torso.skin.tension", "45", "N/m"
  std::string source;            // "scene, line 7", "--set KEY" or "default"
};

struct Scene {
  std::filesystem::path file;
  std::string text;                        // of the file
  std::vector<std::string> overrides;      // key=value
  bool has_whole_cells = false;            // by default, as when its recording was made
  std::vector<std::string> notes;          // for the user: old names that the text or an override has
  std::vector<SceneParameter> parameters;  // with defaults
  Vec3d gravity;                           // patient frame [m/s²]
  double duration = 2;                     // [s]
  double frame_rate = 60;                  // steps per second [1/s]
  Device device = Device::kCpu;
  std::vector<LatticeScene> lattice_bodies;
  std::vector<IncisionScene> incisions;  // then excisions
  std::vector<SutureScene> sutures;
  std::vector<SfemScene> sfem_bodies;
  std::vector<RhombusScene> rhombus_bodies;
  std::vector<ToolScene> tools;
  std::vector<CameraScene> cameras;
  std::vector<ClothScene> cloth_bodies;
  std::vector<RigidScene> rigid_bodies;
  std::vector<AttachmentScene> attachments;
  std::vector<BodyContactScene> body_contacts;
  OutputScene output;
  LookScene look;
};

/// Number of steps of a run.
int frame_count(const Scene& scene);
/// True if a snapshot is taken after this many steps. The first and the last state always are.
bool is_snapshot(const Scene& scene, int frame);

/// Tissue presets of volume rendering and CT windows that a scene may name; view/ defines them.
const std::vector<std::string>& known_volume_presets();
const std::vector<std::string>& known_windows();

/// Reads a scene file and applies `key=value` overrides. The error lists all problems, one per line:
/// "FILE:LINE:COLUMN: KEY: expected …, found …".
Result<Scene> read_scene(const std::filesystem::path& file, const std::vector<std::string>& overrides = {});
/// The same for text in memory. `file` is used in errors and as the base of relative paths. Paths in
/// overrides are relative to the current folder or, if the file does not exist there, to `override_folder`.
Result<Scene> parse_scene(std::string_view text, const std::filesystem::path& file,
                          const std::vector<std::string>& overrides = {},
                          const std::filesystem::path& override_folder = {});

}  // namespace turgor
