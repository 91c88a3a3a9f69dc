#include "turgor/sim/scene/scene_output.hpp"

#include <algorithm>
#include <map>

#include <fmt/format.h>

#include "turgor/io/mesh/surface_animation.hpp"
#include "turgor/sim/scene/scene_look.hpp"

namespace turgor {

namespace {

bool is_plain(const std::string& name) { return name.find('/') == std::string::npos && name.front() != '.'; }

bool is_volume_file(const std::string& name) {
  for (const std::string_view ending : {".nii", ".nii.gz", ".nrrd", ".mha"})
    if (name.ends_with(ending) && name.size() > ending.size()) return true;
  return false;
}

/// Number of snapshots of a run. Their interval is a whole number of frames.
int snapshot_count(const Scene& scene) {
  int count = 0;
  for (int frame = 0; frame <= frame_count(scene); frame++) count += is_snapshot(scene, frame);
  return count;
}

/// True for names without an ending that differ from the folders of every run.
bool is_series_folder(const std::string& name) {
  return name.find('.') == std::string::npos && name != "frames" && name != "meshes";
}

/// Name of a volume file inside the output folder.
void read_volume_name(SceneTable& output, std::string_view key, std::string& name, Meaning meaning) {
  output.read(key, name, meaning);
  if (name.empty() || (is_plain(name) && is_volume_file(name))) return;
  output.fail(key,
              fmt::format("expected a file name without folders that ends in .nii, .nii.gz, .nrrd or .mha, "
                          "found \"{}\"",
                          name));
}

/// Name of a volume file or of a folder for a DICOM series.
void read_ct_name(SceneTable& output, std::string_view key, std::string& name, Meaning meaning) {
  output.read(key, name, meaning);
  if (name.empty() || (is_plain(name) && (is_volume_file(name) || is_series_folder(name)))) return;
  output.fail(key, fmt::format("expected a file name without folders that ends in .nii, .nii.gz, .nrrd or "
                               ".mha, or a name without an ending for a DICOM series (not frames or meshes), "
                               "found \"{}\"",
                               name));
}

/// Refuses outputs that would overwrite each other. With several bodies, files are named "BODY-NAME".
void check_output_names(SceneTable& output, const Scene& scene) {
  std::map<std::string, std::string> owners;  // file -> key that names it
  const OutputScene& out = scene.output;
  for (const auto& [key, name] :
       {std::pair("deformed_ct", out.deformed_ct), std::pair("displacement", out.displacement),
        std::pair("jacobian", out.jacobian)}) {
    if (name.empty()) continue;
    for (const LatticeScene& body : scene.lattice_bodies) {
      const bool alone = scene.lattice_bodies.size() == 1;
      const std::string file = alone ? name : body.name + "-" + name;
      const std::string owner =
          alone ? fmt::format("output.{}", key) : fmt::format("output.{} of body.{}", key, body.name);
      const auto [earlier, added] = owners.try_emplace(file, owner);
      if (added) continue;
      return output.fail(key, fmt::format("{} and {} would be the same file, {}; expected different names",
                                          earlier->second, owner, file));
    }
  }
}

/// Choice that `key = false` turns off.
void read_choice_or_off(SceneTable& table, std::string_view key, std::string& value,
                        const std::vector<std::string>& choices, Meaning meaning) {
  const toml::node* node = table.find(key);
  if (node && node->is_boolean() && !node->as_boolean()->get())
    value.clear();
  else
    table.read_choice(key, value, choices, meaning);
}

CameraScene read_camera(SceneTable table, const std::string& name) {
  // keys with limits
  table.begin_group("camera");
  CameraScene camera{.name = name, .from = {}, .at = {}};
  table.require({"from"}, "the camera's position, [x, y, z] [m]");
  table.read("from", camera.from, any_number("m"), "position of the camera");
  table.require({"at"}, "the point that it looks at, [x, y, z] [m]");
  table.read("at", camera.at, any_number("m"), "point that it looks at, the center of its pictures");
  table.read("up", camera.up, any_number("1"), "up direction of its pictures; any length");
  table.read("angle", camera.angle, within(1, 150, "degrees"), "vertical field of view");
  // reject degenerate views
  if (table.has("from") && table.has("at") && !(norm(camera.from - camera.at) > 0))
    table.fail("at", "from and at are the same point; expected different ones");
  if (!(norm(camera.up) > 0)) table.fail("up", "expected a direction, found a vector without length");
  table.finish();
  return camera;
}

}  // namespace

void read_cameras(SceneTable cameras, Scene& scene) {
  for (const std::string& name : cameras.names()) {
    const bool cut = std::any_of(scene.incisions.begin(), scene.incisions.end(),
                                 [&](const IncisionScene& incision) { return incision.blade.name == name; });
    if (cut || name == "skin" || name == "body")
      cameras.fail(name, "other pictures of the run have this name; expected another");
    scene.cameras.push_back(read_camera(cameras.table(name), name));
  }
  cameras.finish();
}

void read_output(SceneTable output, Scene& scene) {
  OutputScene& out = scene.output;
  output.begin_group("output");

  // snapshots
  SceneTable snapshots = output.table("snapshots");
  snapshots.read("every", out.every, positive("s"),
                 "interval of pictures, meshes and recorded states; the first and the last state are always "
                 "included; at "
                 "most 10 000");
  snapshots.describe("size", "pixels", "`[720, 540]`",
                     "size of pictures; at most as many pixels as 4096 × 4096", within(64, 8192));
  if (const toml::node* size = snapshots.find("size")) {
    const std::vector<double> pixels = snapshots.numbers("size", *size, within(64, 8192, "pixels"));
    if (pixels.size() == 2)
      out.width = int(pixels[0]), out.height = int(pixels[1]);
    else
      snapshots.fail_value("size", *size, "[width, height] [pixels]");
  }
  snapshots.finish();

  // colors and pictures
  output.read_choice<SkinColor>(
      "color", out.color,
      {{"none", SkinColor::kNone},
       {"displacement", SkinColor::kDisplacement},
       {"stretch", SkinColor::kStretch},
       {"largest_stretch", SkinColor::kPrincipalStretch},
       {"pressure", SkinColor::kPressure}},
      "quantity that colors surfaces: `\"displacement\"`, `\"stretch\"` (area strain of lattices), "
      "`\"largest_stretch\"` (of their skin's most stretched direction), "
      "`\"pressure\"` (tools on sfem bodies), `\"none\"`");
  const bool is_stretch = out.color == SkinColor::kStretch || out.color == SkinColor::kPrincipalStretch;
  if (is_stretch && scene.lattice_bodies.empty())
    output.fail("color", "stretch needs the skin of a lattice body, and the scene has no lattice body");
  if (out.color == SkinColor::kPressure && scene.sfem_bodies.empty())
    output.fail("color", "pressure needs a body with model = \"sfem\", and the scene has no such body");
  output.describe(
      "color_range", "m, 1 or Pa",
      "`[0, 0.01]`, stretch `[-0.2, 0.2]`, largest stretch `[1, 1.3]`, pressure 0 to Young's modulus",
      "limits of the color scale");
  if (const toml::node* range = output.find("color_range")) {
    const std::vector<double> ends = output.numbers("color_range", *range, any_number("m, 1 or Pa"));
    if (ends.size() == 2 && ends[0] < ends[1])
      out.color_range = {ends[0], ends[1]};
    else
      output.fail_value("color_range", *range,
                        "[low, high] of the displacement [m], the stretch [1] or the pressure [Pa]");
  }
  read_choice_or_off(
      output, "volume_rendering", out.volume_rendering, known_volume_presets(),
      {"volume rendering of one tissue of the CT, before and after: `\"skin\"`, `\"soft tissue\"`, "
       "`\"muscle\"`, `\"bone\"`, `\"lung\"`, or `false`",
       "false"});
  output.read_choice<bool>(
      "pictures", out.all_pictures, {{"main", false}, {"all", true}},
      "`\"main\"`: close-ups of wounds and contacts, before and after; `\"all\"`: also whole bodies (which "
      "the "
      "page shows in 3D), color maps, and sections of the CT. A replay can draw them later "
      "(`--set output.pictures=all`)");
  output.read(
      "sections", out.sections,
      "sections of the CT through every cut, before and after, if `deformed_ct` is set or `pictures = "
      "\"all\"`");
  output.read_choice("window", out.window, known_windows(),
                     "CT window of sections: `\"abdomen\"`, `\"bone\"`, `\"lung\"`, `\"brain\"`, `\"air\"`");

  // volumes
  read_ct_name(
      output, "deformed_ct", out.deformed_ct,
      "file name of the CT resampled in the deformed state (`.nii`, `.nii.gz`, `.nrrd`, `.mha`). A name "
      "without "
      "an ending makes a folder with a DICOM series, which keeps the patient, the study and the frame of "
      "reference of the source series and opens next to it");
  read_volume_name(
      output, "displacement", out.displacement,
      "file name of the displacement field (mm, LPS): for each voxel the rest position of its tissue minus "
      "its present position, continued into the air around it. It is a displacement field transform of ITK, "
      "which warps the CT to the deformed one");
  read_volume_name(output, "jacobian", out.jacobian,
                   "file name of the Jacobian determinant: present volume over volume in the CT");
  check_output_names(output, scene);
  if (output.has("deformed_size")) {
    Int3 size{1, 1, 1};
    output.read("deformed_size", size, within(1, 4096, "voxels"),
                {"size of the deformed CT and the fields", "the CT's"});
    out.deformed_size = size;
  }
  output.read("conserve_mass", out.conserve_mass, "divides densities by the local change of volume");

  // meshes
  output.read("meshes", out.meshes,
              "surfaces, tools and the forces on them at every snapshot as `.vtu`, and `meshes.pvd` for "
              "ParaView. Vertex i is vertex i of the mesh that the scene names; for sfem bodies the array "
              "`mesh vertex` maps to it");
  output.read(
      "vtkhdf", out.vtkhdf,
      "the same in one file per body, `meshes/NAME.vtkhdf`, with a time step per snapshot, for ParaView 5.12 "
      "and VTK 9.3 or later; `meshes = false` omits the `.vtu` files");
  output.read("obj", out.obj,
              "the final surface as OBJ, with the same vertex numbers; for touched bodies, the surface under "
              "the largest "
              "force");
  output.read(
      "usd", out.usd,
      "surfaces of bodies, wounds and tools at every snapshot as USD, in one file `surfaces.usda`: see "
      "[out-to-other-programs.md](out-to-other-programs.md)");
  output.read("gltf", out.gltf, "the same as glTF 2.0, in one file `surfaces.glb`; at most 1000 snapshots");
  if (const int count = out.gltf ? snapshot_count(scene) : 0; std::size_t(count) > kMostGltfSamples)
    output.fail("gltf", fmt::format("expected at most {} snapshots for glTF, found {}; raise "
                                    "output.snapshots.every, or use usd",
                                    kMostGltfSamples, count));
  output.read_choice<bool>(
      "mesh_unit", out.mesh_space.is_mm, {{"m", false}, {"mm", true}},
      "unit of `meshes`, `vtkhdf` and `obj`: `\"m\"` or `\"mm\"`, which 3D Slicer expects. "
      "Displacements have the same unit, which is in the array's name");
  output.read_choice<bool>("mesh_frame", out.mesh_space.is_ras, {{"LPS", false}, {"RAS", true}},
                           "frame of `meshes`, `vtkhdf` and `obj`: `\"LPS\"` as DICOM, or `\"RAS\"`. The "
                           "files state it (`SPACE`), "
                           "and 3D Slicer reads it");
  output.read(
      "recording", out.recording,
      "writes `recording.h5`, for `turgor run --replay` and for Python: see [recording.md](recording.md)");
  output.read(
      "frames", out.frames,
      "`frames/NAME-….png`: at every snapshot a picture of the whole scene, a close-up of every cut and "
      "one from every camera. A replay can draw them later (`--set output.frames=true`). Without them, "
      "`NAME-before-after.png` shows the first and the last state, and the page plays the run");
  output.read(
      "video", out.video,
      "`video.mp4`, if ffmpeg is installed; with several cuts, a close-up `video-NAME.mp4` of each. The "
      "page plays the run without it");
  output.read("video_speed", out.video_speed, within(0.01, 100, "1"),
              "simulated seconds per second of video: 0.25 is slow motion. Slow videos show more frames, at "
              "most `frame_rate`");
  output.read_choice<bool>("video_quality", out.video_full, {{"quick", false}, {"full", true}},
                           "`\"quick\"`: one pass; `\"full\"`: shadows, ambient occlusion and smooth edges "
                           "as in pictures, about ten times slower");
  output.read("legend", out.legend,
              "names of bodies and inclusions with their colors, in pictures and the window, if there are "
              "at least two");
  read_cutaway(output, scene);
  output.finish();
}

const std::vector<std::string>& known_volume_presets() {
  static const std::vector<std::string> kPresets = {"skin", "soft tissue", "muscle", "bone", "lung"};
  return kPresets;
}

const std::vector<std::string>& known_windows() {
  static const std::vector<std::string> kWindows = {"abdomen", "bone", "lung", "brain", "air"};
  return kWindows;
}

}  // namespace turgor
