#include "turgor/sim/scene/scene.hpp"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>

#include "turgor/core/assert.hpp"
#include "turgor/io/files/input_file.hpp"
#include "turgor/sim/scene/organ_bodies.hpp"
#include "turgor/sim/scene/scene_alternatives.hpp"
#include "turgor/sim/scene/scene_body.hpp"
#include "turgor/sim/scene/scene_cells.hpp"
#include "turgor/sim/scene/scene_cloth.hpp"
#include "turgor/sim/scene/scene_excision.hpp"
#include "turgor/sim/scene/scene_incision.hpp"
#include "turgor/sim/scene/scene_lattice.hpp"
#include "turgor/sim/scene/scene_look.hpp"
#include "turgor/sim/scene/scene_organs.hpp"
#include "turgor/sim/scene/scene_output.hpp"
#include "turgor/sim/scene/scene_overrides.hpp"
#include "turgor/sim/scene/scene_parameters.hpp"
#include "turgor/sim/scene/scene_renamed.hpp"
#include "turgor/sim/scene/scene_rhombus.hpp"
#include "turgor/sim/scene/scene_rigid.hpp"
#include "turgor/sim/scene/scene_sfem.hpp"
#include "turgor/sim/scene/scene_suture.hpp"
#include "turgor/sim/scene/scene_table.hpp"
#include "turgor/sim/scene/scene_tool.hpp"

