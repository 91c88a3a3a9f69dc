// Muscle under unconfined compression: ramp to 30 % and hold, along and across the fibers (Van Loocke et
// al.). The exponential law is also that of a body: a block of lattice cells between plates without friction.
// Laws at a point of the material, fitted at 1 %/s, predict 0.5 %/s. Three elastic stresses are relaxed by
// three Prony pairs: the linear one, which sfem bodies have, the exponential and the Ogden one. A fit of both
// rates shows the least error of the exponential one.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>

#include <fmt/format.h>

#include "app/least_squares.hpp"
#include "app/measured_table.hpp"
#include "app/muscle_points.hpp"
#include "turgor/models/lattice/build/block_body.hpp"
#include "turgor/models/lattice/lattice.hpp"
#include "turgor/models/prony.hpp"
#include "turgor/sim/scene/tissue_presets.hpp"

namespace turgor {

namespace {

constexpr const char* kMuscleSource = "Van Loocke, Lyons, Simms 2008 (Journal of Biomechanics 41, 1555)";
constexpr double kFinal = 0.3;                 // compression that is held [1]
constexpr double kFast = 0.01, kSlow = 0.005;  // rates of the ramps [1/s]

enum class MuscleLaw : std::uint8_t { kLinear, kExponential, kOgden };
constexpr const char *kMuscleLawNames[] = {"linear", "exponential", "Ogden"},
                     *kMuscleLawFiles[] = {"linear", "exponential", "ogden"};

/// Second Piola-Kirchhoff stress of a law at a stretch, in compression and per unit of its modulus.
///   linear        σ = ε, ε = 1 − λ
///   exponential   σ = exp(b (I₁ − 3)) (1/λ − λ²), I₁ = λ² + 2/λ, incompressible
///   Ogden         σ = 2/b (λ^(−b/2) − λ^b), incompressible
/// All: S = σ/λ².
struct ElasticStress {
  MuscleLaw law;
  double b;  // stiffening, or Ogden's exponent [1]

