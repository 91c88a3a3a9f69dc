#include "turgor/sim/scene/scene_cloth.hpp"

#include "turgor/sim/scene/scene_body.hpp"
#include "turgor/sim/scene/scene_up.hpp"

namespace turgor {

namespace {

const Allowed kPlace = within(-100, 100, "m");

GarmentFile read_garment(SceneTable& table) {
  GarmentFile garment;
  table.read_path("mesh", garment.file);
  table.read("scale", garment.scale, inside(0, 1e6, "m"));
  read_up(table, "up", garment.up);
  table.read("shift", garment.shift, kPlace);
  return garment;
}

cloth::Sheet read_sheet(SceneTable table) {
  cloth::Sheet sheet;
  table.require({"side"}, "the first side, [x, y, z] [m]");
  table.require({"up"}, "the other side, [x, y, z] [m]");
  table.read("corner", sheet.corner, kPlace);
  table.read("side", sheet.side, kPlace);
  table.read("up", sheet.up, kPlace);
  table.read("columns", sheet.columns, within(1, 4000));
  table.read("rows", sheet.rows, within(1, 4000));
  if (!(norm(cross(sheet.side, sheet.up)) > 0)) table.fail("up", "the two sides span no area");
  table.finish();
  return sheet;
}

void read_fabric(SceneTable table, cloth::Fabric& fabric) {
  table.read("density", fabric.density, positive("kg/m²"));
  table.read("warp", fabric.warp, positive("N/m"));
  table.read("weft", fabric.weft, positive("N/m"));
  table.read("shear", fabric.shear, not_negative("N/m"));
  table.read("bend", fabric.bend, not_negative("N/m"));
  table.read("direction", fabric.direction, any_number(""));
  table.finish();
}

void read_solver(SceneTable table, cloth::Solver& solver) {
  using cloth::Method;
  table.read_choice<Method>("method", solver.method,
                            {{"jacobi", Method::kJacobi},
                             {"chebyshev", Method::kChebyshev},
                             {"conjugate gradients", Method::kConjugateGradients}});
  table.read("sweeps", solver.sweeps, within(1, 10000));
  table.read("strain_limit", solver.strain_limit, within(0, 10));
  table.finish();
}

void read_collision(SceneTable table, cloth::Collision& collision) {
  table.read("self", collision.self);
  table.read("thickness", collision.thickness, inside(0, 1, "m"));
  table.read("friction", collision.friction, within(0, 10));
  table.read("iterations", collision.iterations, within(1, 1000));
  table.finish();
}

/// Rows of four numbers that begin with a time, ascending.
std::vector<std::array<double, 4>> read_rows(SceneTable& table, const char* key, const char* expected) {
  std::vector<std::array<double, 4>> rows;
  const toml::node* node = table.find(key);
  if (!node) return rows;
  if (!node->is_array()) return table.fail_value(key, *node, expected), rows;
  for (const toml::node& row : *node->as_array()) {
    const std::vector<double> v = table.numbers(key, row, any_number("s, then m or m/s"));
    if (v.empty()) return {};  // was complained about
    if (v.size() != 4 || (!rows.empty() && v[0] <= rows.back()[0]))
      return table.fail_value(key, row, expected), rows;
    rows.push_back({v[0], v[1], v[2], v[3]});
  }
  return rows;
}

void read_wind(SceneTable table, ClothScene& scene) {
  cloth::Air& air = scene.air;
  table.read("velocity", air.velocity, within(-200, 200, "m/s"));
  table.read("density", air.density, not_negative("kg/m³"));
  table.read("pressure", air.pressure, not_negative(""));
  table.read("drag", air.drag, not_negative(""));
  table.read("gusts", air.gusts, within(0, 5));
  table.read("gust_length", air.gust_length, inside(0, 1000, "m"));
  int seed = int(air.seed);
  table.read("seed", seed, within(0, 2e9));
  air.seed = std::uint64_t(seed);
  for (const auto& [t, x, y, z] :
       read_rows(table, "turns", "rows [t, x, y, z] of the mean wind from a time on, ascending [s] [m/s]"))
    scene.turns.push_back({t, {x, y, z}});
  table.finish();
}

BallScene read_ball(SceneTable shape) {
  BallScene ball;
  shape.read("centre", ball.centre, kPlace);
  shape.read("radius", ball.radius, inside(0, 10, "m"));
  shape.finish();
  return ball;
}

HoldScene read_hold(SceneTable table, const std::string& name) {
  HoldScene hold{.name = name};
  table.require({"vertices", "box", "ball"}, "which vertices are held");
  if (const toml::node* vertices = table.find("vertices"))
    for (const double v : table.numbers("vertices", *vertices, within(0, 1e9)))
      hold.vertices.push_back(int(v));
  if (const toml::node* corners = table.find("box")) {
    std::vector<double> v;
    if (corners->is_array())
      for (const toml::node& corner : *corners->as_array())
        for (const double x : table.numbers("box", corner, any_number("m"))) v.push_back(x);
    if (v.size() == 6)
      hold.box = {{{v[0], v[1], v[2]}, {v[3], v[4], v[5]}}};
    else
      table.fail_value("box", *corners, "two corners, [[x, y, z], [x, y, z]] [m]");
  }
  if (table.has("ball")) hold.ball = read_ball(table.table("ball"));
  if (hold.ball && (hold.box || !hold.vertices.empty()))
    table.fail("ball", "a hold takes either what is in the ball when it starts, or given vertices");
  table.read("start", hold.start, not_negative("s"));
  table.read("end", hold.end, positive("s"));
  hold.path = read_rows(table, "path", "rows [t, x, y, z] of displacements, ascending [s] [m]");
  table.finish();
  return hold;
}

ObstacleScene read_obstacle(SceneTable table, const std::string& name, const Scene& scene) {
  ObstacleScene obstacle{.name = name, .shape = PlaneScene{}};
  table.require({"plane", "sphere", "capsule", "mesh", "body"}, "what the cloth stays out of");
  if (table.has("sphere")) {
    obstacle.shape = read_ball(table.table("sphere"));
  } else if (table.has("capsule")) {
    RodScene rod;
    SceneTable shape = table.table("capsule");
    shape.read("from", rod.from, kPlace);
    shape.read("to", rod.to, kPlace);
    shape.read("radius", rod.radius, inside(0, 10, "m"));
    shape.finish();
    obstacle.shape = rod;
  } else if (table.has("mesh")) {
    obstacle.shape = read_garment(table);
  } else if (table.has("body")) {
    obstacle.shape =
        read_body(table, "body", scene, {BodyKind::kLattice, BodyKind::kSfem, BodyKind::kRhombus});
  } else {
    PlaneScene plane;
    SceneTable shape = table.table("plane");
    shape.read("through", plane.through, kPlace);
    shape.read("normal", plane.normal, any_number(""));
    if (!(norm(plane.normal) > 0)) shape.fail("normal", "expected a direction that is not zero");
    shape.finish();
    obstacle.shape = plane;
  }
  table.read("friction", obstacle.friction, within(0, 10));
  table.read("gap", obstacle.gap, within(0, 1, "m"));
  table.finish();
  return obstacle;
}

}  // namespace

ClothScene read_cloth_scene(SceneTable body, const std::string& name, const Scene& scene) {
  ClothScene cloth;
  cloth.name = name, cloth.place = body.place();
  body.require({"sheet", "mesh"}, "where the cloth's triangles come from");
  if (body.has("sheet") && body.has("mesh"))
    body.fail("mesh", "a cloth is either a sheet or a mesh, not both");
  if (body.has("sheet"))
    cloth.source = read_sheet(body.table("sheet"));
  else
    cloth.source = read_garment(body);
  read_fabric(body.table("fabric"), cloth.params.fabric);
  SceneTable damping = body.table("damping");
  damping.read("motion", cloth.params.damping.motion, not_negative("1/s"));
  damping.read("stretch", cloth.params.damping.stretch, not_negative("s"));
  damping.finish();
  read_solver(body.table("solver"), cloth.params.solver);
  read_collision(body.table("collision"), cloth.params.collision);
  body.read("weld", cloth.params.weld, within(0, 1, "m"));
  read_wind(body.table("wind"), cloth);
  SceneTable holds = body.table("hold");
  for (const std::string& hold : holds.names()) cloth.holds.push_back(read_hold(holds.table(hold), hold));
  SceneTable obstacles = body.table("obstacle");
  for (const std::string& obstacle : obstacles.names())
    cloth.obstacles.push_back(read_obstacle(obstacles.table(obstacle), obstacle, scene));
  body.finish();
  return cloth;
}

}  // namespace turgor
