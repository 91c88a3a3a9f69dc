#include "turgor/sim/scene/scene.hpp"

#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>

#include "turgor/io/input_file.hpp"
#include "turgor/sim/scene/name.hpp"
#include "turgor/sim/scene/scene_body.hpp"
#include "turgor/sim/scene/scene_cloth.hpp"
#include "turgor/sim/scene/scene_incision.hpp"
#include "turgor/sim/scene/scene_lattice.hpp"
#include "turgor/sim/scene/scene_rhombus.hpp"
#include "turgor/sim/scene/scene_sfem.hpp"
#include "turgor/sim/scene/scene_table.hpp"
#include "turgor/sim/scene/scene_tool.hpp"

namespace turgor {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLongestScene = 1 << 20;  // bytes; a CT given by mistake is not worth parsing

/// The value of an override as TOML; a bare word, which is not TOML, is text.
toml::table parse_override_value(const std::string& text) {
  try {
    toml::table parsed = toml::parse("value = " + text);
    if (parsed.size() == 1) return parsed;
  } catch (const toml::parse_error&) {
  }
  return toml::table{{"value", text}};
}

/// The line where a text over several lines begins that has no end: of that, the parser says only that the
/// file is over. 0 = there is none.
int unclosed_text(std::string_view text) {
  for (std::size_t begin = 0;;) {
    begin = std::min(text.find("\"\"\"", begin), text.find("'''", begin));
    if (begin == text.npos) return 0;
    const std::size_t end = text.find(text.substr(begin, 3), begin + 3);
    if (end == text.npos)
      return 1 + int(std::count(text.begin(), text.begin() + std::ptrdiff_t(begin), '\n'));
    begin = end + 3;
  }
}

std::vector<std::string> split_key(std::string_view key) {
  std::vector<std::string> parts(1);
  for (const char c : key) {
    if (c == '.')
      parts.emplace_back();
    else
      parts.back() += c;
  }
  return parts;
}

std::vector<std::string> keys_of(const toml::table& table) {
  std::vector<std::string> keys;
  for (const auto& [key, value] : table) keys.emplace_back(key.str());
  return keys;
}

/// Takes a key out, as if the scene had not said it.
Status remove_key(toml::table& table, const std::string& name, const std::string& key) {
  if (table.erase(name) > 0) return Done{};
  return Error{fmt::format("--set {}=: the scene has no {} that could be removed{}", key, key,
                           suggestion(name, keys_of(table)))};
}

/// Puts `key=value` into the table, or removes the key when there is no value. Error: no key, or one that
/// leads through something that is no table.
Status apply_override(toml::table& root, const std::string& text, SceneProblems& problems) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0)
    return Error{fmt::format("--set {}: expected key=value, as in --set body.torso.block=2", text)};
  const std::string key = text.substr(0, equals), value = text.substr(equals + 1);
  const std::vector<std::string> parts = split_key(key);
  if (!std::all_of(parts.begin(), parts.end(), is_name))
    return Error{fmt::format("--set {}: expected a key of names with dots between them", key)};
  toml::table* table = &root;
  std::string path;
  for (std::size_t i = 0; i + 1 < parts.size(); i++) {
    // Bodies, incisions and tools are not made by naming them: a misspelt one would be silently alone.
    const bool names_one = i == 1 && (parts[0] == "body" || parts[0] == "incision" || parts[0] == "tool");
    if (names_one && !table->contains(parts[i]))
      return Error{fmt::format("--set {}: the scene has no {} {}{}", key, parts[0], parts[i],
                               suggestion(parts[i], keys_of(*table)))};
    path += (i ? "." : "") + parts[i];
    toml::node* next = table->get(parts[i]);
    if (!next) next = &table->insert(parts[i], toml::table{}).first->second;
    if (!next->is_table())
      return Error{fmt::format("--set {}: {} is {} in the scene, not a table", key, path, describe(*next))};
    table = next->as_table();
  }
  if (value.empty()) return remove_key(*table, parts.back(), key);
  table->insert_or_assign(parts.back(), std::move(*parse_override_value(value).get("value")));
  problems.overrides[key] = value;
  return Done{};
}

