#include "turgor/models/cloth/forces/wind.hpp"

#include "tests/models/cloth/sheets.hpp"

namespace turgor::cloth {
namespace {

// The force of wind on a plate is that of the formula for pressure and drag.
TEST(ClothWind, PlateForceMatchesFormula) {
  const Model model = must_build(flat_sheet(21), {});
  State state = make_state(model);
  for (const Vec3d wind : {Vec3d{0, 0, 7}, Vec3d{5, 0, 0}, Vec3d{0, 4, -3}}) {
    Inputs inputs = in_vacuum(0);
    inputs.air = {.density = 1.2, .velocity = wind, .pressure = 1.3, .drag = 0.1};
    auto& system = state.system;
    blow(Exec(2), inputs.air, 0, kFrame, model.triangles, model.chunk_triangles, state.x, state.v,
         system.change, {system.force, system.inverse[0], system.inverse[1]});
    Vec3d sum;
    for (std::size_t v = 0; v < std::size_t(model.count); v++) sum += Vec3d(system.force[v]) / kFrame;
    const Vec3d along{wind.x, wind.y, 0};
    const Vec3d expected = Vec3d{0, 0, 0.5 * 1.2 * model.area * 1.3 * std::abs(wind.z) * wind.z} +
                           along * (0.5 * 1.2 * model.area * 0.1 * norm(along));
    EXPECT_LT(norm(sum - expected), 1e-4 * norm(expected));
  }
}

// The load of a crumpled sheet is the sum of the formula over its triangles, in double precision. Two corners
// of some triangles coincide; these have no load.
TEST(ClothWind, CrumpledSheetMatchesFormula) {
  const Model model = must_build(flat_sheet(7), {});
  State state = make_state(model);
  RandomNumbers next{3};
  for (int v = 0; v < model.count; v++) {
    const double a = next(), b = next(), c = next(), d = next(), e = next(), f = next();
    state.x.add(std::size_t(v), Vec3(Vec3d{a, b, c} * 0.01));
    state.v.set(std::size_t(v), Vec3(Vec3d{d, e, f} * 5.0));
  }
  state.x.set(1, state.x[0]);
  const Air air{.density = 1.2, .velocity = {3, -2, 6}, .pressure = 1.3, .drag = 0.1};
  auto& system = state.system;
  blow(Exec(1), air, 0, kFrame, model.triangles, model.chunk_triangles, state.x, state.v, system.change,
       {system.force, system.inverse[0], system.inverse[1]});
  // impulse and diagonal of minus the derivative by velocity
  std::vector<Vec3d> impulse(std::size_t(model.count), Vec3d{}), diagonal = impulse, off = impulse;
  for (const Int3 t : model.triangles) {
    const auto x = [&](int k) { return Vec3d(state.x[std::size_t(t[k])]); };
    const auto v = [&](int k) { return Vec3d(state.v[std::size_t(t[k])]); };
    const Vec3d u = air.velocity - (v(0) + v(1) + v(2)) / 3.0, n = cross(x(1) - x(0), x(2) - x(0));
    const double area = norm(n) / 2;
    if (!(area > 0)) continue;
    const Vec3d normal = n / norm(n), un = normal * dot(u, normal), ut = u - un;
    const double half = 0.5 * 1.2 * area * kFrame / 3, a = half * 1.3 * norm(un), b = half * 0.1 * norm(ut);
    for (int k = 0; k < 3; k++) {
      const auto i = std::size_t(t[k]);
      impulse[i] += un * a + ut * b;
      const double d = 2 * a - b;
      diagonal[i] +=
          Vec3d{b + d * normal.x * normal.x, b + d * normal.y * normal.y, b + d * normal.z * normal.z};
      off[i] += Vec3d{normal.x * normal.y, normal.x * normal.z, normal.y * normal.z} * d;
    }
  }
  for (std::size_t i = 0; i < std::size_t(model.count); i++) {
    const double scale = 1e-5 * norm(diagonal[i]);
    EXPECT_LT(norm(Vec3d(system.force[i]) - impulse[i]), 1e-5 * norm(impulse[i]) + scale) << i;
    EXPECT_LT(norm(Vec3d(system.inverse[0][i]) - diagonal[i]), scale) << i;
    EXPECT_LT(norm(Vec3d(system.inverse[1][i]) - off[i]), scale) << i;
  }
}

// A sheet in still air reaches the speed at which drag balances its weight.
TEST(ClothWind, TerminalVelocity) {
  const Model model = must_build(flat_sheet(11), {.damping = {.motion = 0}});
  State state = make_state(model);
  Inputs inputs{.gravity = {0, 0, -9.81}};
  for (int frame = 0; frame < 300; frame++) step(Exec(1), model, state, inputs, kFrame);
  const double terminal = std::sqrt(2 * 0.2 * 9.81 / (1.2 * 1.2));
  for (const std::size_t v : {0u, 60u, 120u}) EXPECT_NEAR(-state.v.z[v] / terminal, 1, 0.01);
}

// Gusts have the given strength and no divergence, and move with the wind.
TEST(ClothWind, GustsAreDivergenceFreeAndAdvected) {
  const Air air{.velocity = {5, 0, 0}, .gusts = 0.3, .seed = 4};
  const Gusts now = gusts_at(air, 1);
  double sum2 = 0, mean = 0;
  int count = 0;
  for (int i = 0; i < 40; i++)
    for (int j = 0; j < 40; j++)
      for (int k = 0; k < 40; k++, count++) {
        const Vec3 u = air_velocity(now, Vec3(Vec3d{0.37 * i, 0.41 * j, 0.39 * k})) - Vec3(air.velocity);
        sum2 += double(dot(u, u));
        mean += double(u.x);
      }
  EXPECT_NEAR(std::sqrt(sum2 / count / 3) / 1.5, 1, 0.03);
  EXPECT_NEAR(mean / count, 0, 0.1);

  const Vec3 at{0.3f, -0.2f, 0.7f};
  double divergence = 0;
  for (int k = 0; k < 3; k++) {
    Vec3 d;
    d[k] = 0.005f;
    divergence += double((air_velocity(now, at + d) - air_velocity(now, at - d))[k]) / 0.01;
  }
  EXPECT_NEAR(divergence, 0, 0.1);  // its terms are about 10 1/s
  const Vec3 later = air_velocity(gusts_at(air, 1.2), at + Vec3{1, 0, 0});
  EXPECT_NEAR(norm(later - air_velocity(now, at)), 0, 1e-3);
}

// A seed determines the gusts.
TEST(ClothWind, SeedDeterminesGusts) {
  Air air{.velocity = {5, 0, 0}, .gusts = 0.3, .seed = 4};
  const Vec3 at{1, 2, 3}, u = air_velocity(gusts_at(air, 2), at);
  EXPECT_EQ(air_velocity(gusts_at(air, 2), at), u);
  air.seed = 5;
  EXPECT_NE(air_velocity(gusts_at(air, 2), at), u);
}

}  // namespace
}  // namespace turgor::cloth
