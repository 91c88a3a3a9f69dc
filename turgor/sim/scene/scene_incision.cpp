#include "turgor/sim/scene/scene_incision.hpp"

#include "turgor/sim/scene/markups.hpp"
#include "turgor/sim/scene/scene_body.hpp"

namespace turgor {

namespace {

/// Points of a curve: at least two, consecutive ones distinct.
std::vector<Vec3d> read_points(SceneTable& table, std::string_view key, const Allowed& allowed) {
  const toml::node* node = table.find(key);
  if (!node) return {};
  constexpr const char* kExpected = "at least two points [x, y, z], consecutive ones distinct";
  std::vector<Vec3d> points;

  // rows of three numbers
  const toml::array* rows = node->as_array();
  for (std::size_t n = 0; rows && n < rows->size(); n++) {
    const toml::node* row = rows->get(n);
    if (!row->is_array() || row->as_array()->size() != 3) {
      table.fail_value(key, *row, kExpected);
      return {};
    }
    const std::vector<double> numbers = table.numbers(key, *row, allowed);
    if (numbers.size() != 3) return {};
    points.push_back({numbers[0], numbers[1], numbers[2]});
  }

  // distinct neighbors
  bool same = false;
  for (std::size_t n = 1; n < points.size(); n++) same |= points[n] == points[n - 1];
  if (points.size() < 2 || same) table.fail_value(key, *node, kExpected);
  return points;
}

/// Path of a cut from a file of 3D Slicer. It replaces every other path of the cut.
void read_markups(SceneTable& table, const std::filesystem::path& file, lattice::Incision& blade) {
  for (const char* replaced : {"from", "to", "path", "from_fraction", "to_fraction", "path_fraction"})
    table.find(replaced);  // known, and not read
  const Result<Markup> markup = read_markup(file);
  if (!markup) return table.fail("markups", markup.error().message);
  blade.from = markup->points.front(), blade.to = markup->points.back();
  blade.path = markup->is_line ? std::vector<Vec3d>() : markup->points;
}

/// Path of a cut, in meters or in fractions of the body's box.
void read_cut_path(SceneTable& table, IncisionScene& incision) {
  const bool fractions = incision.by_fraction, curve = table.has("path") || table.has("path_fraction");
  const char* from = fractions ? "from_fraction" : "from";
  const char* to = fractions ? "to_fraction" : "to";
  const char* path = fractions ? "path_fraction" : "path";
  const Allowed allowed = fractions ? within(0, 1) : within(-100, 100, "m");
  lattice::Incision& blade = incision.blade;

  // a curve
  if (curve) {
    blade.path = read_points(table, path, allowed);
    if (table.has(from) || table.has(to))
      table.fail(table.has(from) ? from : to,
                 fmt::format("a cut has either from and to or a {}, not both", path));
    if (blade.path.size() > 1) blade.from = blade.path.front(), blade.to = blade.path.back();
    return;
  }

  // a straight cut
  table.require(fractions ? std::vector<std::string>{from}
                          : std::vector<std::string>{"from", "from_fraction", "path", "markups"},
                fractions ? "the start of the cut, 0 to 1 along the body's box" : "the start of the cut");
  table.require(fractions ? std::vector<std::string>{to} : std::vector<std::string>{"to", "to_fraction"},
                fractions ? "the end of the cut, 0 to 1 along the body's box" : "the end of the cut");
  const std::size_t known_problems = table.problem_count();
  if (fractions) {
    table.read("from_fraction", blade.from, allowed,
               "instead of `from`: in fractions of the box around the body, so that one scene fits every "
               "patient. 0 or 1 along an axis means the surface of the body seen from that side: `[0.5, 0, "
               "0.4]` is the front, in the middle");
    table.read("to_fraction", blade.to, allowed, "instead of `to`");
  } else {
    table.read("from", blade.from, allowed, {"start of the cut, on or near the skin", "required"});
    table.read("to", blade.to, allowed, {"end of the cut", "required"});
  }
  const bool is_read = table.problem_count() == known_problems && table.has(from) && table.has(to);
  if (is_read && blade.from == blade.to) table.fail("to", "the cut has no length: it ends where it starts");
}

}  // namespace

void read_undermining(SceneTable& incision, lattice::Incision& blade) {
  SceneTable table = incision.table("undermine");
  lattice::Undermining& undermine = blade.undermine;
  table.read("width", undermine.width, within(0, 0.5, "m"),
             "width of the skin that is freed from the tissue below it, on both sides of a cut or around an "
             "excision; 0: none");
  table.read("depth", undermine.depth, within(0, 1, "m"),
             {"depth of the freed surface below the skin; at most the depth of the cut",
              "half the depth of the cut"});
  table.finish();
  if (!table.has("depth")) undermine.depth = 0.5 * blade.depth;
  if (undermine.width == 0) return;
  if (!(undermine.depth > 0) || undermine.depth > blade.depth)
    table.fail("depth", fmt::format("expected more than 0 and at most the depth of the cut, {} m, found {} m",
                                    blade.depth, undermine.depth));
  if (blade.width > 0)
    table.fail("width", "a removed region has no lips to undermine: remove undermine, or width of the cut");
}

IncisionScene read_incision(SceneTable table, const std::string& name, const Scene& scene) {
  // body to cut
  IncisionScene incision;
  table.begin_group("incision");
  table.describe("body", "", "required", "the name of a body with `model = \"lattice\"`");
  incision.source_location = table.location();
  lattice::Incision& blade = incision.blade;
  blade.name = name;
  table.require({"body"}, "the name of the body that is cut");
  incision.body = read_body(table, "body", scene, {BodyKind::kLattice}).index;
  // path in meters or fractions
  const bool meters = table.has("from") || table.has("to") || table.has("path");
  incision.by_fraction = table.has("from_fraction") || table.has("to_fraction") || table.has("path_fraction");
  table.describe(
      "path", "m", "none",
      "instead of `from` and `to`: points `[[x, y, z], …]` on or near the skin, which a smooth curve "
      "interpolates; equal first and last points close it",
      within(-100, 100, "m"));
  table.describe("path_fraction", "", "none", "the same in fractions of the body's box, as `from_fraction`",
                 within(0, 1));
  std::filesystem::path markups;
  table.read_path(
      "markups", markups,
      {"a line or curve of 3D Slicer (`.mrk.json`) in the patient frame of the CT, instead of all "
       "other paths of the cut",
       "none"});
  if (!markups.empty()) {
    incision.by_fraction = false;
    read_markups(table, markups, blade);
  } else if (incision.by_fraction && meters) {
    // all keys of the path are known, so that one mistake has one message
    for (const char* key : {"from", "to", "path", "from_fraction", "to_fraction", "path_fraction"})
      table.find(key);
    table.fail(
        table.has("from") ? "from"
        : table.has("to") ? "to"
                          : "path",
        "a cut is given either in meters or in fractions, not in both; from and to together, given with "
        "--set, replace the fractions of the scene");
  } else {
    read_cut_path(table, incision);
  }
  // keys with limits
  table.read("depth", blade.depth, inside(0, 1, "m"), "depth below the skin");
  table.read(
      "tilt", blade.tilt, within(-75, 75, "degrees"),
      "angle of the blade from upright: its edge leans to the right of its direction, seen from outside. A "
      "closed clockwise path that leans inward cuts out a fragment");
  table.read("start", blade.start, not_negative("s"), "start of the blade");
  table.read("duration", blade.duration, not_negative("s"), "duration of the cut; 0 = instantaneous");
  table.read("width", blade.width, within(0, 1, "m"),
             "0 cuts edges; else width of the static region of the paper, which is removed from the body");
  table.read("through_bone", blade.through_bone,
             "cuts through bone; `false`: the blade stops above it, and the report says where and how deep");
  read_undermining(table, blade);
  // check combinations of keys
  if (blade.width > 0 && (!blade.path.empty() || blade.tilt != 0))
    table.fail("width", "a removed region is straight and upright: remove path and tilt");
  if (blade.start >= scene.duration)
    table.fail("start", fmt::format("the cut starts at {} s, after the end of the run at {} s", blade.start,
                                    scene.duration));
  table.finish();
  return incision;
}

}  // namespace turgor
