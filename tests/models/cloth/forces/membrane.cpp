#include "turgor/models/cloth/forces/membrane.hpp"

#include "tests/models/cloth/meshes.hpp"
#include "tests/models/cloth/sheets.hpp"
#include "turgor/models/cloth/solver/system.hpp"

namespace turgor::cloth {
namespace {

constexpr double kLength = 0.1, kHeight = 0.04;

Params sheet_of(const Fabric& fabric) {
  Params params{.fabric = fabric};
  params.fabric.law = Law::kSheet;
  params.collision.self = false;
  return params;
}

/// Maps positions x to F x and rotates them about (1, 2, 2)/3.
void deform(const Model& model, State& state, const double (&f)[2][2], double angle) {
  const Vec3d axis = Vec3d{1, 2, 2} / 3;
  for (std::size_t v = 0; v < std::size_t(model.count); v++) {
    const Vec3d x(model.x_rest[v]);
    const Vec3d y{f[0][0] * x.x + f[0][1] * x.y, f[1][0] * x.x + f[1][1] * x.y, 0};
    const Vec3d turned = y * std::cos(angle) + cross(axis, y) * std::sin(angle) +
                         axis * (dot(axis, y) * (1 - std::cos(angle)));
    state.x.set(v, Vec3(turned));
  }
}

// The energy of a uniform strain is that of the fabric on any mesh and in any rotation.
TEST(ClothMembrane, EnergyMatchesFabricOnAnyMesh) {
  const Fabric fabric{
      .warp = 700, .weft = 300, .shear = 120, .poisson = 0.4, .rigidity_warp = 0, .rigidity_weft = 0};
  const double rest = 1 - 0.4 * 0.4 * 300 / 700, d1 = 700 / rest, d2 = 300 / rest, d12 = 0.4 * d2;
  struct Deformation {
    double f[2][2], energy;  // [J/m²]
  };
  const double s = 0.05;  // a shear without rotation
  for (const Deformation& deformation :
       {Deformation{{{1.08, 0}, {0, 1}}, d1 * 0.08 * 0.08 / 2},
        Deformation{{{1, 0}, {0, 0.95}}, d2 * 0.05 * 0.05 / 2},
        Deformation{{{1.04, 0}, {0, 1.03}}, (d1 * 0.0016 + d2 * 0.0009) / 2 + d12 * 0.0012},
        Deformation{{{1, s}, {s, 1}}, 2 * 120 * s * s}})
    for (const Pattern pattern : kPatterns)
      for (const double angle : {0.0, 2.0}) {
        const Model model = must_build(rectangle(pattern, 0, kLength, kHeight, 0.01), sheet_of(fabric));
        State state = make_state(model);
        deform(model, state, deformation.f, angle);
        EXPECT_NEAR(energy(model, state, {}).elastic / (deformation.energy * kLength * kHeight), 1, 2e-3)
            << name(pattern) << " rotated by " << angle;
      }
}

// The warp may have any direction in the mesh.
TEST(ClothMembrane, FabricDirectionIsArbitrary) {
  for (const Pattern pattern : kPatterns) {
    Fabric fabric{.warp = 700, .weft = 300, .shear = 120, .rigidity_warp = 0, .rigidity_weft = 0};
    fabric.direction = {0, 1, 0.3};
    const Model model = must_build(rectangle(pattern, 0, kLength, kHeight, 0.01), sheet_of(fabric));
    State state = make_state(model);
    deform(model, state, {{1.01, 0}, {0, 1}}, 0.3);
    EXPECT_NEAR(energy(model, state, {}).elastic / (300 * 1e-4 / 2 * kLength * kHeight), 1, 5e-3)
        << name(pattern);
  }
}

// Forces are the negative gradient of the energy.
TEST(ClothMembrane, ForcesAreEnergyGradient) {
  for (const Pattern pattern : {Pattern::kRandom, Pattern::kLong}) {
    Params params = sheet_of({.warp = 700, .weft = 300, .shear = 120, .poisson = 0.3});
    params.fabric.rigidity_warp = 3e-4, params.fabric.rigidity_weft = 1e-4;
    const Model model = must_build(rectangle(pattern, 0, kLength, kHeight, 0.01), params);
    State state = make_state(model);
    shake(model, state.x, 0.003);
    Inputs inputs = in_vacuum(0);
    assemble(Exec(1), model, state, inputs, kFrame);
    for (const std::size_t v : {std::size_t(0), std::size_t(17), std::size_t(23), std::size_t(40)})
      for (int k = 0; k < 3; k++) {
        const double h = 1.0 / 65536;  // exact in single precision
        double e[2];
        for (const int sign : {0, 1}) {
          State moved = state;
          Vec3 x = moved.x[v];
          x[k] += Real(sign ? h : -h);
          moved.x.set(v, x);
          e[sign] = energy(model, moved, {}).elastic;
        }
        const double force = double(state.system.force[v][k]) / kFrame;
        EXPECT_NEAR(force, -(e[1] - e[0]) / (2 * h),
                    2e-3 * norm(Vec3d(state.system.force[v])) / kFrame + 1e-4)
            << name(pattern) << " " << v;
      }
  }
}

/// Force per width and strain of a strip at rest that is pulled along x.
double pulled_modulus(const TriMesh& mesh, Params params, double strain) {
  params.damping.motion = 10;
  params.solver = {.method = Method::kConjugateGradients, .sweeps = 100};
  const Model model = must_build(mesh, params);
  State state = make_state(model);
  const std::vector<int> left = vertices_between(mesh, -1, 1e-6),
                         right = vertices_between(mesh, kLength - 1e-6, 1);
  for (const int v : left) EXPECT_TRUE(hold(model, state, v));
  for (const int v : right) {
    EXPECT_TRUE(hold(model, state, v));
    Vec3 goal = mesh.vertices[std::size_t(v)];
    goal.x += Real(strain * kLength);
    EXPECT_TRUE(move_hold(model, state, v, goal));
  }
  for (int n = 0; n < 60; n++) step(Exec(1), model, state, in_vacuum(0), kFrame);
  double pull = 0;
  for (const int v : right) pull += hold_force(model, state, v, {}, {}, kFrame).x;
  return pull / kHeight / strain;
}

// The modulus of a pulled strip is within 2 % on any mesh and for any cell size.
TEST(ClothMembrane, PulledStripModulusOnAnyMesh) {
  for (const Pattern pattern : kPatterns)
    for (const double size : {0.02, 0.01, 0.005})
      for (const double strain : {0.01, 0.1}) {
        const Params params = sheet_of({.warp = 1000, .weft = 400, .shear = 60});
        const double found = pulled_modulus(rectangle(pattern, 0, kLength, kHeight, size), params, strain);
        EXPECT_NEAR(found / 1000, 1, 0.02) << name(pattern) << ", " << size << " m, strain " << strain;
      }
}

// Forces are correct at a vertex with 600 neighbors.
TEST(ClothMembrane, VertexWithHundredsOfNeighbors) {
  TriMesh wheel{.vertices = {{0, 0, 0}}, .triangles = {}};
  const int spokes = 600;
  for (int n = 0; n < spokes; n++) {
    const double angle = 2 * 3.14159265358979 * n / spokes;
    wheel.vertices.push_back(Vec3(Vec3d{0.1 * std::cos(angle), 0.1 * std::sin(angle), 0}));
    wheel.triangles.push_back({0, 1 + n, 1 + (n + 1) % spokes});
  }
  const Model model = must_build(wheel, sheet_of({.rigidity_warp = 0, .rigidity_weft = 0}));
  State state = make_state(model);
  for (std::size_t v = 0; v < std::size_t(model.count); v++) state.x.set(v, state.x[v] * 1.02f);
  assemble(Exec(1), model, state, in_vacuum(0), kFrame);
  Vec3d sum;
  double inward = 0;  // inward force of the rim
  for (std::size_t v = 0; v < std::size_t(model.count); v++) {
    sum += Vec3d(state.system.force[v]) / kFrame;
    inward -= dot(Vec3d(state.system.force[v]), normalized(Vec3d(state.x[v]) + Vec3d{1e-9, 0, 0})) / kFrame;
  }
  EXPECT_LT(norm(sum), 1e-3);
  EXPECT_NEAR(inward / (2 * 3.14159265358979 * 0.1 * 0.02 * 1000), 1, 0.01);
}

// In contrast, the modulus of a sheet of springs depends on the mesh.
TEST(ClothMembrane, SpringsDependOnMesh) {
  Params params = sheet_of({.warp = 1000, .weft = 1000, .shear = 200});
  params.fabric.law = Law::kSprings;
  const double squares =
      pulled_modulus(rectangle(Pattern::kDiagonal, 0, kLength, kHeight, 0.01), params, 0.01);
  const double longer = pulled_modulus(rectangle(Pattern::kLong, 0, kLength, kHeight, 0.01), params, 0.01);
  EXPECT_GT(std::abs(longer / squares - 1), 0.1);
}

}  // namespace
}  // namespace turgor::cloth
