#include "turgor/sim/scene/scene_output.hpp"

#include <algorithm>
#include <map>

#include <fmt/format.h>

namespace turgor {

namespace {

bool is_plain(const std::string& name) { return name.find('/') == std::string::npos && name.front() != '.'; }

bool is_volume_file(const std::string& name) {
  for (const std::string_view ending : {".nii", ".nii.gz", ".nrrd", ".mha"})
    if (name.ends_with(ending) && name.size() > ending.size()) return true;
  return false;
}

/// Without an ending, and none of the folders that every run makes.
bool is_series_folder(const std::string& name) {
  return name.find('.') == std::string::npos && name != "frames" && name != "meshes";
}

/// The name of a volume file inside the output folder.
void read_volume_name(SceneTable& output, std::string_view key, std::string& name, Meaning meaning) {
  output.read(key, name, meaning);
  if (name.empty() || (is_plain(name) && is_volume_file(name))) return;
  output.fail(key,
              fmt::format("expected a file name without folders that ends in .nii, .nii.gz, .nrrd or .mha, "
                          "found \"{}\"",
                          name));
}

/// The same, or the name of a folder.
void read_ct_name(SceneTable& output, std::string_view key, std::string& name, Meaning meaning) {
  output.read(key, name, meaning);
  if (name.empty() || (is_plain(name) && (is_volume_file(name) || is_series_folder(name)))) return;
  output.fail(key, fmt::format("expected a file name without folders that ends in .nii, .nii.gz, .nrrd or "
                               ".mha, or a name without an ending for a DICOM series (not frames or meshes), "
                               "found \"{}\"",
                               name));
}

/// Refuses outputs of which one would overwrite another. Of several bodies, each has its own: "BODY-NAME".
void check_output_names(SceneTable& output, const Scene& scene) {
  std::map<std::string, std::string> owners;  // file -> the key that names it
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

/// `key = false` turns it off, `key = NAME` chooses.
void read_choice_or_off(SceneTable& table, std::string_view key, std::string& value,
                        const std::vector<std::string>& choices, Meaning meaning) {
  const toml::node* node = table.find(key);
  if (node && node->is_boolean() && !node->as_boolean()->get())
    value.clear();
  else
    table.read_choice(key, value, choices, meaning);
}

CameraScene read_camera(SceneTable table, const std::string& name) {
  table.begin_group("camera");
  CameraScene camera{.name = name, .from = {}, .at = {}};
  table.require({"from"}, "where the camera is, [x, y, z] [m]");
  table.read("from", camera.from, any_number("m"), "where the camera is");
  table.require({"at"}, "what it looks at, [x, y, z] [m]");
  table.read("at", camera.at, any_number("m"), "what it looks at: the middle of its pictures");
  table.read("up", camera.up, any_number("1"), "what is up in its pictures; any length");
  table.read("angle", camera.angle, within(1, 150, "degrees"),
             "from the lower to the upper edge of its pictures");
  if (table.has("from") && table.has("at") && !(norm(camera.from - camera.at) > 0))
    table.fail("at", "the camera is where it looks at; expected another place");
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
  SceneTable snapshots = output.table("snapshots");
  snapshots.read(
      "every", out.every, positive("s"),
      "pictures, meshes and recorded states; the first and the last state always; at most 10 000 of them");
  snapshots.describe("size", "pixels", "`[720, 540]`", "of pictures; at most as many as 4096 × 4096 has",
                     within(64, 8192));
  if (const toml::node* size = snapshots.find("size")) {
    const std::vector<double> pixels = snapshots.numbers("size", *size, within(64, 8192, "pixels"));
    if (pixels.size() == 2)
      out.width = int(pixels[0]), out.height = int(pixels[1]);
    else
      snapshots.fail_value("size", *size, "[width, height] [pixels]");
  }
  snapshots.finish();
  output.read_choice<SkinColor>("color", out.color,
                                {{"none", SkinColor::kNone},
                                 {"displacement", SkinColor::kDisplacement},
                                 {"stretch", SkinColor::kStretch},
                                 {"pressure", SkinColor::kPressure}},
                                "what colours surfaces: `\"displacement\"`, `\"stretch\"` (lattices), "
                                "`\"pressure\"` (of tools on sfem bodies), `\"none\"`");
  if (out.color == SkinColor::kStretch && scene.lattice_bodies.empty())
    output.fail("color", "stretch is known of the skin of a lattice, and the scene has none");
  if (out.color == SkinColor::kPressure && scene.sfem_bodies.empty())
    output.fail("color", "pressure is known of bodies with model = \"sfem\", and the scene has none");
  output.describe("color_range", "m, 1 or Pa",
                  "`[0, 0.01]`, stretch `[-0.2, 0.2]`, pressure 0 to Young's modulus", "ends of the colours");
  if (const toml::node* range = output.find("color_range")) {
    const std::vector<double> ends = output.numbers("color_range", *range, any_number("m, 1 or Pa"));
    if (ends.size() == 2 && ends[0] < ends[1])
      out.color_range = {ends[0], ends[1]};
    else
      output.fail_value("color_range", *range,
                        "[low, high] of the displacement [m], the stretch [1] or the pressure [Pa]");
  }
  read_choice_or_off(output, "volume_rendering", out.volume_rendering, known_volume_presets(),
                     {"the CT before and after as a picture of one tissue: `\"skin\"`, `\"soft tissue\"`, "
                      "`\"muscle\"`, `\"bone\"`, `\"lung\"`, or `false`",
                      "false"});
  output.read_choice<bool>(
      "pictures", out.all_pictures, {{"main", false}, {"all", true}},
      "`\"main\"`: wounds and pressed places from near, before and after; `\"all\"`: also bodies as a whole, "
      "which the page shows in three dimensions, in colours, and sections of the CT. A replay draws them "
      "later, too (`--set output.pictures=all`)");
  output.read("sections", out.sections,
              "sections of the CT through every cut, before and after, where `deformed_ct` or `pictures = "
              "\"all\"` asks for it");
  output.read_choice(
      "window", out.window, known_windows(),
      "grey values of sections: `\"abdomen\"`, `\"bone\"`, `\"lung\"`, `\"brain\"`, `\"air\"`");
  read_ct_name(
      output, "deformed_ct", out.deformed_ct,
      "a file name: the CT as it would be scanned now (`.nii`, `.nii.gz`, `.nrrd`, `.mha`); or a name "
      "without an ending: a folder, with a DICOM series that keeps the patient, the study and the frame "
      "of reference of the series that it was made of, and opens beside it");
  read_volume_name(
      output, "displacement", out.displacement,
      "a file name: for each voxel where its tissue came from, minus where it is (mm, LPS; what ITK "
      "calls a displacement field transform)");
  read_volume_name(output, "jacobian", out.jacobian, "a file name: volume now over volume in the CT");
  check_output_names(output, scene);
  if (output.has("deformed_size")) {
    Int3 size{1, 1, 1};
    output.read("deformed_size", size, within(1, 4096, "voxels"),
                {"of the deformed CT and the fields", "the CT's"});
    out.deformed_size = size;
  }
  output.read("conserve_mass", out.conserve_mass, "divide densities by the local change of volume");
  output.read("meshes", out.meshes,
              "the surface at every snapshot as `.vtu`, tools and the forces on them, and `meshes.pvd` for "
              "ParaView. Vertex i is vertex i of the mesh that the scene names; of sfem bodies the array "
              "`mesh vertex` says which it is");
  output.read(
      "vtkhdf", out.vtkhdf,
      "the same in one file a body, `meshes/NAME.vtkhdf`, with every snapshot as a step, for ParaView "
      "5.12 and VTK 9.3 on; with `meshes = false` instead of the many");
  output.read(
      "obj", out.obj,
      "the final surface as OBJ, numbered likewise; of bodies that tools touch, under the largest force");
  output.read_choice<bool>("mesh_unit", out.mesh_space.is_mm, {{"m", false}, {"mm", true}},
                           "of `meshes`, `vtkhdf` and `obj`: `\"m\"` or `\"mm\"`; 3D Slicer wants `\"mm\"`. "
                           "Displacements are in the same unit, which is in the array's name");
  output.read_choice<bool>(
      "mesh_frame", out.mesh_space.is_ras, {{"LPS", false}, {"RAS", true}},
      "of `meshes`, `vtkhdf` and `obj`: `\"LPS\"` as DICOM, or `\"RAS\"`. The files say which "
      "(`SPACE`), and 3D Slicer heeds that");
  output.read("recording", out.recording,
              "`recording.h5`, for `turgor run --replay` and for Python: see [recording.md](recording.md)");
  output.read("frames", out.frames,
              "`frames/NAME-….png`, a picture at every snapshot of the whole, of every cut from near and "
              "from every camera; "
              "a replay draws them later, too (`--set output.frames=true`). Without, the first and the last "
              "stand side by side in `NAME-before-after.png`, and the page plays the run");
  output.read("video", out.video,
              "`video.mp4`, when ffmpeg is there; with several cuts, `video-NAME.mp4` of each from near; the "
              "page plays the run without");
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
