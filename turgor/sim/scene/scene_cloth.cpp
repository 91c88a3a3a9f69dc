#include "turgor/sim/scene/scene_cloth.hpp"

#include "turgor/models/cloth/device/gpu_sheet.hpp"
#include "turgor/sim/scene/scene_body.hpp"
#include "turgor/sim/scene/scene_texture.hpp"
#include "turgor/sim/scene/scene_tissue.hpp"
#include "turgor/sim/scene/scene_up.hpp"

namespace turgor {

namespace {

const Allowed kPosition = within(-100, 100, "m");
const Allowed kStiffness = within(1e-12, 1e30, "N/m");  // a step that is not finite is undone and reported

GarmentFile read_garment(SceneTable& table) {
  GarmentFile garment;
  table.read_path("mesh", garment.file, {"or a surface: OBJ, STL, PLY, VTP, VTK", "none"});
  table.read("scale", garment.scale, inside(0, 1e6, "m"), "meters per unit of the file of `mesh`");
  garment.is_scale_given = table.has("scale");
  read_up(table, "up", garment.up);
  table.read("shift", garment.shift, kPosition, "after scaling and turning");
  return garment;
}

cloth::Sheet read_sheet(SceneTable table) {
  cloth::Sheet sheet;
  table.require({"side"}, "the first side, [x, y, z] [m]");
  table.require({"up"}, "the other side, [x, y, z] [m]");
  table.read("corner", sheet.corner, kPosition, "one corner of a rectangular sheet of triangles");
  table.read("side", sheet.side, kPosition, "its first side");
  table.read("up", sheet.up, kPosition, "its other side");
  table.read("columns", sheet.columns, within(1, 4000), "number of squares along `side`");
  table.read("rows", sheet.rows, within(1, 4000), "number of squares along `up`");
  if (!(norm(cross(sheet.side, sheet.up)) > 0)) table.fail("up", "the two sides span no area");
  table.finish();
  return sheet;
}

/// Sets the values of a preset.
void apply(const TissuePreset* preset, cloth::Fabric& fabric) {
  const std::pair<const char*, double*> values[] = {{"density", &fabric.density},
                                                    {"warp", &fabric.warp},
                                                    {"weft", &fabric.weft},
                                                    {"shear", &fabric.shear},
                                                    {"poisson", &fabric.poisson},
                                                    {"rigidity_warp", &fabric.rigidity_warp},
                                                    {"rigidity_weft", &fabric.rigidity_weft}};
  for (const auto& [key, value] : values) *value = value_or(preset, key, *value);
}

TissueRow row_of(SceneTable& table, const cloth::Fabric& fabric, const TissuePreset* preset) {
  const auto value = [&](const char* key, double number, const char* unit) -> LawValue {
    return {key, number, unit, table.has(key)};
  };
  const LawValue density = value("density", fabric.density, "kg/m²"),
                 warp = value("warp", fabric.warp, "N/m"), weft = value("weft", fabric.weft, "N/m"),
                 shear = value("shear", fabric.shear, "N/m");
  if (fabric.law == cloth::Law::kSprings)
    return tissue_row("fabric", "springs", preset,
                      {density, warp, weft, shear, value("bend", fabric.bend, "N/m")});
  return tissue_row("fabric", "sheet", preset,
                    {density, warp, weft, shear, value("poisson", fabric.poisson, "1"),
                     value("rigidity_warp", fabric.rigidity_warp, "N·m"),
                     value("rigidity_weft", fabric.rigidity_weft, "N·m")});
}

const TissuePreset* read_fabric_preset(SceneTable& body, SceneTable& table) {
  const TissuePreset* preset =
      read_preset(table, "preset", PresetKind::kFabric,
                  "a preset of `turgor tissues`: sets the keys of the fabric that are not given; short form: "
                  "`fabric = \"black-denim\"`");
  const toml::node* node = body.find("fabric");
  return node && node->is_string() ? preset_of(body, "fabric", PresetKind::kFabric) : preset;
}

void read_fabric(SceneTable& body, cloth::Fabric& fabric, std::vector<TissueRow>& rows) {
  // values of a preset come first; given keys replace them
  SceneTable table = body.table_or_text("fabric");
  const TissuePreset* preset = read_fabric_preset(body, table);
  apply(preset, fabric);
  // constitutive law
  using cloth::Law;
  fabric.law = table.has("bend") && !table.has("law") ? Law::kSprings : Law::kSheet;  // as before the sheet
  table.read_choice<Law>("law", fabric.law, {{"sheet", Law::kSheet}, {"springs", Law::kSprings}},
                         "`\"sheet\"`: continuum law, independent of the mesh; `\"springs\"`: springs of the "
                         "paper, whose stiffness depends on the mesh");
  // keys with limits
  table.read("density", fabric.density, positive("kg/m²"), "mass per area");
  table.read("warp", fabric.warp, kStiffness, "stiffness along the warp");
  table.read("weft", fabric.weft, kStiffness, "stiffness along the weft");
  table.read("shear", fabric.shear, not_negative("N/m"),
             "sheet: force per width and shear angle; springs: stiffness on the bias");
  table.read("poisson", fabric.poisson, within(0, 10),
             "sheet only: contraction across per extension along the warp");
  table.read("rigidity_warp", fabric.rigidity_warp, within(0, 1, "N·m"),
             "sheet only: bending moment per width and curvature of the warp");
  table.read("rigidity_weft", fabric.rigidity_weft, within(0, 1, "N·m"), "sheet only: the same for the weft");
  table.read(
      "bend", fabric.bend, not_negative("N/m"),
      "springs only: stiffness of the springs across edges, which resist bending. Without `law` it selects "
      "the springs");
  // keys that the law does not support
  for (const char* key : {"poisson", "rigidity_warp", "rigidity_weft"})
    if (fabric.law == Law::kSprings && table.has(key)) table.fail(key, "this key needs law = \"sheet\"");
  if (fabric.law == Law::kSheet && table.has("bend"))
    table.fail("bend",
               "this key needs law = \"springs\"; a sheet resists bending by rigidity_warp and "
               "rigidity_weft [N·m]");
  // warp direction
  table.read("direction", fabric.direction, any_number(""), "direction of the warp, in the rest mesh");
  table.finish();
  rows.push_back(row_of(table, fabric, preset));
}

void read_solver(SceneTable table, Device device, cloth::Solver& solver) {
  // integrator and method; a GPU has sweeps only
  using cloth::Integrator;
  using cloth::Method;
  solver.method = device == Device::kGpu ? Method::kChebyshev : Method::kTwoLevel;
  table.read_choice<Integrator>("integrator", solver.integrator,
                                {{"euler", Integrator::kEuler}, {"bdf2", Integrator::kBdf2}},
                                "`\"euler\"`: implicit Euler, numerically damped; `\"bdf2\"`: second order, "
                                "for cloth that swings freely");
  table.read_choice<Method>(
      "method", solver.method,
      {{"two_level", Method::kTwoLevel},
       {"conjugate gradients", Method::kConjugateGradients},
       {"sweeps", Method::kChebyshev},
       {"chebyshev", Method::kChebyshev},
       {"jacobi", Method::kJacobi}},
      "`\"two_level\"`: conjugate gradients with a two-level preconditioner, until the residual is below "
      "`tolerance`; `\"conjugate gradients\"`: with a Jacobi preconditioner; `\"sweeps\"` (or "
      "`\"chebyshev\"`): Jacobi sweeps of the paper, accelerated; `\"jacobi\"`: not accelerated. The default "
      "on a GPU is `\"sweeps\"`");
  // defaults depend on the method
  solver.sweeps = cloth::uses_conjugate_gradients(solver.method) ? 200 : 16;
  // keys with limits
  table.read("sweeps", solver.sweeps, within(1, 10000),
             "sweeps per frame, 16 by default; maximum iterations of conjugate gradients, 200 by default");
  table.read("tolerance", solver.tolerance, within(0, 1),
             "conjugate gradients stop at this relative residual force; 0 = never");
  table.read("strain_limit", solver.strain_limit, within(0, 10),
             "largest extension of a spring relative to its rest length; 0 = no limit");
  table.finish();
}

void read_collision(SceneTable table, cloth::Collision& collision) {
  table.read("self", collision.self, "the cloth collides with itself");
  table.read("thickness", collision.thickness, inside(0, 1, "m"), "smallest distance between two layers");
  table.read("friction", collision.friction, within(0, 10), "Coulomb friction coefficient");
  table.read("iterations", collision.iterations, within(1, 1000), "maximum iterations of the contact solver");
  table.finish();
}

/// Rows of four numbers with ascending times in the first column.
std::vector<std::array<double, 4>> read_rows(SceneTable& table, const char* key, const char* expected,
                                             const char* unit, const char* meaning) {
  std::vector<std::array<double, 4>> rows;
  table.describe(key, unit, "none", meaning);
  const toml::node* node = table.find(key);
  if (!node) return rows;
  if (!node->is_array()) return table.fail_value(key, *node, expected), rows;
  for (const toml::node& row : *node->as_array()) {
    const std::vector<double> v = table.numbers(key, row, any_number("s, then m or m/s"));
    if (v.empty()) return {};  // a problem was added
    if (v.size() != 4 || (!rows.empty() && v[0] <= rows.back()[0]))
      return table.fail_value(key, row, expected), rows;
    rows.push_back({v[0], v[1], v[2], v[3]});
  }
  return rows;
}

void read_wind(SceneTable table, ClothScene& scene) {
  cloth::Air& air = scene.air;
  table.read("velocity", air.velocity, within(-200, 200, "m/s"), "mean wind");
  table.read("density", air.density, not_negative("kg/m³"), "density of the air");
  table.read("pressure", air.pressure, not_negative(""),
             "force per area normal to the cloth, in multiples of the dynamic pressure");
  table.read("drag", air.drag, not_negative(""), "the same tangential to the cloth");
  table.read("gusts", air.gusts, within(0, 5), "strength of gusts relative to the mean wind; 0 = none");
  table.read("gust_length", air.gust_length, inside(0, 1000, "m"), "length of gusts");

  // random gusts
  int seed = int(air.seed);
  table.read("seed", seed, within(0, 2e9), "random seed of the gusts");
  air.seed = std::uint64_t(seed);
  for (const auto& [t, x, y, z] :
       read_rows(table, "turns", "rows [t, x, y, z] of the mean wind from a time on, ascending [s] [m/s]",
                 "s, m/s", "`[[t, x, y, z], …]`: the mean wind from a time on"))
    scene.turns.push_back({t, {x, y, z}});
  table.finish();
}

BallScene read_ball(SceneTable shape) {
  BallScene ball;
  shape.read("center", ball.center, kPosition, "center of the ball");
  shape.read("radius", ball.radius, inside(0, 10, "m"), "radius of the ball, or the capsule");
  shape.finish();
  return ball;
}

HoldScene read_hold(SceneTable table, const std::string& name) {
  HoldScene hold{.name = name};
  table.require({"vertices", "box", "ball"}, "which vertices are held");
  table.describe("vertices", "", "one of `vertices`, `box`, `ball`",
                 "indices of mesh vertices. Reports contain the force on each hold");
  table.describe("box", "m", "none", "`[[x, y, z], [x, y, z]]`: vertices in this box at rest");
  table.describe("ball", "m", "none",
                 "`{ center, radius }`: vertices in this ball at `start`, as forceps grasp");

  // vertices
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
    table.fail("ball", "a hold has either a ball, or vertices or a box, not both");

  // time and path
  table.read("start", hold.start, not_negative("s"), "time of grasping");
  table.read("end", hold.end, positive("s"), "time of release");
  if (hold.end <= hold.start)
    table.fail("end",
               fmt::format("expected a time after the start at {} s, found {} s", hold.start, hold.end));
  hold.path = read_rows(table, "path", "rows [t, x, y, z] of displacements, ascending [s] [m]", "s, m",
                        "`[[t, x, y, z], …]`: displacements; without it the vertices stay fixed");
  table.finish();
  return hold;
}

/// Refuses a second shape, which would be ignored without a message.
void check_one_shape(SceneTable& table) {
  std::string given;
  for (const char* kind : {"plane", "sphere", "capsule", "mesh", "body"}) {
    if (!table.has(kind)) continue;
    if (!given.empty())
      table.fail(kind, fmt::format("an obstacle has one shape: either {} or {}, not both", given, kind));
    given = given.empty() ? kind : given;
    table.find(kind);
  }
}

ObstacleScene read_obstacle(SceneTable table, const std::string& name, const Scene& scene) {
  ObstacleScene obstacle{.name = name, .shape = PlaneScene{}};
  table.require({"plane", "sphere", "capsule", "mesh", "body"}, "the shape of the obstacle");
  table.describe("body", "", "one of `plane`, `sphere`, `capsule`, `mesh`, `body`",
                 "the moving surface of another body of the scene (`\"lattice\"`, `\"sfem\"`, `\"rhombus\"`, "
                 "`\"rigid\"`), on "
                 "which the cloth exerts its contact forces");
  check_one_shape(table);
  if (table.has("sphere")) {
    obstacle.shape = read_ball(table.table("sphere"));
  } else if (table.has("capsule")) {
    RodScene rod;
    SceneTable shape = table.table("capsule");
    shape.read("from", rod.from, kPosition, "one end of the axis");
    shape.read("to", rod.to, kPosition, "the other end");
    shape.read("radius", rod.radius, inside(0, 10, "m"), "radius of the ball, or the capsule");
    shape.finish();
    obstacle.shape = rod;
  } else if (table.has("mesh")) {
    obstacle.shape = read_garment(table);
  } else if (table.has("body")) {
    obstacle.shape = read_body(table, "body", scene,
                               {BodyKind::kLattice, BodyKind::kSfem, BodyKind::kRhombus, BodyKind::kRigid});
  } else {
    PlaneScene plane;
    SceneTable shape = table.table("plane");
    shape.read("through", plane.through, kPosition, "a point of the plane");
    shape.read("normal", plane.normal, any_number(""), "outward normal of the solid half-space");
    if (!(norm(plane.normal) > 0)) shape.fail("normal", "expected a direction that is not zero");
    shape.finish();
    obstacle.shape = plane;
  }
  table.read("friction", obstacle.friction, within(0, 10), "Coulomb friction coefficient");
  table.read("gap", obstacle.gap, within(0, 1, "m"), "distance that the cloth keeps");
  table.finish();
  return obstacle;
}

/// Refuses parameters that the GPU backend does not support.
void check_device(SceneTable& body, const ClothScene& cloth) {
  if (cloth.device != Device::kGpu) return;
  const auto [key, why] = cloth::why_not_on_gpu(cloth.params);
  if (!key.empty())
    body.fail(key, fmt::format("on device = \"gpu\" {}, or device = \"cpu\" of this body", why));
}

}  // namespace

ClothScene read_cloth_scene(SceneTable body, const std::string& name, const Scene& scene) {
  ClothScene cloth;
  body.begin_group("cloth");
  cloth.name = name, cloth.source_location = body.location();

  // mesh
  body.require({"sheet", "mesh"}, "the mesh of the cloth");
  if (body.has("sheet") && body.has("mesh"))
    body.fail("mesh", "a cloth is either a sheet or a mesh, not both");
  if (body.has("sheet"))
    cloth.source = read_sheet(body.table("sheet"));
  else
    cloth.source = read_garment(body);

  // device, on which the default solver depends
  cloth.device = scene.device;
  body.read_choice<Device>("device", cloth.device, {{"cpu", Device::kCpu}, {"gpu", Device::kGpu}},
                           "device of this body; the default is `world.device`");

  // material and solver
  read_fabric(body, cloth.params.fabric, cloth.tissues);
  read_stiffness_scale(body, cloth.stiffness_scale);
  SceneTable damping = body.table("damping");
  damping.read("motion", cloth.params.damping.motion, not_negative("1/s"),
               "velocities decay by exp(−motion · t)");
  damping.read("stretch", cloth.params.damping.stretch, not_negative("s"),
               "damping by the rate of stretch, in multiples of stiffness");
  damping.finish();
  read_solver(body.table("solver"), cloth.device, cloth.params.solver);
  read_collision(body.table("collision"), cloth.params.collision);
  body.read("weld", cloth.params.weld, within(0, 1, "m"), "merges vertices closer than this");
  read_wind(body.table("wind"), cloth);
  read_texture(body, cloth.texture);

  // holds and obstacles
  SceneTable holds = body.table("hold");
  for (const std::string& hold : holds.names()) cloth.holds.push_back(read_hold(holds.named(hold), hold));
  SceneTable obstacles = body.table("obstacle");
  for (const std::string& obstacle : obstacles.names())
    cloth.obstacles.push_back(read_obstacle(obstacles.named(obstacle), obstacle, scene));
  check_device(body, cloth);
  body.finish();
  return cloth;
}

}  // namespace turgor