  double operator()(double stretch) const {
    const double square = stretch * stretch;
    if (law == MuscleLaw::kLinear) return (1 - stretch) / square;
    if (law == MuscleLaw::kOgden) return 2 / b * (std::pow(stretch, -b / 2) - std::pow(stretch, b)) / square;
    return std::exp(b * (square + 2 / stretch - 3)) * (1 / stretch - square) / square;
  }
};

/// Curve that was measured with a ramp of this rate.
struct RatedCurve {
  double rate;  // [1/s]
  std::span<const StressPoint> points;
};

/// Cauchy stress at the points' times: the elastic part, then that of each relaxation time with share 1.
///   H ← a H + γ (S_new − S_old),  a = exp(−h/τ),  γ = (1 − a) τ/h
std::vector<std::vector<double>> stress_columns(const ElasticStress& law,
                                                const std::array<double, kMostPronyPairs>& times,
                                                const RatedCurve& curve) {
  constexpr double kStep = 0.05;  // [s]
  std::vector<std::vector<double>> columns(1 + times.size());
  std::array<double, kMostPronyPairs> history{};
  double time = 0, elastic = 0, stretch = 1;
  for (const StressPoint& point : curve.points) {
    while (time < point.time) {
      const double h = std::min(kStep, point.time - time);
      time += h;
      stretch = 1 - std::min(curve.rate * time, kFinal);
      const double next = law(stretch);
      for (std::size_t i = 0; i < times.size(); i++) {
        const double a = std::exp(-h / times[i]);
        history[i] = a * history[i] + (1 - a) * times[i] / h * (next - elastic);
      }
      elastic = next;
    }
    columns[0].push_back(stretch * stretch * elastic);
    for (std::size_t i = 0; i < times.size(); i++) columns[1 + i].push_back(stretch * stretch * history[i]);
  }
  return columns;
}

/// A law with its fitted values.
struct FittedMuscle {
  ElasticStress law;
  std::array<double, kMostPronyPairs> times{};  // [s]
  std::vector<double> moduli;                   // static one, then one per time [kPa]
};

/// Values of a law that fit one or more curves together.
FittedMuscle fit_muscle(MuscleLaw law, std::span<const RatedCurve> curves) {
  std::vector<double> measured;
  for (const RatedCurve& curve : curves)
    for (const StressPoint& point : curve.points) measured.push_back(point.stress);
  // columns of all curves, one curve after the other
  const auto columns_of = [&](const FittedMuscle& made) {
    std::vector<std::vector<double>> all(1 + made.times.size());
    for (const RatedCurve& curve : curves) {
      const std::vector<std::vector<double>> one = stress_columns(made.law, made.times, curve);
      for (std::size_t j = 0; j < all.size(); j++) all[j].insert(all[j].end(), one[j].begin(), one[j].end());
    }
    return all;
  };
  // b and the logarithms of the times enter nonlinearly, the moduli linearly
  const auto of = [&](const std::vector<double>& x) {
    FittedMuscle made{{law, x[3]}, {std::exp(x[0]), std::exp(x[1]), std::exp(x[2])}, {}};
    return made;
  };
  const auto error = [&](const std::vector<double>& x) {
    if (std::abs(x[3]) > 20 || *std::max_element(x.begin(), x.begin() + 3) > 8) return 1e9;
    if (law == MuscleLaw::kOgden && std::abs(x[3]) < 1) return 1e9;
    const FittedMuscle made = of(x);
    return fit_non_negative(columns_of(made), measured).squared_error;
  };
  const auto fit_from = [&](double b) {
    return minimize(error, {std::log(2.0), std::log(20.0), std::log(200.0), b}, 0.5, 400);
  };
  // an Ogden law stiffens by exponents of either sign
  std::vector<double> best = fit_from(law == MuscleLaw::kOgden ? -8 : 2);
  if (law == MuscleLaw::kOgden)
    if (const std::vector<double> other = fit_from(8); error(other) < error(best)) best = other;
  FittedMuscle fitted = of(best);
  fitted.moduli = fit_non_negative(columns_of(fitted), measured).coefficients;
  return fitted;
}

std::vector<double> predict(const FittedMuscle& muscle, const RatedCurve& curve) {
  const std::vector<std::vector<double>> columns = stress_columns(muscle.law, muscle.times, curve);
  std::vector<double> stress(curve.points.size(), 0);
  for (std::size_t j = 0; j < columns.size(); j++)
    for (std::size_t n = 0; n < stress.size(); n++) stress[n] += muscle.moduli[j] * columns[j][n];
  return stress;
}

/// Rows and the curve of one direction and law: fitted at 1 %/s, predicted at 0.5 %/s.
void add_direction(const char* direction, MuscleLaw form, std::span<const StressPoint> fast,
                   std::span<const StressPoint> slow, MeasuredResult& result) {
  const RatedCurve fitted[] = {{kFast, fast}};
  const FittedMuscle muscle = fit_muscle(form, fitted);
  const std::vector<double> predicted = predict(muscle, {kSlow, slow});
  const char* law = kMuscleLawNames[std::size_t(form)];
  // curve with a band of 5 % of the peak
  double peak = 0;
  for (const StressPoint& point : slow) peak = std::max(peak, point.stress);
  MeasuredCurve curve{fmt::format("muscle-{}-{}.svg", direction, kMuscleLawFiles[std::size_t(form)]),
                      fmt::format("Muscle {} the fibers, 0.5 %/s, {} law", direction, law),
                      "time [s]",
                      "stress [kPa]",
                      {}};
  for (std::size_t n = 0; n < slow.size(); n++)
    curve.points.push_back({slow[n].time, slow[n].stress, 0.05 * peak, predicted[n]});
  // peak, end of the hold, all points
  const std::string name = fmt::format("muscle {} the fibers, {} law: ", direction, law);
  constexpr std::size_t kPeak = 7;  // the last point of the ramp
  result.rows.push_back(
      band_row(name + "peak", kMuscleSource, "kPa", slow[kPeak].stress, 0.05 * peak, predicted[kPeak]));
  result.rows.push_back(band_row(name + "end of the hold", kMuscleSource, "kPa", slow.back().stress,
                                 0.05 * peak, predicted.back()));
  result.rows.push_back({name + "rms over the peak", kMuscleSource, "1", 0, 0, 0.05, relative_rms(curve)});
  result.curves.push_back(std::move(curve));
}

/// The slow curve under values that fit both rates together: the least that this law and its pairs can miss.
void add_least_error(const char* direction, std::span<const StressPoint> fast,
                     std::span<const StressPoint> slow, MeasuredResult& result) {
  const RatedCurve both[] = {{kFast, fast}, {kSlow, slow}};
  const FittedMuscle muscle = fit_muscle(MuscleLaw::kExponential, both);
  const std::vector<double> found = predict(muscle, both[1]);
  MeasuredCurve curve{fmt::format("muscle-{}-both-rates.svg", direction),
                      fmt::format("Muscle {} the fibers, 0.5 %/s, fitted to both rates", direction),
                      "time [s]",
                      "stress [kPa]",
                      {}};
  double peak = 0;
  for (const StressPoint& point : slow) peak = std::max(peak, point.stress);
  for (std::size_t n = 0; n < slow.size(); n++)
    curve.points.push_back({slow[n].time, slow[n].stress, 0.05 * peak, found[n]});
  result.rows.push_back(
      {fmt::format("muscle {} the fibers, fitted to both rates: rms over the peak", direction), kMuscleSource,
       "1", 0, 0, 0.05, relative_rms(curve)});
  result.curves.push_back(std::move(curve));
}

/// Values of a preset: µ is a third of its modulus, and the pairs are shares of the instantaneous stress.
FittedMuscle muscle_of(const TissuePreset& preset) {
  FittedMuscle muscle{{MuscleLaw::kExponential, value_or(&preset, "stiffening", 0)}, {}, {}};
  constexpr const char* kPairs[kMostPronyPairs][2] = {{"g1", "tau1"}, {"g2", "tau2"}, {"g3", "tau3"}};
  double rest = 1;
  for (const auto& [share, time] : kPairs) rest -= value_or(&preset, share, 0);
  const double shear = 1e-3 * value_or(&preset, "young", 0) / 3;  // [kPa]
  muscle.moduli = {shear};
  for (std::size_t i = 0; i < kMostPronyPairs; i++) {
    muscle.moduli.push_back(shear * value_or(&preset, kPairs[i][0], 0) / rest);
    muscle.times[i] = value_or(&preset, kPairs[i][1], 1);
  }
  return muscle;
}

/// Row of a preset: the larger error of both rates.
void add_muscle_preset(const char* direction, std::span<const StressPoint> fast,
                       std::span<const StressPoint> slow, MeasuredResult& result) {
  const std::string name = fmt::format("muscle-porcine-{}", direction);
  const FittedMuscle muscle = muscle_of(*find_preset(name, PresetKind::kSolid));
  double worst = 0;
  for (const RatedCurve& curve : {RatedCurve{kFast, fast}, RatedCurve{kSlow, slow}}) {
    const std::vector<double> found = predict(muscle, curve);
    MeasuredCurve points;
    for (std::size_t n = 0; n < found.size(); n++)
      points.points.push_back({curve.points[n].time, curve.points[n].stress, 0, found[n]});
    worst = widest(worst, relative_rms(points));
  }
  result.rows.push_back(
      {fmt::format("preset {}, both rates: rms over the peak", name), kMuscleSource, "1", 0, 0, 0.05, worst});
}

// ------------------------------------------------------------------------------------------------- bodies

/// Block of cells with the values of a fit: µ is the static modulus, p the others over it.
lattice::Model muscle_block(const FittedMuscle& muscle) {
  lattice::Params params;
  params.skin.enabled = false;
  params.tissue.law = lattice::TissueLaw::kSolid;
  params.tissue.energy = lattice::SolidEnergy::kExponential;
  params.tissue.stiffening = muscle.law.b;
  params.tissue.poisson = 0.499;
  const double shear = std::max(muscle.moduli[0], 1e-3) * 1e3;  // [Pa]
  std::size_t pairs = 0;
  for (std::size_t i = 0; i < muscle.times.size(); i++)
    if (muscle.moduli[1 + i] > 0)
      params.tissue.prony.pairs[pairs++] = {muscle.moduli[1 + i] * 1e3 / shear, muscle.times[i]};
  params.solver.sweeps = 30;
  return lattice::block_model({.size = {6, 6, 3},
                               .spacing = 0.004,
                               .young = 2 * (1 + params.tissue.poisson) * shear,
                               .skin_on_top = false},
                              params);
}

/// Compressive Cauchy stress of the block at the points' times [kPa]: the force of a plate over the area that
/// an incompressible block has.
std::vector<double> press_block(const Exec& exec, const lattice::Model& model, double rate,
                                std::span<const StressPoint> points) {
  constexpr double kLongest = 0.5;  // [s]
  const Int3 size = model.anatomy.lattice.size;
  const Vec3d h(model.anatomy.lattice.spacing);
  // plates below and above
  std::vector<lattice::NodeContact> contacts;
  for (const int k : {0, size.z - 1})
    for (int j = 0; j < size.y; j++)
      for (int i = 0; i < size.x; i++)
        contacts.push_back({.slot = node_slot(model.anatomy.lattice, {i, j, k}),
                            .normal = {0, 0, k == 0 ? Real(1) : Real(-1)}});
  std::sort(contacts.begin(), contacts.end(), [](const auto& a, const auto& b) { return a.slot < b.slot; });
  const double height = h.z * (size.z - 1), area = h.x * (size.x - 1) * h.y * (size.y - 1);

  lattice::State state = lattice::make_state(model);
  std::vector<double> stress;
  double time = 0;
  for (const StressPoint& point : points) {
    const int steps = int(std::ceil((point.time - time) / kLongest));
    const double step = (point.time - time) / steps;
    for (int n = 0; n < steps; n++) {
      time += step;
      const double strain = std::min(rate * time, kFinal);
      for (lattice::NodeContact& c : contacts)
        c.target = {0, 0, c.normal.z > 0 ? Real(0) : Real(-strain * height)};
      lattice::step(exec, model, state, {.contacts = contacts}, step);
    }
    double force = 0;
    for (const lattice::NodeContact& c : contacts)
      if (c.normal.z < 0) force -= double(c.force.z);
    stress.push_back(force * (1 - std::min(rate * time, kFinal)) / area * 1e-3);
  }
  return stress;
}

/// Rows and the curve of a block with the values that were fitted at 1 %/s, compressed at 0.5 %/s.
void add_block(const Exec& exec, const char* direction, std::span<const StressPoint> fast,
               std::span<const StressPoint> slow, MeasuredResult& result) {
  const RatedCurve fitted[] = {{kFast, fast}};
  const FittedMuscle muscle = fit_muscle(MuscleLaw::kExponential, fitted);
  const std::vector<double> predicted = press_block(exec, muscle_block(muscle), kSlow, slow);
  double peak = 0;
  for (const StressPoint& point : slow) peak = std::max(peak, point.stress);
  MeasuredCurve curve{fmt::format("muscle-{}-body.svg", direction),
                      fmt::format("Muscle {} the fibers, 0.5 %/s, exponential cells", direction),
                      "time [s]",
                      "stress [kPa]",
                      {}};
  for (std::size_t n = 0; n < slow.size(); n++)
    curve.points.push_back({slow[n].time, slow[n].stress, 0.05 * peak, predicted[n]});
  result.rows.push_back({fmt::format("muscle {} the fibers, lattice body: rms over the peak", direction),
                         kMuscleSource, "1", 0, 0, 0.05, relative_rms(curve)});
  result.curves.push_back(std::move(curve));
}

}  // namespace

void add_muscle_bodies(const Exec& exec, MeasuredResult& result) {
  add_block(exec, "along", kAlongFast, kAlongSlow, result);
  add_block(exec, "across", kAcrossFast, kAcrossSlow, result);
}

void add_muscle(MeasuredResult& result) {
  for (const MuscleLaw law : {MuscleLaw::kLinear, MuscleLaw::kExponential, MuscleLaw::kOgden}) {
    add_direction("along", law, kAlongFast, kAlongSlow, result);
    add_direction("across", law, kAcrossFast, kAcrossSlow, result);
  }
  add_least_error("along", kAlongFast, kAlongSlow, result);
  add_least_error("across", kAcrossFast, kAcrossSlow, result);
  add_muscle_preset("along", kAlongFast, kAlongSlow, result);
  add_muscle_preset("across", kAcrossFast, kAcrossSlow, result);
}

}  // namespace turgor
