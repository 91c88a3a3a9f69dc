#include "turgor/sim/scene/scene_excision.hpp"

#include <algorithm>

#include "turgor/sim/scene/markups.hpp"
#include "turgor/sim/scene/scene_body.hpp"
#include "turgor/sim/scene/scene_incision.hpp"

namespace turgor {

namespace {

/// Center, direction and length from a line that was drawn in 3D Slicer.
void read_line(SceneTable& table, lattice::Excision& excision) {
  std::filesystem::path file;
  table.read_path("markups", file,
                  {"a line of 3D Slicer (`.mrk.json`) from one end of the piece to the other, instead of "
                   "`center`, `direction` and `length`",
                   "none"});
  if (file.empty()) return;
  const Result<Markup> markup = read_markup(file);
  if (!markup) return table.fail("markups", markup.error().message);
  if (!markup->is_line)
    return table.fail("markups", "a piece is given by a line: expected two points, found a curve");
  const Vec3d from = markup->points.front(), to = markup->points.back();
  excision.center = (from + to) / 2;
  excision.direction = to - from, excision.length = norm(to - from);
}

void read_center(SceneTable& table, IncisionScene& scene) {
  lattice::Excision& excision = *scene.blade.excision;
  scene.by_fraction = table.has("center_fraction");
  table.read("center", excision.center, within(-100, 100, "m"),
             {"center of the piece, on or near the skin", "required"});
  table.read(
      "center_fraction", excision.center, within(0, 1),
      {"instead of `center`: in fractions of the box around the body, as `from_fraction` of an incision",
       "none"});
  read_line(table, excision);
  const int given = table.has("center") + table.has("center_fraction") + table.has("markups");
  if (given == 0)
    table.require({"center", "center_fraction", "markups"}, "the center of the piece, on or near the skin");
  if (given > 1)
    table.fail(table.has("center") ? "center" : "center_fraction",
               "the center of a piece is given once: expected one of center, center_fraction and markups");
}

void read_size(SceneTable& table, IncisionScene& scene) {
  lattice::Excision& excision = *scene.blade.excision;
  table.read("direction", excision.direction, any_number("1"),
             "direction of its length; the part along the skin counts");
  table.read("angle", excision.angle, within(-360, 360, "degrees"),
             "turns the direction counter-clockwise, seen from outside");
  if (!(norm(excision.direction) > 0))
    table.fail("direction", "expected a direction, found a vector without length");
  if (!table.has("markups")) table.require({"length"}, "the length of the piece, along its direction");
  table.read("length", excision.length, inside(0, 1, "m"),
             {"length of the piece along the skin", "required"});
  table.require({"width"}, "the width of the piece; equal to the length for a disc");
  table.read(
      "width", excision.width, inside(0, 1, "m"),
      {"width of the piece. Two arcs of circles bound it, so that it is a disc if the width is its length",
       "required"});
  if (excision.width > excision.length && excision.length > 0)
    table.fail("width",
               fmt::format("the piece is wider than long: expected at most the length of {} m, found {} m",
                           excision.length, excision.width));
}

/// Refuses bodies that cannot lose a piece.
void check_excised_body(SceneTable& table, const LatticeScene& body) {
  const auto refuse = [&](const char* needed, const char* found) {
    table.fail("body", fmt::format("excisions need {}, found {} in body.{}", needed, found, body.name));
  };
  if (body.params.solver.method != lattice::Method::kVbd)
    refuse("solver.method = \"vbd\"", "\"pbd\"");
  else if (body.params.tissue.law != lattice::TissueLaw::kSolid)
    refuse("tissue made of solid cells", "tissue.law = \"springs\"");
  else if (body.device == Device::kGpu)
    table.fail("body", "excisions need world.device = \"cpu\", found \"gpu\"");
}

}  // namespace

IncisionScene read_excision(SceneTable table, const std::string& name, const Scene& scene) {
  IncisionScene made;
  table.begin_group("excision");
  table.describe("body", "", "required", "the name of a body with `model = \"lattice\"`");
  made.source_location = table.location();
  made.blade.name = name;
  made.blade.excision.emplace();
  table.require({"body"}, "the name of the body that loses the piece");
  made.body = read_body(table, "body", scene, {BodyKind::kLattice}).index;
  if (made.body >= 0 && std::size_t(made.body) < scene.lattice_bodies.size())
    check_excised_body(table, scene.lattice_bodies[std::size_t(made.body)]);
  read_center(table, made);
  read_size(table, made);
  table.read("depth", made.blade.depth, inside(0, 1, "m"), "depth of the floor below the skin");
  read_undermining(table, made.blade);
  table.read("start", made.blade.start, not_negative("s"), "start of the blade");
  table.read("duration", made.blade.duration, not_negative("s"),
             "duration of the cut along the outline; the piece then leaves the body. 0 = instantaneous");
  if (made.blade.start + made.blade.duration >= scene.duration)
    table.fail("start", fmt::format("the piece leaves the body at {} s, after the end of the run at {} s",
                                    made.blade.start + made.blade.duration, scene.duration));
  const bool is_taken = std::any_of(scene.incisions.begin(), scene.incisions.end(),
                                    [&](const IncisionScene& other) { return other.blade.name == name; });
  if (is_taken)
    table.fail("body", fmt::format("an incision of the scene has the name {}; expected another", name));
  table.finish();
  return made;
}

}  // namespace turgor