void read_world(SceneTable world, Scene& scene) {
  world.begin_group("world");
  world.read("gravity", scene.gravity, within(-1000, 1000, "m/s²"),
             "a CT shows the body as gravity has already shaped it; add only what changes");
  world.read("duration", scene.duration, inside(0, 3600, "s"), "simulated time");
  world.read("frame_rate", scene.frame_rate, within(1, 1000, "1/s"),
             "steps a second; a run has at most a million");
  world.finish();
}

void read_bodies(SceneTable bodies, Scene& scene) {
  std::vector<std::pair<std::string, SceneTable>> rhombi, cloths;  // read last: they may refer to others
  for (const std::string& name : bodies.names()) {
    SceneTable body = bodies.table(name);
    body.begin_group("body");
    std::string model = "lattice";
    body.require({"model"}, "\"lattice\", \"sfem\", \"rhombus\" or \"cloth\"");
    body.read_choice("model", model, {"lattice", "sfem", "rhombus", "cloth"},
                     "`\"lattice\"`, a body from a CT that is cut and touched; `\"sfem\"`, a solid that "
                     "tools touch; `\"rhombus\"`, a surface that tools touch and forceps pull; `\"cloth\"`");
    if (model == "sfem")
      scene.sfem_bodies.push_back(read_sfem_scene(body, name));
    else if (model == "rhombus")
      rhombi.emplace_back(name, body);
    else if (model == "cloth")
      cloths.emplace_back(name, body);
    else
      scene.lattice_bodies.push_back(read_lattice_scene(body, name));
  }
  for (const auto& [name, body] : rhombi)
    scene.rhombus_bodies.push_back(read_rhombus_scene(body, name, scene));
  for (const auto& [name, body] : cloths) scene.cloth_bodies.push_back(read_cloth_scene(body, name, scene));
  bodies.finish();
}

void read_incisions(SceneTable incisions, Scene& scene) {
  constexpr std::size_t kMostIncisions = 255;  // a cut edge remembers its incision in a byte
  for (const std::string& name : incisions.names()) {
    if (name == "skin") incisions.fail(name, "pictures of the whole body have this name; expected another");
    if (scene.incisions.size() == kMostIncisions)
      return incisions.fail(name, "a scene holds at most 255 incisions");
    scene.incisions.push_back(read_incision(incisions.table(name), name, scene));
  }
  incisions.finish();
}

void read_tools(SceneTable tools, Scene& scene) {
  for (const std::string& name : tools.names()) {
    scene.tools.push_back(read_tool_scene(tools.table(name), name, scene));
  }
  tools.finish();
}

