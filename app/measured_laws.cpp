// Laws of solids against closed forms of homogeneous deformations, the kind of problem by which the suites of
// finite-element programs test their materials: nominal stress of incompressible blocks [Ogden 1997, chapter
// 7], and blocks of distorted elements that tractions deform.
//
//   uniaxial     P = W'(λ)     λ₂ = λ₃ = λ^(−1/2)         exponential: W' = µ exp(b (I₁ − 3)) (λ − λ^(−2))
//   equibiaxial  2 P = W'(λ)   λ₃ = λ^(−2)                Ogden: P = 2µ/α (λ^(α−1) − λ₃^α/λ)
//   pure shear   P = W'(λ)     λ₂ = 1, λ₃ = 1/λ
//   simple shear P = W'(γ)     λ = γ/2 + √(1 + γ²/4)
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include <fmt/format.h>

#include "app/measured_table.hpp"
#include "turgor/geometry/hex_block.hpp"
#include "turgor/models/lattice/mechanics/solid_laws.hpp"
#include "turgor/models/sfem/nonlinear_patch.hpp"

namespace turgor {

namespace {

constexpr const char* kClosed = "closed form, Ogden 1997";
constexpr double kAllowed = 0.01;  // relative
constexpr double kShear = 2e3, kBulkOverShear = 2e4;

using Energy = std::function<double(const Mat3d&)>;

Energy of_sfem(double b) {
  return [b](const Mat3d& f) { return sfem::law_energy(f, {kBulkOverShear * kShear, kShear}, {b}); };
}
Energy of_ogden(double alpha) {
  return [alpha](const Mat3d& f) {
    return lattice::law_energy(lattice::SolidEnergy::kOgden, f, {kShear, kBulkOverShear * kShear, alpha});
  };
}

Mat3d stretched(double x, double y, double z) { return {{{x, 0, 0}, {0, y, 0}, {0, 0, z}}}; }

/// Deformations of one stretch or shear; free sides adjust themselves.
enum class Protocol { kUniaxial, kEquibiaxial, kPureShear, kSimpleShear };

/// Energy at a stretch; the free stretch minimizes it, by Newton steps with differences.
double relaxed_energy(const Energy& energy, Protocol protocol, double stretch) {
  const auto at = [&](double free) {
    if (protocol == Protocol::kUniaxial) return energy(stretched(stretch, free, free));
    if (protocol == Protocol::kEquibiaxial) return energy(stretched(stretch, stretch, free));
    if (protocol == Protocol::kPureShear) return energy(stretched(stretch, 1, free));
    return energy({{{1, 0, 0}, {stretch, 1, 0}, {0, 0, 1}}});
  };
  if (protocol == Protocol::kSimpleShear) return at(1);
  double free = protocol == Protocol::kUniaxial      ? 1 / std::sqrt(stretch)
                : protocol == Protocol::kEquibiaxial ? 1 / (stretch * stretch)
                                                     : 1 / stretch;
  constexpr double kStep = 1e-4;
  for (int i = 0; i < 20; i++) {
    const double up = at(free + kStep), down = at(free - kStep), middle = at(free);
    free -= kStep / 2 * (up - down) / (up - 2 * middle + down);
  }
  return at(free);
}

/// Nominal stress: slope of the energy, shared by two directions of an equibiaxial stretch.
double nominal_stress(const Energy& energy, Protocol protocol, double stretch) {
  constexpr double kStep = 1e-4;
  const double slope = (relaxed_energy(energy, protocol, stretch + kStep) -
                        relaxed_energy(energy, protocol, stretch - kStep)) /
                       (2 * kStep);
  return protocol == Protocol::kEquibiaxial ? slope / 2 : slope;
}

/// The other stretches and I₁ of an incompressible block.
std::array<double, 3> stretches(Protocol protocol, double s) {
  if (protocol == Protocol::kUniaxial) return {s, 1 / std::sqrt(s), 1 / std::sqrt(s)};
  if (protocol == Protocol::kEquibiaxial) return {s, s, 1 / (s * s)};
  if (protocol == Protocol::kPureShear) return {s, 1, 1 / s};
  const double longest = s / 2 + std::sqrt(1 + s * s / 4);
  return {longest, 1 / longest, 1};
}
double exponential_stress(double b, Protocol protocol, double s) {
  const auto [x, y, z] = stretches(protocol, s);
  const double c = kShear * std::exp(b * (x * x + y * y + z * z - 3));
  if (protocol == Protocol::kSimpleShear) return c * s;
  return c * (s - z * z / s);
}
double ogden_stress(double alpha, Protocol protocol, double s) {
  const auto [x, y, z] = stretches(protocol, s);
  const double scale = 2 * kShear / alpha;
  if (protocol == Protocol::kSimpleShear)
    return scale * (std::pow(x, alpha) - std::pow(x, -alpha)) * x / (1 + x * x);
  return scale * (std::pow(s, alpha) - std::pow(z, alpha)) / s;
}

void add_stresses(MeasuredResult& result) {
  struct Case {
    const char* name;
    Protocol protocol;
    double stretch;
  };
  const auto add = [&](const std::string& law, const Case& c, double expected, double found) {
    result.rows.push_back(band_row(fmt::format("{}, {} {:.3g}: nominal stress", law, c.name, c.stretch),
                                   kClosed, "Pa", expected, kAllowed * std::abs(expected), found));
  };
  constexpr Case kNeoHookean[] = {{"uniaxial", Protocol::kUniaxial, 1.5},
                                  {"uniaxial", Protocol::kUniaxial, 0.6},
                                  {"equibiaxial", Protocol::kEquibiaxial, 1.4},
                                  {"pure shear", Protocol::kPureShear, 1.5},
                                  {"simple shear", Protocol::kSimpleShear, 0.8}};
  for (const Case& c : kNeoHookean)
    add("neo-Hookean", c, exponential_stress(0, c.protocol, c.stretch),
        nominal_stress(of_sfem(0), c.protocol, c.stretch));
  constexpr Case kExponential[] = {{"uniaxial", Protocol::kUniaxial, 1.3},
                                   {"uniaxial", Protocol::kUniaxial, 0.7},
                                   {"equibiaxial", Protocol::kEquibiaxial, 1.2},
                                   {"pure shear", Protocol::kPureShear, 1.25},
                                   {"simple shear", Protocol::kSimpleShear, 0.6}};
  for (const Case& c : kExponential)
    add("exponential b = 2", c, exponential_stress(2, c.protocol, c.stretch),
        nominal_stress(of_sfem(2), c.protocol, c.stretch));
  constexpr Case kOgden[] = {{"uniaxial", Protocol::kUniaxial, 1.3},
                             {"equibiaxial", Protocol::kEquibiaxial, 1.2},
                             {"pure shear", Protocol::kPureShear, 1.3},
                             {"simple shear", Protocol::kSimpleShear, 0.4}};
  for (const double alpha : {6.83, -8.0})
    for (const Case& c : kOgden)
      add(fmt::format("Ogden alpha = {:.3g}", alpha), c, ogden_stress(alpha, c.protocol, c.stretch),
          nominal_stress(of_ogden(alpha), c.protocol, c.stretch));
}

/// Displacement gradient of a block that stands on its base: u = z g.
struct SlantedBlock {
  std::string name;
  Vec3d g;
  double b = 0;
};

/// Largest error of the displacement of a distorted block under the tractions of a homogeneous deformation,
/// relative to the largest displacement; the tractions are differences of the energy. Dead loads that
/// compress a block are not among them: its homogeneous state is then not stable.
double slant_error(const SlantedBlock& slanted) {
  constexpr double kYoung = 4e3, kPoisson = 0.4;
  const Vec3d size{0.03, 0.024, 0.02};
  const auto refused = [] { return 1.0; };
  sfem::Body body;
  body.mesh = tetrahedralize(hex_block(size, {3, 3, 2})), body.materials = {{kYoung, kPoisson}};
  for (Vec3d& x : body.mesh.vertices) {
    body.fixed.push_back(x.z < 1e-9);
    const bool inside = x.x > 1e-9 && x.y > 1e-9 && x.z > 1e-9 && x.x < size.x - 1e-9 &&
                        x.y < size.y - 1e-9 && x.z < size.z - 1e-9;
    if (inside) x += Vec3d{0.0021, -0.0013, 0.0017};
  }
  Result<sfem::Model> model =
      sfem::build(Exec(1), std::move(body), {.precision = sfem::Precision::kDouble, .touch_depth = 0.02});
  if (!model || !sfem::compute_green(Exec(1), *model, std::size_t(1e9))) return refused();
  const std::vector<Vec3d> touch{{size.x / 2, size.y / 2, size.z}};
  const Result<sfem::Patch> linear =
      sfem::build_patch(*model, sfem::patch_elements(*model, touch, 1.0), 1, touch);
  if (!linear) return refused();
  Result<sfem::NonlinearPatch> patch = sfem::make_nonlinear_patch(*model, *linear, 1, {slanted.b});
  if (!patch) return refused();
  // stress by differences of the energy
  Mat3d f;
  f.column[2] += slanted.g;
  Mat3d stress;
  constexpr double kStep = 1e-6;
  const sfem::Moduli moduli = sfem::moduli(sfem::Material{kYoung, kPoisson});
  for (int column = 0; column < 3; column++)
    for (int row = 0; row < 3; row++) {
      Mat3d up = f, down = f;
      up.column[column][row] += kStep, down.column[column][row] -= kStep;
      stress.column[column][row] =
          (sfem::law_energy(up, moduli, {slanted.b}) - sfem::law_energy(down, moduli, {slanted.b})) /
          (2 * kStep);
    }
  // tractions on the surface's triangles, a third to each corner
  std::vector<double> forces(3 * linear->points.size());
  for (const Int3 t : linear->triangles) {
    const auto x = [&](int corner) { return linear->points[std::size_t(t[corner])].x; };
    const Vec3d force = stress * (cross(x(1) - x(0), x(2) - x(0)) / 6);
    for (int corner = 0; corner < 3; corner++)
      for (int i = 0; i < 3; i++) forces[3 * std::size_t(t[corner]) + std::size_t(i)] += force[i];
  }
  if (!sfem::solve_nonlinear(*patch, forces, 30)) return refused();
  const std::vector<Vec3d> u = sfem::point_displacements(*patch);
  double error = 0;
  for (std::size_t p = 0; p < u.size(); p++)
    error = widest(error, norm(u[p] - linear->points[p].x.z * slanted.g));
  return error / (size.z * norm(slanted.g));
}

}  // namespace

void add_laws(MeasuredResult& result) {
  add_stresses(result);
  const SlantedBlock blocks[] = {{"neo-Hookean block, height × 1.3", {0, 0, 0.3}, 0},
                                 {"exponential block, simple shear 0.4", {0.4, 0, 0}, 3},
                                 {"exponential block, sheared and stretched", {0.2, -0.3, 0.15}, 3}};
  for (const SlantedBlock& block : blocks)
    result.rows.push_back({block.name + ": error of displacement", "homogeneous deformation", "1", 0, 0,
                           kAllowed, slant_error(block)});
}

}  // namespace turgor
