#include "turgor/sim/scene/scene.hpp"

#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>

#include "turgor/io/files/input_file.hpp"
#include "turgor/sim/scene/name.hpp"
#include "turgor/sim/scene/scene_body.hpp"
#include "turgor/sim/scene/scene_cloth.hpp"
#include "turgor/sim/scene/scene_incision.hpp"
#include "turgor/sim/scene/scene_lattice.hpp"
#include "turgor/sim/scene/scene_output.hpp"
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

/// Does a line, counted from 1, have a quote without its other?
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
  world.read_choice<Device>(
      "device", scene.device, {{"cpu", Device::kCpu}, {"gpu", Device::kGpu}},
      "where lattices and cloth step and Green's functions are computed; `\"gpu\"`, of NVIDIA: lattices need "
      "`solver.schedule = \"colours\"`, which they have unless it is said otherwise, cloth is solved by "
      "sweeps");
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
      scene.sfem_bodies.push_back(read_sfem_scene(body, name, scene.device));
    else if (model == "rhombus")
      rhombi.emplace_back(name, body);
    else if (model == "cloth")
      cloths.emplace_back(name, body);
    else
      scene.lattice_bodies.push_back(read_lattice_scene(body, name, scene.device));
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
  read_cameras(root.table("camera"), scene);
  read_output(root.table("output"), scene);
  check_amounts(root, scene);
  if (root.has("body") && root.table("body").keys().empty())
    root.fail("body", "a scene needs at least one body, as in [body.torso]");
  root.finish();
}

Error all_of(const SceneProblems& problems) {
  constexpr std::size_t kShown = 20;
  std::string text;
  std::size_t snapshot = 0;
  for (const auto& [line, message] : problems.problems) {
    if (snapshot == kShown) {
      text += fmt::format("\nand {} more", problems.problems.size() - kShown);
      break;
    }
    text += (snapshot++ ? "\n" : "") + message;
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
    if (is_open_string(text, int(begin.line)))
      return Error{
          fmt::format("{}:{}: not TOML: a quote in this line is never closed", file.string(), begin.line)};
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