/// The name of a volume file inside the output folder.
void read_volume_name(SceneTable& output, std::string_view key, std::string& name, Meaning meaning) {
  output.read(key, name, meaning);
  if (name.empty()) return;
  const bool plain = name.find('/') == std::string::npos && name.front() != '.';
  const auto ends_with = [&](std::string_view ending) {
    return name.ends_with(ending) && name.size() > ending.size();
  };
  if (plain && (ends_with(".nii") || ends_with(".nii.gz") || ends_with(".nrrd") || ends_with(".mha"))) return;
  output.fail(key,
              fmt::format("expected a file name without folders that ends in .nii, .nii.gz, .nrrd or .mha, "
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

void read_output(SceneTable output, Scene& scene) {
  OutputScene& out = scene.output;
  output.begin_group("output");
  SceneTable snapshots = output.table("snapshots");
  snapshots.read(
      "every", out.every, positive("s"),
      "pictures, meshes and recorded states; the first and the last state always; at most 10 000 of them");
  snapshots.describe("size", "pixels", "`[960, 720]`", "of pictures; at most as many as 4096 × 4096 has",
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
                     "`\"skin\"`, `\"soft tissue\"`, `\"muscle\"`, `\"bone\"`, `\"lung\"`, or `false`");
  output.read("sections", out.sections, "sections of the CT through every cut, before and after");
  output.read_choice(
      "window", out.window, known_windows(),
      "grey values of sections: `\"abdomen\"`, `\"bone\"`, `\"lung\"`, `\"brain\"`, `\"air\"`");
  read_volume_name(output, "deformed_ct", out.deformed_ct,
                   "a file name: the CT as it would be scanned now (`.nii`, `.nii.gz`, `.nrrd`, `.mha`)");
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
              "the surface at every snapshot as `.vtu`, and `meshes.pvd` for ParaView. Vertex i is vertex i "
              "of the mesh that the scene names; of sfem bodies the array `mesh vertex` says which it is");
  output.read(
      "obj", out.obj,
      "the final surface as OBJ, numbered likewise; of bodies that tools touch, under the largest force");
  output.read_choice<bool>("mesh_unit", out.mesh_space.is_mm, {{"m", false}, {"mm", true}},
                           "of `meshes` and `obj`: `\"m\"` or `\"mm\"`; 3D Slicer wants `\"mm\"`. "
                           "Displacements are in the same unit, which is in the array's name");
  output.read_choice<bool>("mesh_frame", out.mesh_space.is_ras, {{"LPS", false}, {"RAS", true}},
                           "of `meshes` and `obj`: `\"LPS\"` as DICOM, or `\"RAS\"`. The files say which "
                           "(`SPACE`), and 3D Slicer heeds that");
  output.read("recording", out.recording,
              "`recording.h5`, for `turgor run --replay` and for Python: see [recording.md](recording.md)");
  output.read("video", out.video, "`video.mp4` of the cut, when ffmpeg is there");
  output.finish();
}

/// What would fill memory or disk is said before it starts.
void check_amounts(SceneTable& root, const Scene& scene) {
  constexpr double kMostFrames = 1e6, kMostSnapshots = 1e4, kMostPixels = 1 << 24, kMostVoxels = 1 << 30;
  SceneTable world = root.table("world"), output = root.table("output"),
             snapshots = output.table("snapshots");
  const double frames = scene.duration * scene.frame_rate;
  if (frames > kMostFrames)
    world.fail("duration",
               fmt::format("{} s at {} frames a second are {:.0f} frames; expected at most {:.0f}: "
                           "a shorter run or a lower frame_rate",
                           scene.duration, scene.frame_rate, frames, kMostFrames));
  const double count = scene.duration / std::max(scene.output.every, 1 / scene.frame_rate);
  if (count > kMostSnapshots)
    snapshots.fail(
        "every", fmt::format("a run of {} s would leave {:.0f} snapshots, each with pictures and "
                             "meshes; expected at most {:.0f}: every = {:.3g} or more",
                             scene.duration, count, kMostSnapshots, 1.01 * scene.duration / kMostSnapshots));
  if (const double pixels = double(scene.output.width) * scene.output.height; pixels > kMostPixels)
    snapshots.fail("size",
                   fmt::format("{} x {} are {:.1f} million pixels; expected at most {:.1f} million, as "
                               "4096 x 4096 has",
                               scene.output.width, scene.output.height, 1e-6 * pixels, 1e-6 * kMostPixels));
  const Int3 size = scene.output.deformed_size.value_or(Int3{1, 1, 1});
  if (const double voxels = double(size.x) * size.y * size.z; voxels > kMostVoxels)
    output.fail("deformed_size",
                fmt::format("{} x {} x {} are {:.0f} million voxels; expected at most {:.0f} "
                            "million, as 1024 x 1024 x 1024 has",
                            size.x, size.y, size.z, 1e-6 * voxels, 1e-6 * kMostVoxels));
}

void read_scene_table(SceneTable root, Scene& scene) {
  root.require({"body"}, "a scene needs at least one body, as in [body.torso]");
  read_world(root.table("world"), scene);
  read_bodies(root.table("body"), scene);
  read_incisions(root.table("incision"), scene);
  read_tools(root.table("tool"), scene);
  read_output(root.table("output"), scene);
  check_amounts(root, scene);
  if (root.has("body") && root.table("body").keys().empty())
    root.fail("body", "a scene needs at least one body, as in [body.torso]");
  root.finish();
}

Error all_of(const SceneProblems& problems) {
  constexpr std::size_t kShown = 20;
  std::string text;
  std::size_t shown = 0;
  for (const auto& [line, message] : problems.problems) {
    if (shown == kShown) {
      text += fmt::format("\nand {} more", problems.problems.size() - kShown);
      break;
    }
    text += (shown++ ? "\n" : "") + message;
  }
  return {text};
}

}  // namespace

int frame_count(const Scene& scene) {
  return std::max(1, int(std::lround(scene.duration * scene.frame_rate)));
}

bool is_snapshot(const Scene& scene, int frame) {
  const int interval = std::max(1, int(std::min(1e9, std::round(scene.output.every * scene.frame_rate))));
  return frame % interval == 0 || frame == frame_count(scene);
}

const std::vector<std::string>& known_volume_presets() {
  static const std::vector<std::string> kPresets = {"skin", "soft tissue", "muscle", "bone", "lung"};
  return kPresets;
}

const std::vector<std::string>& known_windows() {
  static const std::vector<std::string> kWindows = {"abdomen", "bone", "lung", "brain", "air"};
  return kWindows;
}

std::vector<SceneKey> scene_keys(std::string_view text, const fs::path& file) {
  SceneProblems problems{.file = file.string(), .folder = file.parent_path(), .lists_keys = true};
  Scene scene;
  try {
    const toml::table root = toml::parse(text, file.string());
    read_scene_table(SceneTable(root, "", problems), scene);
  } catch (const toml::parse_error&) {
  }
  return std::move(problems.keys);
}

Result<Scene> parse_scene(std::string_view text, const fs::path& file,
                          const std::vector<std::string>& overrides, const fs::path& override_folder) {
  Scene scene;
  scene.file = file, scene.text = text, scene.overrides = overrides;
  SceneProblems problems;
  problems.file = file.string(), problems.folder = file.parent_path();
  problems.override_folder = override_folder;
  toml::table root;
  try {
    root = toml::parse(text, file.string());
  } catch (const toml::parse_error& error) {
    if (const int line = unclosed_text(text); line > 0)
      return Error{fmt::format("{}:{}: not TOML: the text that begins here with three quotes never ends",
                               file.string(), line)};
    const auto& begin = error.source().begin;
    return Error{
        fmt::format("{}:{}:{}: not TOML: {}", file.string(), begin.line, begin.column, error.description())};
  }
  for (const std::string& override_text : overrides)
    if (const Status applied = apply_override(root, override_text, problems); !applied)
      return applied.error();
  read_scene_table(SceneTable(root, "", problems), scene);
  if (!problems.problems.empty()) return all_of(problems);
  return scene;
}

Result<Scene> read_scene(const fs::path& file, const std::vector<std::string>& overrides) {
  std::error_code error;
  if (fs::is_directory(file, error))
    return Error{fmt::format("{}: expected a scene file (.toml), found a folder", file.string())};
  if (const Status input = io::check_input(file); !input) return input.error();
  std::ifstream stream(file, std::ios::binary);
  if (!stream)
    return Error{fmt::format("{}: cannot read the scene: {}", file.string(), std::strerror(errno))};
  std::string text(kLongestScene + 1, '\0');
  stream.read(text.data(), std::streamsize(text.size()));
  text.resize(std::size_t(stream.gcount()));
  if (text.size() > kLongestScene)
    return Error{fmt::format("{}: expected a scene file (.toml), found more than 1 MiB", file.string())};
  return parse_scene(text, file, overrides);
}

}  // namespace turgor
