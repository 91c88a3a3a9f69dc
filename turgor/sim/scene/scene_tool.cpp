#include "turgor/sim/scene/scene_tool.hpp"

#include "turgor/haptics/device_presets.hpp"
#include "turgor/sim/scene/scene_body.hpp"
#include "turgor/sim/tools/tool_path.hpp"

namespace turgor {

namespace {

BodyId read_touched(SceneTable& tool, const Scene& scene) {
  // touched body
  tool.require({"body"}, "the name of the body that is touched");
  const BodyId id = read_body(
      tool, "body", scene,
      {BodyKind::kSfem, BodyKind::kRhombus, BodyKind::kLattice, BodyKind::kCloth, BodyKind::kRigid});
  // a lattice needs a solver with contact forces
  const auto index = std::size_t(id.index);
  if (id.kind == BodyKind::kLattice && index < scene.lattice_bodies.size() &&
      scene.lattice_bodies[index].params.solver.method == lattice::Method::kPbd)
    tool.fail("body",
              fmt::format("{} has solver.method = \"pbd\", which has no contact forces in newtons; tools "
                          "need a lattice with \"vbd\"",
                          scene.lattice_bodies[index].name));
  // a cloth may not support contact
  if (id.kind == BodyKind::kCloth && index < scene.cloth_bodies.size())
    if (const std::string why = why_untouched(scene.cloth_bodies[index]); !why.empty())
      tool.fail("body", why);
  return id;
}

/// Forceps from the phantom, or from a file with both jaws.
ForcepsTool read_forceps(SceneTable& shape) {
  ForcepsTool forceps;
  const toml::node* node = shape.find("forceps");
  if (!node || node->value_or(std::string()) != "phantom")
    shape.read_path(
        "forceps", forceps.file,
        {"`\"phantom\"`, or a file with two jaws on either side of x = 0 and their tips at the origin",
         "none"});
  shape.read("scale", forceps.scale, inside(0, 1e6, "m"),
             "of `mesh` and `forceps`: meters per unit of the file");
  shape.read("opening", forceps.opening, inside(0, 1, "m"), "distance between the tips when open");
  shape.read("closing", forceps.closing, inside(0, 60, "s"), "duration from open to closed");
  return forceps;
}

/// Bending of a needle's shaft, and its bevel, which only a shaft that bends has.
void read_bending(SceneTable& shape, contact::Needle& needle) {
  bool bends = false;
  double young = contact::kSteel, stiffness = 0;
  shape.read("bends", bends, "of a needle: its shaft is an elastic beam, clamped at the end of its length");
  shape.read("shaft_young", young, inside(0, 1e13, "Pa"),
             "of a needle that bends: Young's modulus of its solid shaft");
  shape.read("bending_stiffness", stiffness, inside(0, 100, "N·m²"),
             {"of a needle that bends, for hollow shafts", "from diameter and shaft_young"});
  shape.read("bevel", needle.bevel, within(5, 90, "degrees"),
             "of a needle that bends: angle between the face of its tip and the shaft; 90 = no bevel");
  shape.read("bevel_toward", needle.bevel_toward, within(-360, 360, "degrees"),
             "side of the bevel's edge, about the shaft from the tool's x axis toward its y axis");
  for (const char* key : {"shaft_young", "bending_stiffness", "bevel", "bevel_toward"})
    if (!bends && shape.has(key))
      shape.fail(key, fmt::format("expected bends = true beside {}: a rigid needle does not follow it", key));
  if (bends) needle.bending = stiffness > 0 ? stiffness : contact::bending_stiffness(needle.diameter, young);
}

/// Needle of the scene. Its number of track points is limited.
NeedleTool read_needle(SceneTable& shape) {
  contact::Needle needle;
  shape.read(
      "needle", needle.length, inside(0, 0.3, "m"),
      {"a needle of this length, with its tip at the tool's origin and its shaft along z (docs/needle.md)",
       "none"});
  shape.read("diameter", needle.diameter, inside(0, 0.01, "m"), "of a needle: diameter of the shaft");
  shape.read("tip_angle", needle.tip_angle, inside(1, 120, "degrees"), "of a needle: full angle of its cone");
  shape.read("toughness", needle.toughness, within(0, 1e5, "J/m²"),
             "of a needle: work to tear the tissue, per area");
  shape.read("entry_toughness", needle.entry_toughness, within(0, 1e5, "J/m²"),
             "of a needle: the same of the surface or capsule that it punctures");
  needle.exit_toughness = needle.entry_toughness;
  shape.read(
      "exit_toughness", needle.exit_toughness, within(0, 1e5, "J/m²"),
      {"of a needle: the same of the far surface, through which it leaves the body", "`entry_toughness`"});
  shape.read("shaft_friction", needle.friction, within(0, 1e4, "N/m"),
             "of a needle: friction force per length of the shaft in the tissue");
  shape.read("spreading", needle.spreading, within(0, 1e8, "Pa"),
             "of a needle: pressure of the tissue on the tip, which spreads the crack");
  shape.read("spacing", needle.spacing, inside(1e-4, 0.01, "m"),
             "of a needle: distance of the points along its track");
  read_bending(shape, needle);
  const double points = needle.length / needle.spacing + 2;
  if (points > contact::kMostNeedlePoints)
    shape.fail("spacing",
               fmt::format("expected at most {} points along a needle, found {:.0f}: a length of {} m at a "
                           "spacing of {} m",
                           contact::kMostNeedlePoints, points, needle.length, needle.spacing));
  return {needle};
}

/// Refuses a second shape, which would be ignored without a message.
void check_one_shape(SceneTable& tool, SceneTable& shape) {
  std::string given;
  for (const char* kind : {"sphere", "capsule", "mesh", "forceps", "needle"}) {
    if (!shape.has(kind)) continue;
    if (!given.empty())
      shape.fail(kind, fmt::format("a tool has one shape: either {} or {}, not both", given, kind));
    given = given.empty() ? kind : given;
    shape.find(kind);
  }
  if (tool.has("shape"))
    shape.require({"sphere", "capsule", "mesh", "forceps", "needle"}, "a shape for the tool");
}

ToolShape read_shape(SceneTable& tool) {
  tool.require({"shape"}, "as in { sphere = 0.006 } [m]");
  SceneTable shape = tool.table("shape");
  const Allowed length = inside(0, 10, "m");
  shape.describe("capsule", "m", "none", "`[radius, half length]`, along the tool's z axis", length);
  check_one_shape(tool, shape);
  ToolShape made = BallTool{};
  if (shape.has("capsule")) {
    RodTool rod;
    const toml::node* node = shape.find("capsule");
    const std::vector<double> lengths = shape.numbers("capsule", *node, length);
    if (lengths.size() == 2)
      rod = {lengths[0], lengths[1]};
    else
      shape.fail_value("capsule", *node, "[radius, half length] [m]");
    made = rod;
  } else if (shape.has("forceps")) {
    made = read_forceps(shape);
  } else if (shape.has("needle")) {
    made = read_needle(shape);
  } else if (shape.has("mesh")) {
    MeshTool mesh;
    shape.read_path("mesh", mesh.file, {"a closed surface", "none"});
    shape.read("scale", mesh.scale, inside(0, 1e6, "m"),
               "of `mesh` and `forceps`: meters per unit of the file");
    made = mesh;
  } else {
    BallTool ball;
    shape.read("sphere", ball.radius, length, "a ball of this radius");
    made = ball;
  }
  shape.finish();
  return made;
}

bool read_smooth(SceneTable& tool) {
  bool smooth = true;
  tool.read_choice<bool>(
      "interpolation", smooth, {{"smooth", true}, {"linear", false}},
      "between rows of a path: `\"smooth\"` (monotone cubic, no overshoot) or `\"linear\"`");
  return smooth;
}

GivenPath read_rows(SceneTable& tool, const toml::array& array) {
  GivenPath path;
  std::vector<std::vector<double>> rows;
  for (const toml::node& row : array) {
    rows.push_back(tool.numbers("path", row, any_number("s and m")));
    if (rows.back().empty()) return path;  // a problem was added
  }
  Result<std::vector<PathRow>> made = path_rows(rows);
  if (!made) return tool.fail("path", made.error().message), path;
  path.rows = std::move(*made);
  path.smooth = read_smooth(tool);
  return path;
}

Vec3d read_target(SceneTable& press, const char* key, const char* key_fraction) {
  Vec3d target;
  press.read(key, target, within(-100, 100, "m"), {"moved to the nearest point of the surface", "none"});
  press.read(
      key_fraction, target, within(0, 1),
      {"instead: in fractions of the body's box. 0 or 1 along an axis means the surface seen from that side: "
       "`[0.5, 0, 0.5]` is the front, in the middle",
       "none"});
  return target;
}

Press read_press(SceneTable table) {
  Press press;
  table.require({"at", "at_fraction"}, "the position on the surface");

  // targets
  press.by_fraction = table.has("at_fraction");
  press.at = press.to = read_target(table, "at", "at_fraction");
  const bool slides = table.has("to") || table.has("to_fraction");
  if (slides) {
    press.to = read_target(table, "to", "to_fraction");
    press.slide = 1;
  }
  if ((table.has("at") || table.has("to")) && (table.has("at_fraction") || table.has("to_fraction")))
    table.fail(table.has("at") ? "at" : "to",
               "a press is given either in meters or in fractions, not in both");

  // depth and times
  table.read("depth", press.depth, inside(0, 1, "m"), "depth of the tool's tip below the surface at rest");
  table.read("start", press.start, not_negative("s"), "start of the motion");
  table.read("duration", press.duration, inside(0, 3600, "s"),
             "duration of the approach, and of the retreat");
  table.read("hold", press.hold, not_negative("s"), "pause before and after sliding, or pulling");
  table.read("times", press.times, within(1, 100), "presses one after the other, each with its retreat");
  if (slides)
    table.read("slide", press.slide, inside(0, 3600, "s"), "duration of the slide from `at` to `to`");
  table.finish();
  return press;
}

Grasp read_grasp(SceneTable table) {
  // grasp point in meters or fractions
  Grasp grasp;
  table.require({"at", "at_fraction"}, "the position on the surface");
  grasp.by_fraction = table.has("at_fraction");
  if (table.has("at") && grasp.by_fraction)
    table.fail("at", "a grasp is given either in meters or in fractions, not in both");
  grasp.at = read_target(table, "at", "at_fraction");
  // keys with limits
  table.read("depth", grasp.depth, inside(0, 1, "m"), "depth of the tool's tip below the surface at rest");
  table.read("pull", grasp.pull, within(0, 1, "m"),
             "height of the tip above the surface at rest, after the grasp");
  table.read("aside", grasp.aside, within(-1, 1, "m"), "lateral displacement of the tip, added to `pull`");
  table.read("start", grasp.start, not_negative("s"), "start of the motion");
  table.read("duration", grasp.duration, inside(0, 3600, "s"),
             "duration of the approach, and of the retreat");
  table.read("hold", grasp.hold, inside(0, 3600, "s"), "pause before and after sliding, or pulling");
  table.finish();
  return grasp;
}

HandFile read_hand_file(SceneTable& tool) {
  HandFile hand;
  tool.read_path(
      "hand", hand.file,
      {"a recorded hand motion: a `.csv` file with a row per tick, such as `forces.csv` of a run. It repeats "
       "the motion of the tool bit by bit, with jaws and grasps. Columns by name: `time_s`, `x_m`, `y_m`, "
       "`z_m`; optional: `axis_x_x` … `axis_z_z` (the tool's axes in the patient frame), `grip` (0 open, 1 "
       "closed), `hold` (0, 1) and `tool`, which selects the rows of this tool. The tool stays between two "
       "rows. On lattices, which compute forces once a frame, the motion repeats frame by frame",
       "one of `path`, `press`, `grasp`, `hand`"});
  return hand;
}

ToolMotion read_motion(SceneTable& tool) {
  // exactly one kind of motion is allowed
  const std::vector<std::string> kinds = {"path", "press", "grasp", "hand"};
  tool.require(kinds, "how the tool moves");
  std::string given;
  for (const std::string& kind : kinds) {
    if (!tool.find(kind)) continue;
    if (!given.empty()) tool.fail(kind, fmt::format("a tool has either a {} or a {}, not both", given, kind));
    given = given.empty() ? kind : given;
  }
  // press, grasp or recorded hand
  if (given == "press") return read_press(tool.table("press"));
  if (given == "grasp") return read_grasp(tool.table("grasp"));
  if (given == "hand") return read_hand_file(tool);
  // path rows in the scene or in a file
  const toml::node* node = tool.find("path");
  if (node && node->is_array()) return read_rows(tool, *node->as_array());
  PathFile file;
  tool.read_path("path", file.file,
                 {"rows `[[t, x, y, z], …]` in ascending time, or a `.csv` file of them, "
                  "whose column names may end with units (`t_ms`, `x_mm`). A fifth number other than 0 "
                  "grasps the tissue in contact; four more are the orientation as a quaternion w, x, y, z",
                  "one of `path`, `press`, `grasp`, `hand`"});
  file.smooth = read_smooth(tool);
  return file;
}

/// Haptic device of the hand that holds the tool.
void read_device(SceneTable& tool, std::string& device) {
  std::vector<std::string> names;
  for (const haptics::DevicePreset& preset : haptics::device_presets()) names.emplace_back(preset.name);
  static const std::string meaning = fmt::format(
      "haptic device whose limits of force and stiffness apply with `--real-time`, that of the workspace "
      "only to a simulated hand, and which the report compares with the tool's forces: `\"{}\"`",
      fmt::join(names, "\"`, `\""));
  tool.read_choice("device", device, names, {meaning.c_str(), "none"});
}

/// Reason why a body cannot have a needle; empty if it can.
std::string why_no_needle(const NeedleTool& needle, BodyId body, const Scene& scene) {
  if (body.kind == BodyKind::kSfem) return {};
  if (body.kind != BodyKind::kLattice)
    return fmt::format(
        "expected a body with model = \"sfem\" or \"lattice\" for a needle, found model = \"{}\", which has "
        "no needles yet",
        model_name(body.kind));
  if (std::size_t(body.index) >= scene.lattice_bodies.size()) return {};
  const LatticeScene& lattice = scene.lattice_bodies[std::size_t(body.index)];
  if (lattice.params.tissue.law == lattice::TissueLaw::kSprings)
    return fmt::format(
        "expected a lattice with tissue.law = \"solid\", \"exponential\" or \"ogden\" for a needle, found "
        "\"springs\" in {}: springs have no modulus around a shaft",
        lattice.name);
  if (lattice.device == Device::kGpu)
    return fmt::format(
        "expected world.device = \"cpu\" for a needle in a lattice, found \"gpu\": {} is solved on the GPU, "
        "which has no needles yet",
        lattice.name);
  if (needle.needle.bending > 0)
    return fmt::format(
        "expected bends = false for a needle in a lattice, found true: in {} the shaft is rigid, shafts bend "
        "in bodies with model = \"sfem\"",
        lattice.name);
  return {};
}

}  // namespace

std::string why_untouched(const ClothScene& cloth) {
  if (!cloth::uses_conjugate_gradients(cloth.params.solver.method))
    return fmt::format(
        "{} is solved by sweeps, which do not converge to the forces of taut cloth; tools need a cloth with "
        "solver.method = \"two_level\"",
        cloth.name);
  return {};
}

ToolScene read_tool_scene(SceneTable tool, const std::string& name, const Scene& scene) {
  ToolScene made;
  tool.begin_group("tool");
  made.name = name, made.source_location = tool.location();
  tool.describe("body", "", "required",
                "the name of a body with `model = \"sfem\"`, `\"rhombus\"`, `\"lattice\"`, `\"cloth\"` or "
                "`\"rigid\"`");
  made.body = read_touched(tool, scene);
  made.shape = read_shape(tool);
  if (const auto* needle = std::get_if<NeedleTool>(&made.shape); needle && tool.has("body"))
    if (const std::string why = why_no_needle(*needle, made.body, scene); !why.empty())
      tool.fail("shape", why);
  tool.read("friction", made.friction, within(0, 10),
            "Coulomb friction coefficient; rhombus chains have no friction");
  made.motion = read_motion(tool);
  read_device(tool, made.device);
  tool.finish();
  return made;
}

}  // namespace turgor