namespace turgor {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLongestScene = 1 << 20;  // bytes; avoids parsing a CT given by mistake

/// Line of an unclosed multi-line string, 0 if there is none. The parser reports only an unexpected end of
/// file.
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

/// True if a line, counted from 1, has an unclosed quote.
bool is_open_string(std::string_view text, int line) {
  for (int n = 1; n < line && !text.empty(); n++)
    text.remove_prefix(std::min(text.find('\n'), text.size() - 1) + 1);
  char open = 0;
  for (std::size_t i = 0; i < text.size() && text[i] != '\n'; i++) {
    if (!open && text[i] == '#') return false;
    if (open == '"' && text[i] == '\\')
      i++;
    else if (open ? text[i] == open : text[i] == '"' || text[i] == '\'')
      open = open ? char(0) : text[i];
  }
  return open != 0;
}

void read_world(SceneTable world, Scene& scene) {
  world.begin_group("world");
  world.read(
      "gravity", scene.gravity, within(-1000, 1000, "m/s²"),
      "the CT shows the body as gravity has already shaped it; add only the change. Gravity does not act "
      "on held bodies of elements and chains");
  world.read("duration", scene.duration, inside(0, 3600, "s"), "simulated time");
  world.read("frame_rate", scene.frame_rate, within(1, 1000, "1/s"),
             "steps per second; a run has at most a million steps");
  world.read_choice<Device>(
      "device", scene.device, {{"cpu", Device::kCpu}, {"gpu", Device::kGpu}},
      "device on which lattices and cloth step and Green's functions are computed; `\"gpu\"`, NVIDIA only: "
      "lattices use `solver.ordering = \"colors\"` (the default there), cloth is solved by sweeps");
  world.finish();
}

/// Model of a body; empty, and a problem, if it is missing or unknown.
std::string read_model(SceneTable& body) {
  std::string model;
  if (!body.has("model"))
    body.fail("model", "model is missing: \"lattice\", \"sfem\", \"rhombus\", \"cloth\" or \"rigid\"");
  body.read_choice(
      "model", model, {"lattice", "sfem", "rhombus", "cloth", "rigid"},
      {"`\"lattice\"`: a body from a CT, for cutting and contact; `\"sfem\"`: a finite-element "
       "solid for haptic contact; `\"rhombus\"`: a surface for contact and forceps; `\"cloth\"`; "
       "`\"rigid\"`: a body that does not deform",
       "required"});
  return model;
}

bool have_one_segmentation(const LabeledOrgan& a, const LabeledOrgan& b) {
  return a.phantom ? b.phantom.has_value() : !b.phantom && a.file == b.file;
}

/// Notes for every body from a segmentation the labels of which other bodies are made.
void note_labels_of_others(std::vector<SfemScene>& bodies) {
  for (SfemScene& body : bodies) {
    auto* organ = std::get_if<LabeledOrgan>(&body.source);
    for (const SfemScene& other : bodies) {
      const auto* source = std::get_if<LabeledOrgan>(&other.source);
      if (!organ || !source || source->label == organ->label || !have_one_segmentation(*organ, *source))
        continue;
      organ->of_others.push_back(source->label);
      for (const InsideScene& region : other.inside) organ->of_others.push_back(region.label);
    }
  }
}

/// False if a body has no known model: what refers to it cannot be read then.
bool read_bodies(SceneTable bodies, Scene& scene) {
  bool are_known = true;
  std::vector<std::pair<std::string, SceneTable>> rhombi,
      cloths;  // read last, since they may refer to others
  for (const std::string& name : bodies.names()) {
    // sfem and lattice bodies
    SceneTable body = bodies.table(name);
    body.begin_group("body");
    const std::string model = read_model(body);
    are_known = are_known && !model.empty();
    if (model.empty()) continue;
    read_wet(body, name, scene.look);
    if (model == "sfem")
      scene.sfem_bodies.push_back(read_sfem_scene(body, name, scene.device));
    else if (model == "rhombus")
      rhombi.emplace_back(name, body);
    else if (model == "rigid")
      scene.rigid_bodies.push_back(read_rigid_scene(body, name));
    else if (model == "cloth")
      cloths.emplace_back(name, body);
    else
      scene.lattice_bodies.push_back(read_lattice_scene(body, name, scene.device));
  }

  note_labels_of_others(scene.sfem_bodies);

  // bodies that refer to others
  if (!are_known) return false;
  for (const auto& [name, body] : rhombi)
    scene.rhombus_bodies.push_back(read_rhombus_scene(body, name, scene));
  for (const auto& [name, body] : cloths) scene.cloth_bodies.push_back(read_cloth_scene(body, name, scene));
  bodies.finish();
  return true;
}

/// Incisions, then excisions.
void read_cuts(SceneTable incisions, SceneTable excisions, Scene& scene) {
  constexpr std::size_t kMostIncisions = 255;  // a cut edge stores its incision in a byte
  for (const std::string& name : incisions.names()) {
    if (name == "skin") incisions.fail(name, "pictures of the whole body have this name; expected another");
    if (scene.incisions.size() == kMostIncisions)
      return incisions.fail(name, "a scene holds at most 255 incisions");
    scene.incisions.push_back(read_incision(incisions.table(name), name, scene));
  }
  incisions.finish();
  for (const std::string& name : excisions.names()) {
    if (name == "skin") excisions.fail(name, "pictures of the whole body have this name; expected another");
    if (scene.incisions.size() == kMostIncisions)
      return excisions.fail(name, "a scene holds at most 255 incisions and excisions");
    scene.incisions.push_back(read_excision(excisions.table(name), name, scene));
  }
  excisions.finish();
}

void read_sutures(SceneTable sutures, Scene& scene) {
  for (const std::string& name : sutures.names())
    scene.sutures.push_back(read_suture(sutures.table(name), name, scene));
  sutures.finish();
}

void read_tools(SceneTable tools, Scene& scene) {
  for (const std::string& name : tools.names()) {
    scene.tools.push_back(read_tool_scene(tools.table(name), name, scene));
  }
  tools.finish();
}

void read_organs(SceneTable& root, Scene& scene) {
  if (root.has("organs")) read_organs_table(root.table("organs"));
  SceneTable attachments = root.table("attachment"), contacts = root.table("contact");
  for (const std::string& name : attachments.names())
    scene.attachments.push_back(read_attachment(attachments.named(name), name, scene));
  attachments.finish();
  for (const std::string& name : contacts.names())
    scene.body_contacts.push_back(read_body_contact(contacts.named(name), name, scene));
  contacts.finish();
  use_whole_cells_under_tools(scene);
}

/// Refuses scenes whose output would exhaust memory or disk.
void check_amounts(SceneTable& root, const Scene& scene) {
  constexpr double kMostFrames = 1e6, kMostSnapshots = 1e4, kMostPixels = 1 << 24, kMostVoxels = 1 << 30;
  SceneTable world = root.table("world"), output = root.table("output"),
             snapshots = output.table("snapshots");

  // frames
  const double frames = scene.duration * scene.frame_rate;
  if (frames > kMostFrames)
    world.fail("duration",
               fmt::format("{} s at {} frames a second are {:.0f} frames; expected at most {:.0f}: "
                           "a shorter run or a lower frame_rate",
                           scene.duration, scene.frame_rate, frames, kMostFrames));

  // snapshots
  const double count = scene.duration / std::max(scene.output.every, 1 / scene.frame_rate);
  if (count > kMostSnapshots)
    snapshots.fail(
        "every", fmt::format("a run of {} s would leave {:.0f} snapshots, each with pictures and "
                             "meshes; expected at most {:.0f}: every = {:.3g} or more",
                             scene.duration, count, kMostSnapshots, 1.01 * scene.duration / kMostSnapshots));

  // pixels and voxels
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

/// Notes that gravity is given, but acts on no body.
void note_idle_gravity(Scene& scene) {
  const auto feels = [](const LatticeScene& body) { return body.has_gravity; };
  const auto is_free = [](const SfemScene& body) { return body.is_free; };
  const bool acts = std::any_of(scene.lattice_bodies.begin(), scene.lattice_bodies.end(), feels) ||
                    std::any_of(scene.sfem_bodies.begin(), scene.sfem_bodies.end(), is_free) ||
                    !scene.cloth_bodies.empty() || !scene.rigid_bodies.empty();
  if (norm(scene.gravity) > 0 && !acts)
    scene.notes.push_back(
        "world.gravity acts on no body of this scene: held elements and chains rest as their mesh shows "
        "them");
}

void read_scene_table(SceneTable root, Scene& scene) {
  root.require({"body"}, "a scene needs at least one body, as in [body.torso]");
  read_world(root.table("world"), scene);
  if (!read_bodies(root.table("body"), scene)) return;
  read_cuts(root.table("incision"), root.table("excision"), scene);
  read_sutures(root.table("suture"), scene);
  read_tools(root.table("tool"), scene);
  read_organs(root, scene);
  read_cameras(root.table("camera"), scene);
  read_output(root.table("output"), scene);
  note_idle_gravity(scene);
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
  TURGOR_CHECK(scene.duration > 0 && scene.frame_rate > 0, "a scene has a duration and a frame rate");
  return std::max(1, int(std::lround(scene.duration * scene.frame_rate)));
}

bool is_snapshot(const Scene& scene, int frame) {
  TURGOR_CHECK(frame >= 0, "frames are counted from 0");
  const int interval = std::max(1, int(std::min(1e9, std::round(scene.output.every * scene.frame_rate))));
  return frame % interval == 0 || frame == frame_count(scene);
}

std::vector<SceneKey> scene_keys(std::string_view text, const fs::path& file) {
  SceneProblems problems{.file = file.string(), .folder = file.parent_path(), .lists_keys = true};
  Scene scene;
  try {
    toml::table root = toml::parse(text, file.string());
    rename_old_names(root, problems);
    add_organ_bodies(root, problems);
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
  problems.lists_keys = true;

  // TOML
  toml::table root;
  try {
    root = toml::parse(text, file.string());
  } catch (const toml::parse_error& error) {
    if (const int line = unclosed_text(text); line > 0)
      return Error{fmt::format("{}:{}: not TOML: a multi-line string that starts here is never closed",
                               file.string(), line)};
    const auto& begin = error.source().begin;
    if (is_open_string(text, int(begin.line)))
      return Error{
          fmt::format("{}:{}: not TOML: a quote in this line is never closed", file.string(), begin.line)};
    return Error{
        fmt::format("{}:{}:{}: not TOML: {}", file.string(), begin.line, begin.column, error.description())};
  }
  // old names before and after the overrides, which may bring old ones themselves
  for (const RenamedUse& use : rename_old_names(root, problems)) scene.notes.push_back(use.note);
  for (const std::string& override_text : overrides)
    if (const Status applied = apply_override(root, override_text, problems, scene.notes); !applied)
      return applied.error();
  replace_alternatives(root, problems);
  for (const RenamedUse& use : rename_old_names(root, problems)) scene.notes.push_back(use.note);

  add_organ_bodies(root, problems);

  // readers
  read_scene_table(SceneTable(root, "", problems), scene);
  if (!problems.problems.empty()) return all_of(problems);
  scene.notes.insert(scene.notes.end(), problems.notes.begin(), problems.notes.end());
  scene.parameters = scene_parameters(root, problems);
  return scene;
}

Result<Scene> read_scene(const fs::path& file, const std::vector<std::string>& overrides) {
  // file
  std::error_code error;
  if (fs::is_directory(file, error))
    return Error{fmt::format("{}: expected a scene file (.toml), found a folder", file.string())};
  if (const Status input = io::check_input(file); !input) return input.error();
  std::ifstream stream(file, std::ios::binary);
  if (!stream)
    return Error{fmt::format("{}: cannot read the scene: {}", file.string(), std::strerror(errno))};

  // text with a size limit
  std::string text(kLongestScene + 1, '\0');
  stream.read(text.data(), std::streamsize(text.size()));
  text.resize(std::size_t(stream.gcount()));
  if (text.size() > kLongestScene)
    return Error{fmt::format("{}: expected a scene file (.toml), found more than 1 MiB", file.string())};
  return parse_scene(text, file, overrides);
}

}  // namespace turgor
