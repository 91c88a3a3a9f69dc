// Sheets that fall on rods and balls thinner than a cell, which vertices and edges may pass.
#include <cmath>
#include <memory>
#include <string>

#include "tests/models/cloth/meshes.hpp"
#include "tests/models/cloth/sheets.hpp"
#include "turgor/contact/cloth_obstacle.hpp"
#include "turgor/models/cloth/solver/system_kernels.hpp"

namespace turgor::cloth {
namespace {

/// A square sheet in cells of 10 mm above a thin obstacle.
struct ThinFall {
  Model model;
  State state;
  Inputs inputs;
  std::unique_ptr<const contact::Shape> shape;  // referenced by the obstacle
};

/// Moves every second vertex of the lower border inward by a hundredth of a millimeter, and adds the slivers
/// that a triangulation of the hull would have there.
void add_slivers(TriMesh& mesh, int columns) {
  for (int c = 1; c < columns; c += 2) {
    mesh.vertices[std::size_t(c)].y += 1e-5f;
    mesh.triangles.push_back({c - 1, c + 1, c});
  }
}

/// Curves the lower and the left border inward by up to `depth`, and closes them with the nested slivers that
/// a triangulation of the hull would have there. Their chords span 2, 4, 8, … cells.
void add_hull(TriMesh& mesh, int cells, double depth) {
  for (int n = 1; n < cells; n++) {
    const double along = double(2 * n - cells) / cells, inward = depth * (1 - along * along);
    mesh.vertices[std::size_t(n)].y += float(inward);
    mesh.vertices[std::size_t(n * (cells + 1))].x += float(inward);
  }
  for (int half = 1; 2 * half <= cells; half *= 2)
    for (int n = half; n + half <= cells; n += 2 * half) {
      const int row = cells + 1;
      mesh.triangles.push_back({n - half, n + half, n});
      mesh.triangles.push_back({(n + half) * row, (n - half) * row, n * row});
    }
}

ThinFall fall_on(Pattern pattern, int cells, double height, contact::Shape shape, const contact::Pose& pose,
                 double dt, double friction, double hull = 0) {
  constexpr double kCell = 0.01;
  Params params{.fabric = {.law = Law::kSheet}, .solver = {.method = Method::kTwoLevel, .sweeps = 200}};
  params.collision.thickness = 0.004;
  const double side = kCell * cells;
  TriMesh mesh = rectangle(pattern, -side / 2, side / 2, side, kCell);
  if (hull > 0)
    add_hull(mesh, cells, hull);
  else if (pattern == Pattern::kRandom)
    add_slivers(mesh, cells);
  for (Vec3& x : mesh.vertices) x += Vec3(Vec3d{0, -side / 2, height});
  ThinFall fall{.model = must_build(mesh, params),
                .state = {},
                .inputs = {.gravity = {0, 0, -9.81}},
                .shape = std::make_unique<const contact::Shape>(std::move(shape))};
  fall.state = make_state(fall.model);
  fall.inputs.obstacles.push_back(contact::cloth_obstacle(*fall.shape, pose, pose, dt));
  fall.inputs.obstacles.back().friction = friction;
  return fall;
}

/// Axes with z along a direction.
Mat3d axes_along(Vec3d z) {
  const Vec3d y = normalized(cross(z, std::abs(z.x) < 0.9 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0}));
  return {{cross(y, z), y, z}};
}

/// Runs a fall. Speeds stay near those of a free fall. Edges stay below 2.5 times their length: a vertex that
/// an obstacle passed is moved out by more than half of a short edge.
void expect_calm(ThinFall& fall, double dt, int frames, const std::string& where) {
  for (int n = 1; n <= frames; n++) {
    const StepReport report = step(Exec(1), fall.model, fall.state, fall.inputs, dt);
    const double speed = double(report.largest_speed), stretch = largest_stretch(fall.model, fall.state);
    ASSERT_TRUE(report.finite) << where << ", frame " << n;
    ASSERT_LT(speed, 1.5 * 9.81 * n * dt + 1) << where << ", frame " << n;
    ASSERT_LT(stretch, 2.5) << where << ", frame " << n;
  }
}

// A sheet of random cells that falls on a rod of 2 mm radius and slides off it stays finite.
TEST(ClothThinObstacles, SheetFallsOnThinRod) {
  for (const double rate : {60.0, 120.0})
    for (const double friction : {0.0, 0.3}) {
      const Vec3d from{-0.3, 0.01, 0}, to{0.3, 0.013, 0};
      const contact::Pose pose{(from + to) * 0.5, axes_along(normalized(to - from))};
      ThinFall fall = fall_on(Pattern::kRandom, 30, 0.06, contact::Capsule{0.002, norm(to - from) / 2}, pose,
                              1 / rate, friction);
      expect_calm(fall, 1 / rate, int(1.6 * rate),
                  std::to_string(rate) + " Hz, friction " + std::to_string(friction));
    }
}

// The same for a sheet whose hull is closed by nested slivers. Their chords do not collide with the cloth.
TEST(ClothThinObstacles, SheetWithHullFallsOnThinRod) {
  for (const double rate : {60.0, 120.0}) {
    const Vec3d from{-0.3, 0.01, 0}, to{0.3, 0.013, 0};
    const contact::Pose pose{(from + to) * 0.5, axes_along(normalized(to - from))};
    ThinFall fall = fall_on(Pattern::kRandom, 30, 0.06, contact::Capsule{0.002, norm(to - from) / 2}, pose,
                            1 / rate, 0.3, 0.002);
    expect_calm(fall, 1 / rate, int(0.8 * rate), std::to_string(rate) + " Hz");
  }
}

// Vertices of thin triangles are up to 10¹⁰ times stiffer along one direction than along another. Their
// preconditioner is positive definite in single precision, and exact if the block is well conditioned.
TEST(ClothThinObstacles, PreconditionersOfStiffBlocksArePositive) {
  RandomNumbers next{7};
  for (int n = 0; n < 3000; n++) {
    // isotropic part, and one to three stiff directions
    const float least = float(std::pow(10.0, -5 + 5 * next()));
    Symmetric<Real> block{{least, least, least}, {}};
    for (int k = 0; k <= n % 3; k++) {
      const double x = next(), y = next(), z = next();
      const Vec3 e(normalized(Vec3d{x, y, z}));
      block.diagonal += Vec3{e.x * e.x, e.y * e.y, e.z * e.z};
      block.off += Vec3{e.x * e.y, e.x * e.z, e.y * e.z};
    }
    const Symmetric<Real> inverse = definite_inverse<Real>(block, least);
    // leading minors
    const auto [a, d, f] = Vec3d(inverse.diagonal);
    const auto [b, c, e] = Vec3d(inverse.off);
    ASSERT_GT(a, 0) << n;
    ASSERT_GT(a * d - b * b, 0) << n;
    ASSERT_GT(a * (d * f - e * e) - b * (b * f - c * e) + c * (b * e - c * d), 0) << n << ' ' << least;
    // product with the block
    if (least < 1e-3f) continue;
    const Vec3 unit{0.6f, -0.48f, 0.64f}, same = inverse * (block * unit);
    ASSERT_LT(norm(same - unit), 2e-3) << n << ' ' << least;
  }
}

// A rigid turn of a sheet with slivers gives no forces: their strain does not suffer from cancellation.
TEST(ClothThinObstacles, TurnedSliversStayAtRest) {
  Params params{.fabric = {.law = Law::kSheet}, .solver = {.method = Method::kTwoLevel, .sweeps = 200}};
  params.collision.self = false;
  TriMesh mesh = rectangle(Pattern::kAlternating, -0.1, 0.1, 0.2, 0.01);
  add_slivers(mesh, 20);
  const Model model = must_build(mesh, params);
  ASSERT_EQ(model.notes.size(), 1u);
  EXPECT_EQ(model.notes[0].find("10 triangles are thinner than a tenth"), 0u) << model.notes[0];
  State state = make_state(model);
  const Mat3d turn = axes_along(normalized(Vec3d{1, 2, 3}));
  for (std::size_t v = 0; v < std::size_t(model.count); v++) state.x.set(v, Vec3(turn * Vec3d(state.x[v])));
  double fastest = 0;
  for (int n = 0; n < 10; n++) {
    const StepReport report = step(Exec(1), model, state, in_vacuum(0), kFrame);
    ASSERT_TRUE(report.finite);
    fastest = std::max(fastest, double(report.largest_speed));
  }
  EXPECT_LT(fastest, 2e-4) << "m/s";
}

// Sheets that fall on random rods and balls thinner than a cell stay finite and calm.
TEST(ClothThinObstacles, RandomThinObstaclesStayCalm) {
  RandomNumbers next{11};
  for (int n = 0; n < 40; n++) {
    const double radius = 0.001 + 0.0015 * (1 + next()), rate = next() > 0 ? 60 : 120;
    const double friction = std::max(0.0, 0.4 * next()), height = 0.02 + 0.03 * (1 + next());
    const double dx = next(), dy = next(), dz = next(), x = next(), y = next();
    const bool is_ball = next() > 0.5;
    const contact::Shape shape = is_ball ? contact::Shape(contact::Sphere{radius})
                                         : contact::Shape(contact::Capsule{radius, 0.1 + 0.08 * next()});
    const Vec3d level = normalized(Vec3d{dx, dy, 0});
    const contact::Pose pose{{0.03 * x, 0.03 * y, -0.01},
                             axes_along(normalized(level + Vec3d{0, 0, 0.2 * dz}))};
    ThinFall fall = fall_on(kPatterns[n % 7], 14, height + 0.05, shape, pose, 1 / rate, friction);
    expect_calm(fall, 1 / rate, int(0.8 * rate),
                std::to_string(n) + ": " + name(kPatterns[n % 7]) + ", radius " + std::to_string(radius) +
                    ", friction " + std::to_string(friction));
  }
}

}  // namespace
}  // namespace turgor::cloth
