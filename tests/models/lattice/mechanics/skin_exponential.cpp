// The exponential law of skin: force, tangent and tension against its energy and against closed forms.
#include "turgor/models/lattice/mechanics/skin_exponential.hpp"

#include <array>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "tests/models/lattice/block_body.hpp"
#include "turgor/models/lattice/cutting/incision.hpp"
#include "turgor/models/lattice/lattice.hpp"
#include "turgor/models/lattice/mechanics/skin_calibration.hpp"

namespace turgor::lattice {
namespace {

const Exec kBoth(2);

SkinParams exponential_params(double along, double across) {
  return {.law = SkinLaw::kExponential,
          .tension_along = along,
          .tension_across = across,
          .shear = 90,
          .stiffening = 11,
          .fiber_stiffness = 140,
          .fiber_stiffening = 9,
          .dispersion = 0.07};
}

/// A triangle in space with coefficients of F d, deformed at random.
struct SkinSample {
  Vec3d x[3];
  Vec3 along, across;  // coefficients of the corners
  Real area = 0.7f;
};
SkinSample any_sample(std::mt19937& random, double strain) {
  std::uniform_real_distribution<double> any(-1, 1);
  SkinSample s;
  // at rest an isosceles triangle in a plane, with oblique axes
  const double angle = 3 * any(random), c = std::cos(angle), d = std::sin(angle);
  const double rest[3][2] = {{0, 0}, {1, 0.1}, {0.2, 0.9}};
  const double det = rest[1][0] * rest[2][1] - rest[2][0] * rest[1][1];
  const double inverse[2][2] = {{rest[2][1] / det, -rest[2][0] / det}, {-rest[1][1] / det, rest[1][0] / det}};
  for (int q = 0; q < 2; q++) {
    s.along[q + 1] = Real(inverse[q][0] * c + inverse[q][1] * d);
    s.across[q + 1] = Real(-inverse[q][0] * d + inverse[q][1] * c);
  }
  s.along.x = -s.along.y - s.along.z, s.across.x = -s.across.y - s.across.z;
  for (int n = 0; n < 3; n++)
    s.x[n] = {rest[n][0] + strain * any(random), rest[n][1] + strain * any(random), strain * any(random)};
  return s;
}
double sample_energy(const SkinParams& skin, const ExponentialSkin& law, const SkinSample& s) {
  Vec3d f, g;
  for (int n = 0; n < 3; n++)
    f += s.x[n] * double(s.along[n]) * double(law.along),
        g += s.x[n] * double(s.across[n]) * double(law.across);
  return double(s.area) * double(law.rest_share) * exponential_skin_energy(skin, f, g);
}
NodeSystem sample_system(const ExponentialSkin& law, const SkinSample& s, int c) {
  const int b = (c + 1) % 3, d = (c + 2) % 3;
  NodeSystem system;
  add_skin_exponential(system, Vec3(s.x[b] - s.x[c]), Vec3(s.x[d] - s.x[c]),
                       {s.along[c], s.along[b], s.along[d]}, {s.across[c], s.across[b], s.across[d]}, s.area,
                       law);
  return system;
}

// Forces are the negative gradient of the energy; both functions agree; all three sum to zero.
TEST(SkinExponential, ForceIsGradient) {
  std::mt19937 random(3);
  const SkinParams skin = exponential_params(40, 20);
  const ExponentialSkin law = exponential_skin(skin);
  for (int n = 0; n < 100; n++) {
    const SkinSample s = any_sample(random, 0.12);
    const CornerForces all =
        skin_exponential_forces(Vec3(s.x[1] - s.x[0]), Vec3(s.x[2] - s.x[0]), s.along, s.across, s.area, law);
    Vec3d sum;
    double scale = 0;
    for (int c = 0; c < 3; c++) scale = std::max(scale, double(norm(all.on[c])));
    for (int c = 0; c < 3; c++) {
      const NodeSystem system = sample_system(law, s, c);
      for (int axis = 0; axis < 3; axis++) {
        SkinSample a = s, b = s;
        a.x[c][axis] += 1e-6, b.x[c][axis] -= 1e-6;
        const double slope = (sample_energy(skin, law, a) - sample_energy(skin, law, b)) / 2e-6;
        EXPECT_NEAR(double(system.f[axis]), -slope, 2e-5 * scale + 1e-4) << n;
        EXPECT_NEAR(double(all.on[c][axis]), -slope, 2e-5 * scale + 1e-4) << n;
      }
      sum += Vec3d(system.f);
    }
    EXPECT_LT(norm(sum), 1e-4 * scale + 1e-4);
  }
}

// In stretched skin the Hessian is the exact derivative of the force; in pressed and folded skin it stays
// positive.
TEST(SkinExponential, HessianIsDerivative) {
  std::mt19937 random(4);
  const ExponentialSkin law = exponential_skin(exponential_params(80, 60));
  const auto entries = [](const NodeSystem& s) {
    return std::array<double, 9>{double(s.xx), double(s.xy), double(s.xz), double(s.xy), double(s.yy),
                                 double(s.yz), double(s.xz), double(s.yz), double(s.zz)};
  };
  for (int n = 0; n < 60; n++) {
    const SkinSample s = any_sample(random, 0.004);  // the tension stays positive
    const auto h = entries(sample_system(law, s, n % 3));
    const double scale = h[0] + h[4] + h[8];
    for (std::size_t axis = 0; axis < 3; axis++) {
      SkinSample a = s, b = s;
      a.x[n % 3][int(axis)] += 1e-3, b.x[n % 3][int(axis)] -= 1e-3;
      const Vec3d slope =
          (Vec3d(sample_system(law, a, n % 3).f) - Vec3d(sample_system(law, b, n % 3).f)) * (1 / 2e-3);
      for (std::size_t i = 0; i < 3; i++) EXPECT_NEAR(h[3 * axis + i], -slope[int(i)], 2e-3 * scale) << n;
    }
  }
  for (int n = 0; n < 300; n++) {
    const auto h = entries(sample_system(law, any_sample(random, 1.2), n % 3));
    const double scale = h[0] + h[4] + h[8];
    ASSERT_TRUE(std::isfinite(scale));
    const double minor = h[0] * h[4] - h[1] * h[1];
    const double det = h[0] * (h[4] * h[8] - h[5] * h[5]) - h[1] * (h[1] * h[8] - h[5] * h[2]) +
                       h[2] * (h[1] * h[5] - h[4] * h[2]);
    EXPECT_GE(h[0], -1e-5 * scale);
    EXPECT_GE(minor, -1e-5 * scale * scale);
    EXPECT_GE(det, -1e-5 * scale * scale * scale);
  }
}

/// Tension tensor in the plane [N/m] from invariants in tensor form, for fibers at `angle` to x:
///   T = 2/J (W_I (F Fᵀ − 1/J² I) + W_E (κ (F Fᵀ − 1/J² I) + (1 − 3κ) F m (F m)ᵀ))
struct PlaneTension {
  double xx, yy, xy;
};
PlaneTension closed_form(const SkinParams& skin, double ax, double ay, double shear, double angle) {
  // F = (ax shear; 0 ay)
  const double bxx = ax * ax + shear * shear, byy = ay * ay, bxy = shear * ay, j = ax * ay;
  const double mx = ax * std::cos(angle) + shear * std::sin(angle), my = ay * std::sin(angle);
  const double invariant = bxx + byy + 1 / (j * j) - 3, fourth = mx * mx + my * my - 1;
  const double kappa = skin.dispersion, e = kappa * invariant + (1 - 3 * kappa) * fourth;
  const double wi = 0.5 * skin.shear * std::exp(skin.stiffening * invariant);
  const double we = e > 0 ? skin.fiber_stiffness * e * std::exp(skin.fiber_stiffening * e * e) : 0;
  const double iso = 2 / j * (wi + kappa * we), fiber = 2 / j * (1 - 3 * kappa) * we;
  return {iso * (bxx - 1 / (j * j)) + fiber * mx * mx, iso * (byy - 1 / (j * j)) + fiber * my * my,
          iso * bxy + fiber * mx * my};
}

// A body's sheet stretched in both directions and sheared, with fibers oblique to both, bears the tensions of
// the closed form; the work of a small stretch gives them.
TEST(SkinExponential, SheetMatchesClosedFormOffAxis) {
  constexpr int kN = 9;
  constexpr double kSpacing = 0.002, kStep = 1e-3;
  for (const double angle : {0.0, 0.45, 1.2}) {
    Params params;
    params.skin = exponential_params(0, 0);  // the CT is without stress
    params.skin.direction = {std::cos(angle), std::sin(angle), 0};
    const Model model = block_model({.size = {kN, kN, 1}, .spacing = kSpacing, .young = 1e-3}, params);
    const auto energy_of = [&](double ax, double ay, double shear) {
      State state = make_state(model);
      for (int j = 0; j < kN; j++)
        for (int i = 0; i < kN; i++)
          state.motion.u.set(std::size_t(node_slot(model.anatomy.lattice, i, j, 0)),
                             {Real(kSpacing * ((ax - 1) * i + shear * j)), Real(kSpacing * (ay - 1) * j), 0});
      return energy(kBoth, model, state);
    };
    const double area = std::pow((kN - 1) * kSpacing, 2);
    for (const auto& [ax, ay, shear] : {std::array{1.12, 1.0, 0.0}, {1.0, 1.1, 0.0}, {1.07, 1.09, 0.05}}) {
      const PlaneTension t = closed_form(params.skin, ax, ay, shear, angle);
      // work per area without stress: T_xx J ∂ax/ax and so on
      const auto slope = [&, ax = ax, ay = ay, shear = shear](double dx, double dy, double ds) {
        return (energy_of(ax + dx, ay + dy, shear + ds) - energy_of(ax - dx, ay - dy, shear - ds)) /
               (2 * kStep * area);
      };
      const double scale = t.xx + t.yy;
      // P = J T F⁻ᵀ with F = (ax shear; 0 ay)
      EXPECT_NEAR(slope(kStep, 0, 0), ay * t.xx - shear * t.xy, 3e-3 * scale) << angle << " " << ax;
      EXPECT_NEAR(slope(0, kStep, 0), ax * t.yy, 3e-3 * scale) << angle << " " << ay;
      EXPECT_NEAR(slope(0, 0, kStep), ax * t.xy, 3e-3 * scale) << angle << " " << shear;
    }
  }
}

// The stretch of the CT carries the asked tension, and the tangent there is the derivative of the tension.
TEST(SkinExponential, CalibrationAndTangent) {
  for (const auto& [along, across] : {std::array{45.0, 45.0}, {60.0, 30.0}, {0.0, 20.0}, {138.0, 6.0}}) {
    const SkinParams skin = exponential_params(along, across);
    const std::optional<SkinStretch> at = stretch_of_tension(skin);
    ASSERT_TRUE(at);
    const SkinTangent t = skin_tangent(skin, *at);
    EXPECT_NEAR(t.tension_along, along, 1e-6);
    EXPECT_NEAR(t.tension_across, across, 1e-6);
    // energy per present area against small strains of the present state
    const double rest = at->along * at->across, h = 1e-4;
    const auto energy_at = [&](double along_by, double across_by, double shear) {
      return exponential_skin_energy(skin, Vec3d{1 + along_by, 0, 0} * at->along,
                                     Vec3d{shear, 1 + across_by, 0} * at->across) /
             rest;
    };
    const double now = energy_at(0, 0, 0);
    // second derivatives by the displacement gradient include the tension
    EXPECT_NEAR((energy_at(h, 0, 0) - 2 * now + energy_at(-h, 0, 0)) / (h * h), t.along + along,
                1e-3 * t.along + 0.5);
    EXPECT_NEAR((energy_at(0, h, 0) - 2 * now + energy_at(0, -h, 0)) / (h * h), t.across + across,
                1e-3 * t.across + 0.5);
    EXPECT_NEAR((energy_at(0, 0, h) - 2 * now + energy_at(0, 0, -h)) / (h * h), t.shear + across,
                1e-3 * t.shear + 0.5);
    EXPECT_NEAR(
        (energy_at(h, h, 0) - energy_at(h, -h, 0) - energy_at(-h, h, 0) + energy_at(-h, -h, 0)) / (4 * h * h),
        t.coupling, 1e-3 * t.along + 0.5);
    EXPECT_GT(t.along * t.across, t.coupling * t.coupling) << "stable";
  }
  SkinParams beyond = exponential_params(1e9, 0);
  EXPECT_FALSE(stretch_of_tension(beyond));
}

// Skin of the defaults at 45 N/m is more than twice as stiff as without tension.
TEST(SkinExponential, TensionStiffens) {
  SkinParams skin{.law = SkinLaw::kExponential};
  const SkinTangent rest = skin_tangent(skin, {}), tense = skin_tangent(skin, *stretch_of_tension(skin));
  EXPECT_GT(tense.across, 2 * rest.across);
  EXPECT_GT(tense.along, 1.2 * tense.across) << "fibers";
}

/// Width over 4 T a of a slit along the second axis of a plane sheet with this tangent.
/// [Sih, Paris, Irwin 1965]
double slit_compliance(const SkinTangent& t) {
  const double det = t.along * t.across - t.coupling * t.coupling;
  // compliances by (direction of the slit, direction of the opening)
  const double slit = t.across / det, opening = t.along / det, both = -t.coupling / det, shear = 1 / t.shear;
  return std::sqrt(slit * opening / 2 * (std::sqrt(opening / slit) + (2 * both + shear) / (2 * slit)));
}

// A slit in skin under a small tension opens as a crack in the linear sheet with the law's tangent.
TEST(SkinExponential, SlitOpensAsCrackAtSmallTension) {
  constexpr int kN = 61;
  constexpr double kSpacing = 0.001, kTension = 3;
  for (const double fibers : {300.0}) {
    Block block{.size = {kN, kN, 1}, .spacing = kSpacing, .young = 0.5};
    block.is_fixed = [](Int3 p) { return p.x == 0 || p.y == 0 || p.x == kN - 1 || p.y == kN - 1; };
    Params params;
    params.skin = {.law = SkinLaw::kExponential,
                   .tension_along = kTension,
                   .tension_across = kTension,
                   .shear = 100,
                   .stiffening = 1,
                   .fiber_stiffness = fibers,
                   .fiber_stiffening = 1};
    params.solver = {.sweeps = 30, .damping = 0};
    const Model model = block_model(block, params);
    State state = make_state(model);
    const double a = 6 * kSpacing, middle = (kN - 1) / 2 * kSpacing, y = middle + 0.5 * kSpacing;
    const BladePath path =
        lay_blade(model, state, {.from = {middle - a, y, 0}, .to = {middle + a, y, 0}, .depth = 0.002})
            .value();
    cut_edges(model, state, path, 0, 1, 0);
    for (int n = 0; n < 20; n++) step(kBoth, model, state, {}, 0.1);  // long steps: no inertia
    const SkinTangent t = skin_tangent(params.skin, *stretch_of_tension(params.skin));
    const double expected =
        4 * kTension * a *
        slit_compliance({.along = t.along, .across = t.across, .coupling = t.coupling, .shear = t.shear});
    const double found = measure_wound(model, state, path, 0).gape_max;
    EXPECT_NEAR(found, expected, 0.12 * expected) << fibers;
  }
}

/// Largest displacement of nodes and virtual nodes [m].
double largest_displacement(const Model& model, const State& state) {
  double most = 0;
  for (std::size_t s = 0; s < model.anatomy.tissue.size(); s++)
    most = std::max(most, norm(Vec3d(state.motion.u[s])));
  for (const VirtualNodeDisplacement& u : state.motion.virtual_u)
    most = std::max(most, norm(Vec3d{u.x, u.y, u.z}));
  return most;
}

// A wound in skin of the defaults under a high tension opens in a few sweeps a frame and stays finite: Newton
// steps do not end where the exponential is stiff beyond measure. No frame of the blade moves skin farther
// than the wound at rest.
TEST(SkinExponential, OpeningWoundStaysFinite) {
  for (const double tension : {30.0, 90.0}) {
    Params params;
    params.tissue = {.law = TissueLaw::kSolid, .poisson = 0.45};
    params.skin = {.law = SkinLaw::kExponential, .tension_along = tension, .tension_across = tension};
    params.solver.sweeps = 4;
    Block block{.size = {25, 25, 5}, .spacing = 0.006, .young = 5e3};
    block.is_fixed = [](Int3 p) { return p.x == 0 || p.y == 0 || p.z == 0 || p.x == 24 || p.y == 24; };
    const Model model = block_model(block, params);
    State state = make_state(model);
    const BladePath path =
        lay_blade(model, state, {.from = {0.041, 0.0753, 0.024}, .to = {0.103, 0.0701, 0.024}, .depth = 0.01})
            .value();
    double most = 0;
    for (int frame = 0; frame < 80; frame++) {
      if (frame < 20) cut_edges(model, state, path, frame / 20.0, (frame + 1) / 20.0, 0);
      const StepReport report = step(kBoth, model, state, {}, 1.0 / 60);
      ASSERT_TRUE(report.finite) << frame;
      most = std::max(most, largest_displacement(model, state));
    }
    EXPECT_LT(most, 1.1 * largest_displacement(model, state)) << tension;
    const double gape = measure_wound(model, state, path, 0).gape_max;
    EXPECT_GT(gape, 0.001) << tension;
    EXPECT_LT(gape, 0.03) << tension;
    for (int frame = 0; frame < 20; frame++) step(kBoth, model, state, {}, 1.0 / 60);
    EXPECT_NEAR(measure_wound(model, state, path, 0).gape_max, gape, 0.02 * gape) << "rests";
  }
}

}  // namespace
}  // namespace turgor::lattice
