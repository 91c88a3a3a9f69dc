// A scene: what is simulated, for how long, and what shall be left behind. Scenes are TOML files; every key,
// its unit and its default are listed in docs/scene.md. This is the plain struct that a file becomes; nothing
// is loaded here.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "turgor/core/result.hpp"
#include "turgor/io/mesh/mesh_files.hpp"
#include "turgor/models/lattice/cutting/incision.hpp"
#include "turgor/models/lattice/lattice.hpp"
#include "turgor/sim/scene/cloth_scene.hpp"
#include "turgor/sim/scene/ct_source.hpp"
#include "turgor/sim/scene/device.hpp"
#include "turgor/sim/scene/rhombus_scene.hpp"
#include "turgor/sim/scene/sfem_scene.hpp"

namespace turgor {

/// [body.NAME] with model = "lattice".
struct LatticeScene {
  std::string name;
  std::string place;  // "scene.toml:7:1: body.torso", for errors found later
  CtSource ct;
  std::filesystem::path labels;                     // a segmentation of the same patient; may be empty
  std::shared_ptr<const LabelVolume> given_labels;  // the same, of whoever makes the world; goes before
  std::filesystem::path direction_field;            // Langer's lines as a vector volume; may be empty
  double step = 0;             // lattice step to come near to, instead of params.block; 0 = not given [m]
  std::string label_note;      // when names of labels were not the file's own
  int only = 0;                // label whose largest part is the body, the rest becomes air; 0 = all is
  std::optional<HeldBy> held;  // besides what params fix
  bool has_gravity = true;
  Device device = Device::kCpu;  // of the scene
  lattice::Params params;
};

/// [incision.NAME]. `from` and `to` are in metres, or in fractions of the box around the body.
struct IncisionScene {
  lattice::Incision blade;
  std::string place;
  int body = 0;  // index into Scene::lattice_bodies
  bool by_fraction = false;
};

/// What colours surfaces in pictures: stretch is known of skin, pressure of bodies that tools touch.
enum class SkinColor : std::uint8_t { kNone, kDisplacement, kStretch, kPressure };

/// [output]. File names are inside the output folder; empty = not written.
struct OutputScene {
  double every = 0.5;             // snapshots: meshes, recording, frames [s]
  int width = 720, height = 540;  // of pictures [pixels]
  SkinColor color = SkinColor::kDisplacement;
  std::string volume_rendering;  // a tissue preset
  bool sections = true;
  std::string window = "abdomen";  // of grey values in sections
  std::string deformed_ct, displacement, jacobian;
  std::optional<Int3> deformed_size;  // voxels; the CT's own when not given
  bool conserve_mass = false;
  std::optional<std::pair<double, double>> color_range;  // ends of the colours [m], [1] or [Pa]
  bool meshes = true;                                    // .vtu and .pvd
  bool vtkhdf = false;                                   // the same in one file a body
  bool obj = true;
  MeshSpace mesh_space;  // of all three
  bool recording = true;
  bool all_pictures = false;  // also bodies as a whole and in colours, and sections of the whole CT
  bool frames = false;        // a picture of every view at every snapshot
  bool video = false;
};

/// [camera.NAME]: pictures from one more place.
struct CameraScene {
  std::string name;
  Vec3d from, at, up{0, 0, 1};  // [m], [m], any length
  double angle = 30;            // vertical [degrees]
};

struct Scene {
  std::filesystem::path file;
  std::string text;                    // of the file
  std::vector<std::string> overrides;  // key=value
  Vec3d gravity;                       // patient frame [m/s²]
  double duration = 2;                 // [s]
  double frame_rate = 60;              // steps a second [1/s]
  Device device = Device::kCpu;
  std::vector<LatticeScene> lattice_bodies;
  std::vector<IncisionScene> incisions;
  std::vector<SfemScene> sfem_bodies;
  std::vector<RhombusScene> rhombus_bodies;
  std::vector<ToolScene> tools;
  std::vector<CameraScene> cameras;
  std::vector<ClothScene> cloth_bodies;
  OutputScene output;
};

/// Steps of a whole run.
int frame_count(const Scene& scene);
/// Is a snapshot taken after this many steps? The first and the last state always are.
bool is_snapshot(const Scene& scene, int frame);

/// Tissue presets of volume rendering and windows of grey values that a scene may name; view/ knows what they
/// mean.
const std::vector<std::string>& known_volume_presets();
const std::vector<std::string>& known_windows();

/// Reads a scene file and applies `key=value` overrides. An error lists all that is wrong, a line each:
/// "FILE:LINE:COLUMN: KEY: expected …, found …".
Result<Scene> read_scene(const std::filesystem::path& file, const std::vector<std::string>& overrides = {});
/// The same for text that was read already; `file` gives names in errors and the folder of relative paths.
/// What overrides name is relative to the current folder or, when it is not there, to `override_folder`.
Result<Scene> parse_scene(std::string_view text, const std::filesystem::path& file,
                          const std::vector<std::string>& overrides = {},
                          const std::filesystem::path& override_folder = {});

}  // namespace turgor
