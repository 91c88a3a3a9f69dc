#include "turgor/sim/scene/scene_suture.hpp"

#include <algorithm>
#include <numbers>

namespace turgor {

namespace {

/// Monofilament of nylon. The strength is the least mean knot-pull strength by USP <881> of
/// nonabsorbable threads of class I; the diameter is the middle of its range for the size.
struct ThreadPreset {
  const char* name;
  double diameter;  // [m]
  double strength;  // [N]
};
constexpr ThreadPreset kThreads[] = {{"nylon 5-0", 0.125e-3, 3.9},
                                     {"nylon 4-0", 0.175e-3, 5.9},
                                     {"nylon 3-0", 0.225e-3, 9.4},
                                     {"nylon 2-0", 0.320e-3, 14.1},
                                     {"nylon 0", 0.375e-3, 21.2}};
constexpr double kNylonYoung = 1.8e9;   // [Pa]
constexpr double kNylonFriction = 0.2;  // in tissue; an assumption

void read_wound(SceneTable& table, const Scene& scene, SutureScene& suture) {
  std::string wound;
  table.require({"wound"}, "the name of the incision or excision that is closed");
  table.read("wound", wound,
             {"name of the incision or excision that is closed; its body uses the VBD solver", "required"});
  std::vector<std::string> names;
  for (const IncisionScene& incision : scene.incisions) names.push_back(incision.blade.name);
  const auto found = std::find(names.begin(), names.end(), wound);
  if (found == names.end()) {
    if (!wound.empty())
      table.fail("wound",
                 fmt::format("the scene has no incision {}{}", wound, turgor::suggestion(wound, names)));
    return;
  }
  suture.incision = int(found - names.begin());
  const IncisionScene& incision = scene.incisions[std::size_t(suture.incision)];
  suture.body = incision.body;
  if (std::size_t(incision.body) >= scene.lattice_bodies.size()) return;  // refused with the incision
  const LatticeScene& body = scene.lattice_bodies[std::size_t(incision.body)];
  // solvers without springs at points
  if (body.params.solver.method != lattice::Method::kVbd)
    table.fail("wound",
               fmt::format("stitches need solver.method = \"vbd\", found \"pbd\" in body.{}", body.name));
  else if (body.device == Device::kGpu)
    table.fail("wound", "stitches need world.device = \"cpu\", found \"gpu\"");
  else if (incision.blade.width > 0)
    table.fail("wound", fmt::format("stitches close a cut, found a removed region: incision.{}.width is {} m",
                                    wound, incision.blade.width));
}

/// Points of a single stitch.
void read_through(SceneTable& table, SutureScene& suture) {
  constexpr const char* kPoints = "two to 64 points [x, y, z], consecutive ones distinct";
  table.describe(
      "through", "m", "none",
      "instead of a row: points `[[x, y, z], …]` of a single stitch in the CT, in the order of the "
      "thread, which closes to a loop",
      within(-100, 100, "m"));
  const toml::node* node = table.find("through");
  if (!node) return;
  const toml::array* rows = node->as_array();
  for (std::size_t n = 0; rows && n < rows->size(); n++) {
    const toml::node* row = rows->get(n);
    const std::vector<double> numbers =
        row->is_array() ? table.numbers("through", *row, within(-100, 100, "m")) : std::vector<double>();
    if (numbers.size() != 3) return table.fail_value("through", *row, kPoints);
    suture.through.push_back({numbers[0], numbers[1], numbers[2]});
  }
  bool is_valid = suture.through.size() >= 2 && suture.through.size() <= 64;
  for (std::size_t n = 0; is_valid && n < suture.through.size(); n++)
    is_valid = suture.through[n] != suture.through[(n + 1) % suture.through.size()];
  if (!is_valid) table.fail_value("through", *node, kPoints);
}

void read_pattern(SceneTable& table, SutureScene& suture) {
  table.read_choice<bool>("pattern", suture.is_running, {{"interrupted", false}, {"running", true}},
                          "`\"interrupted\"`: every stitch has its own thread and knot; `\"running\"`: one "
                          "thread makes all stitches "
                          "of a row, is knotted at its ends and slides between them");
  if (suture.is_running && !suture.through.empty())
    table.fail("pattern", "a single stitch through points is not running: expected a row, without `through`");
  if (suture.is_running && table.has("tension"))
    table.fail("pattern", "running sutures are pulled until closed: expected no `tension`");
}

void read_thread(SceneTable& table, SutureScene& suture) {
  table.read_choice("thread", suture.material, thread_names(),
                    "thread by its USP size: strength of a knot by USP <881>, stiffness from 1.8 GPa and the "
                    "diameter");
  set_thread(suture.material, suture);
  table.read("thread_stiffness", suture.thread.stiffness, inside(0, 1e5, "N"),
             {"force of the thread per strain, instead of the preset's", "of the preset"});
  table.read("thread_strength", suture.thread.strength, inside(0, 1e4, "N"),
             {"tension at which the thread breaks, instead of the preset's", "of the preset"});
  table.read("thread_friction", suture.thread.friction, within(0, 2),
             {"Coulomb coefficient between thread and tissue, for the sliding of a running suture", "0.2"});
  table.read("thread_length", suture.thread_length, within(0, 100, "m"),
             {"length of thread for all stitches of the row; 0 = as long as needed", "0"});
  table.read("pull_out", suture.pull_out, inside(0, 1e4, "N"),
             "force on a point of a stitch at which the thread tears out of the tissue");
}

void read_pull(SceneTable& table, const Scene& scene, SutureScene& suture) {
  std::string until;
  if (table.has("tension") && table.has("pull_until"))
    table.fail("tension", "stitches are pulled to a tension or until closed, not both");
  table.read("tension", suture.pull.tension, inside(0, 1e4, "N"),
             {"tension at which the stitches are knotted, instead of `pull_until`", "none"});
  table.read_choice("pull_until", until, {"closed"},
                    {"`\"closed\"`: a stitch is knotted when the lips meet under it", "\"closed\""});
  suture.pull.until_closed = !table.has("tension");
  const IncisionScene& incision = scene.incisions[std::size_t(suture.incision)];
  const double cut = incision.blade.start + incision.blade.duration;
  suture.pull.start = cut;
  table.read("start", suture.pull.start, not_negative("s"), {"start of the pull", "end of the cut"});
  table.read("duration", suture.pull.duration, inside(0, 3600, "s"),
             "duration of the pull to the tension, or to the length of the stitch in the CT");
  constexpr double kRounding = 1e-9;  // [s]
  if (suture.pull.start < cut - kRounding)
    table.fail("start", fmt::format("the stitches start at {} s, before the end of the cut at {} s",
                                    suture.pull.start, cut));
  else if (suture.pull.start >= scene.duration)
    table.fail("start", fmt::format("the stitches start at {} s, after the end of the run at {} s",
                                    suture.pull.start, scene.duration));
  suture.pull.start = std::max(suture.pull.start, cut);
}

}  // namespace

std::vector<std::string> thread_names() {
  std::vector<std::string> names;
  for (const ThreadPreset& preset : kThreads) names.emplace_back(preset.name);
  return names;
}

bool set_thread(const std::string& name, SutureScene& suture) {
  for (const ThreadPreset& preset : kThreads) {
    if (name != preset.name) continue;
    const double area = std::numbers::pi / 4 * preset.diameter * preset.diameter;
    suture.material = name, suture.diameter = preset.diameter;
    suture.thread = {
        .stiffness = kNylonYoung * area, .strength = preset.strength, .friction = kNylonFriction};
    return true;
  }
  return false;
}

SutureScene read_suture(SceneTable table, const std::string& name, const Scene& scene) {
  SutureScene suture;
  suture.name = name;
  table.begin_group("suture");
  suture.source_location = table.location();
  if (scene.incisions.empty()) {
    table.fail("wound",
               "a suture closes a wound: expected an [incision.NAME] or [excision.NAME] in the scene");
    return suture;
  }
  read_wound(table, scene, suture);
  // row or single stitch
  table.read("spacing", suture.spacing, inside(0, 1, "m"), "distance of the stitches along the wound");
  table.read(
      "bite", suture.bite, inside(0, 0.1, "m"),
      "distance of the points from the wound on each side; of the order of the lattice spacing or more");
  table.read("depth", suture.depth, inside(0, 0.1, "m"), "depth of the deep strand below the skin");
  read_through(table, suture);
  read_pattern(table, suture);
  read_thread(table, suture);
  read_pull(table, scene, suture);
  table.finish();
  return suture;
}

}  // namespace turgor
