#include "turgor/sim/scene/scene_organs.hpp"

#include <fmt/format.h>

#include "turgor/sim/scene/nearest_name.hpp"

namespace turgor {

namespace {

constexpr const char* kGround = "ground";

/// Finds a body by name; adds a problem if it does not exist.
std::optional<BodyId> find_body(SceneTable& table, const std::string& name, const Scene& scene) {
  std::optional<BodyId> found;
  std::vector<std::string> known;
  for_each_body(scene, [&](BodyId id, const auto& body) {
    known.push_back(body.name);
    if (body.name == name) found = id;
  });
  if (!found)
    table.fail("between", fmt::format("the scene has no body {}{}", name, turgor::suggestion(name, known)));
  return found;
}

/// Finds a body that [contact.NAME] can contain. Cloth touches its obstacles.
std::optional<BodyId> find_touching_body(SceneTable& table, const toml::node& node, const std::string& name,
                                         const Scene& scene) {
  const std::optional<BodyId> found = find_body(table, name, scene);
  if (!found || found->kind != BodyKind::kCloth) return found;
  table.fail_value("between", node,
                   fmt::format("bodies that are no cloth; {0} touches bodies that are its obstacles "
                               "(body.{0}.obstacle), and layers of its own mesh (collision.self): sheets of "
                               "one mesh file touch each other",
                               name));
  return {};
}

/// Refuses bodies whose solver has no springs and contacts at points of their surface.
void check_solver(SceneTable& table, const Scene& scene, const std::optional<BodyId>& id) {
  if (id && id->kind == BodyKind::kCloth) {
    const ClothScene& cloth = scene.cloth_bodies[std::size_t(id->index)];
    if (cloth.device == Device::kGpu)
      table.fail("between",
                 fmt::format("attachments of {0} need body.{0}.device = \"cpu\", found \"gpu\"", cloth.name));
  }
  if (!id || id->kind != BodyKind::kLattice) return;
  const LatticeScene& lattice = scene.lattice_bodies[std::size_t(id->index)];
  if (lattice.params.solver.method != lattice::Method::kVbd)
    table.fail(
        "between",
        fmt::format("coupled lattices need solver.method = \"vbd\", found \"pbd\" in body.{}", lattice.name));
  else if (lattice.device == Device::kGpu)
    table.fail("between", fmt::format("coupled lattices need world.device = \"cpu\", found \"gpu\", which "
                                      "steps {}",
                                      lattice.name));
}

/// Refuses attachments of cloth at points of a rigid body.
void check_cloth(SceneTable& table, const AttachmentScene& attachment) {
  if (attachment.other && attachment.other->kind == BodyKind::kCloth && !attachment.at.empty())
    table.fail("at", "cloth is tied where it is near: expected distance or box instead of at");
}

/// The two names of `between`; a problem if they are not two different texts.
std::vector<std::string> read_between(SceneTable& table, const char* meaning) {
  table.require({"between"}, "the names of two bodies");
  table.describe("between", "", "required", meaning);
  const toml::node* node = table.find("between");
  std::vector<std::string> names;
  if (!node) return names;
  if (node->is_array())
    for (const toml::node& name : *node->as_array()) names.push_back(name.value_or(std::string()));
  if (names.size() == 2 && !names[0].empty() && !names[1].empty() && names[0] != names[1]) return names;
  table.fail_value("between", *node, "two different names, as in [\"liver\", \"stomach\"]");
  return {};
}

std::optional<std::array<Vec3d, 2>> read_box(SceneTable& table) {
  table.describe("box", "m", "none",
                 "`[[x, y, z], [x, y, z]]`: only surface points of the first body in this box are tied; "
                 "required if the other is `\"ground\"`");
  const toml::node* node = table.find("box");
  if (!node) return {};
  std::vector<double> v;
  if (node->is_array())
    for (const toml::node& corner : *node->as_array())
      for (const double x : table.numbers("box", corner, any_number("m"))) v.push_back(x);
  if (v.size() == 6) return {{{{v[0], v[1], v[2]}, {v[3], v[4], v[5]}}}};
  table.fail_value("box", *node, "two corners, [[x, y, z], [x, y, z]]");
  return {};
}

/// Points of a rigid body that are tied, [x, y, z] or an array of such points.
std::vector<Vec3d> read_tied_points(SceneTable& table) {
  table.describe(
      "at", "m", "none",
      "`[x, y, z]` or an array of such points: points of the first body, a rigid one, that are tied "
      "instead of surface points. One point is a ball joint, two points are a hinge. They are tied to the "
      "same points of another rigid body, and to the nearest surface points of one that deforms, at most "
      "`distance` away");
  const toml::node* node = table.find("at");
  if (!node) return {};
  const std::string expected = "a point [x, y, z], or an array of points";
  if (!node->is_array() || node->as_array()->empty())
    return table.fail_value("at", *node, expected), std::vector<Vec3d>();
  // one point, or several
  std::vector<std::vector<double>> rows;
  if (node->as_array()->front().is_array())
    for (const toml::node& row : *node->as_array())
      rows.push_back(table.numbers("at", row, within(-100, 100, "m")));
  else
    rows.push_back(table.numbers("at", *node, within(-100, 100, "m")));
  std::vector<Vec3d> points;
  for (const std::vector<double>& row : rows) {
    if (row.size() != 3) return table.fail_value("at", *node, expected), std::vector<Vec3d>();
    points.push_back({row[0], row[1], row[2]});
  }
  return points;
}

/// Plane of the ground, for contact with it.
void read_ground(SceneTable& table, bool is_used, BodyContactScene& contact) {
  table.read("through", contact.through, within(-100, 100, "m"), "a point of the ground, which is a plane");
  table.read("normal", contact.normal, any_number(""), "normal of the ground, toward the body");
  if (!(norm(contact.normal) > 0)) table.fail("normal", "expected a direction that is not zero");
  if (!is_used)
    for (const char* key : {"through", "normal"})
      if (table.has(key)) table.fail(key, "only contact with \"ground\" has a plane");
}

bool is_fixed_body(const Scene& scene, const std::optional<BodyId>& id) {
  return !id || (id->kind == BodyKind::kRigid && scene.rigid_bodies[std::size_t(id->index)].is_fixed);
}

/// Refuses contact of two fixed bodies.
void check_fixed(SceneTable& table, const Scene& scene, BodyId body, const std::optional<BodyId>& other) {
  if (is_fixed_body(scene, body) && is_fixed_body(scene, other))
    table.fail("between", "neither of the two can move");
}

}  // namespace

AttachmentScene read_attachment(SceneTable table, const std::string& name, const Scene& scene) {
  AttachmentScene made{
      .name = name, .source_location = table.location(), .body = {}, .other = {}, .at = {}, .box = {}};
  table.begin_group("attachment");
  // bodies
  const std::vector<std::string> names =
      read_between(table, "the names of two bodies, or of one and `\"ground\"`");
  if (!names.empty()) {
    const std::size_t first = names[0] == kGround ? 1 : 0;
    const std::optional<BodyId> body = find_body(table, names[first], scene);
    made.body = body.value_or(BodyId{});
    if (names[1 - first] != kGround) made.other = find_body(table, names[1 - first], scene);
    check_solver(table, scene, body), check_solver(table, scene, made.other);
  }
  // tied points
  table.read(
      "distance", made.distance, inside(0, 1, "m"),
      "surface points of the first body are tied that are at most this far from the second one at rest");
  made.at = read_tied_points(table);
  made.box = read_box(table);
  check_cloth(table, made);
  const bool is_rigid = made.body.kind == BodyKind::kRigid;
  if (!made.at.empty() && !is_rigid) table.fail("at", "points are tied where the first body is rigid");
  if (!made.at.empty() && made.box) table.fail("box", "an attachment has points or a box, not both");
  if (!names.empty() && !made.other && !made.box && made.at.empty())
    table.fail("box", "an attachment to the ground needs a box: the surface points in it are tied");
  table.read("points", made.points, within(1, 400),
             "most springs; of more points some are chosen, and each takes the area around it");
  // spring
  table.require({"stiffness", "stiffness_per_area"}, "the stiffness of the springs");
  if (table.has("stiffness") && table.has("stiffness_per_area"))
    table.fail("stiffness", "an attachment has a stiffness or a stiffness per area, not both");
  table.read("stiffness", made.stiffness, positive("N/m"),
             {"of the whole attachment; its springs share it by area", "one of the two"});
  table.read("stiffness_per_area", made.stiffness_per_area, positive("N/m³"),
             {"instead: per area of the first body's surface", "one of the two"});
  table.read("slack", made.slack, within(0, 1, "m"),
             "distance that a point moves before its spring pulls; 0: springs pull and push at once");
  table.read(
      "break_force", made.break_force, positive("N"),
      {"force at which the whole attachment tears under even load; a spring breaks at its share", "never"});
  table.read("optional", made.is_optional,
             "an attachment without points within `distance` is left out, instead of an error");
  table.finish();
  return made;
}

BodyContactScene read_body_contact(SceneTable table, const std::string& name, const Scene& scene) {
  BodyContactScene made{
      .name = name, .source_location = table.location(), .body = {}, .other = {}, .through = {}};
  table.begin_group("contact");
  const std::vector<std::string> names = read_between(
      table,
      "the names of two bodies, or of one and `\"ground\"`; cloth touches the bodies that are its "
      "obstacles instead");
  if (!names.empty()) {
    const toml::node& node = *table.find("between");
    const std::size_t first = names[0] == kGround ? 1 : 0;
    const std::optional<BodyId> body = find_touching_body(table, node, names[first], scene);
    made.body = body.value_or(BodyId{});
    if (names[1 - first] != kGround) made.other = find_touching_body(table, node, names[1 - first], scene);
    if (body) check_fixed(table, scene, made.body, made.other);
    check_solver(table, scene, body), check_solver(table, scene, made.other);
  }
  const bool is_ground = !names.empty() && (names[0] == kGround || names[1] == kGround);
  read_ground(table, is_ground, made);
  table.read("optional", made.is_optional, "a contact of bodies that are far from each other is left out");
  table.read("friction", made.friction, within(0, 10), "Coulomb friction coefficient");
  table.read("gap", made.gap, within(0, 0.1, "m"),
             "distance that is kept between the surfaces; less where they are nearer at rest");
  table.read("sites", made.sites, within(1, 400),
             "most contact sites; of more touching vertices the deepest are kept, and the report says so");
  table.finish();
  return made;
}

}  // namespace turgor
