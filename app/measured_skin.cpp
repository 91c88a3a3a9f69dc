// Porcine skin under biaxial stretch (Tac et al. 2022): laws fitted to two of three protocols predict the
// third, at a point of the material and as a sheet of a lattice body. Each protocol is predicted in turn.
#include <algorithm>
#include <cmath>
#include <span>

#include <fmt/format.h>

#include "app/least_squares.hpp"
#include "app/measured_table.hpp"
#include "turgor/models/lattice/build/block_body.hpp"
#include "turgor/models/lattice/lattice.hpp"
#include "turgor/sim/scene/tissue_presets.hpp"

namespace turgor {

namespace {

constexpr const char* kSkinSource =
    "Tac, Sahli Costabal, Tepole 2022 (Computer Methods in Applied Mechanics and Engineering 398, 115248)";

struct BiaxialPoint {
  double stretch[2], stress[2];  // Cauchy [kPa]
};
// quoted points of the published curves
constexpr BiaxialPoint kEquibiaxial[] = {
    {{1, 1}, {0.4547, 1.154}},          {{1.0108, 1.0106}, {-0.4597, 0.2692}},
    {{1.0229, 1.0228}, {5.117, 5.721}}, {{1.0337, 1.0333}, {7.051, 11.38}},
    {{1.0448, 1.0445}, {20.24, 22.72}}, {{1.0557, 1.0555}, {32.84, 51.36}},
    {{1.0683, 1.0681}, {59.27, 95.03}}, {{1.0795, 1.0793}, {93.08, 152.2}},
    {{1.0911, 1.0909}, {139.3, 226.2}}, {{1.1026, 1.1023}, {192.5, 313.5}},
    {{1.1157, 1.1156}, {275.4, 449.3}}, {{1.1275, 1.1276}, {364.9, 603.7}}};
constexpr BiaxialPoint kStripX[] = {
    {{1, 1}, {0.456, 1.167}},      {{1.0186, 1}, {1.393, 0.2692}}, {{1.037, 1}, {-0.4729, 0.2692}},
    {{1.0557, 1}, {4.333, 2.962}}, {{1.075, 1}, {7.353, 6.552}},   {{1.0944, 1}, {15.37, 13.82}},
    {{1.1165, 1}, {31.87, 21.99}}, {{1.1366, 1}, {60.23, 36.53}},  {{1.1572, 1}, {103.2, 58.25}},
    {{1.1782, 1}, {172.2, 82.75}}, {{1.1995, 1}, {269.8, 118.9}},  {{1.2215, 1}, {412.8, 167}}};
constexpr BiaxialPoint kStripY[] = {
    {{1, 1}, {2.263, -0.6247}},    {{1, 1.0124}, {1.358, 0.2711}}, {{1, 1.0263}, {4.074, 4.855}},
    {{1, 1.0391}, {4.979, 9.645}}, {{1, 1.0535}, {12.13, 23.04}},  {{1, 1.066}, {17.56, 42.53}},
    {{1, 1.0813}, {28.34, 85.02}}, {{1, 1.0942}, {40.01, 128.4}},  {{1, 1.1095}, {57.03, 206.2}},
    {{1, 1.1232}, {76.86, 300.8}}, {{1, 1.1389}, {106.5, 445.7}},  {{1, 1.1524}, {135.2, 608.7}}};

/// Cauchy stress of the columns of a law, for each stretch along x and y.
using Columns = std::vector<std::vector<double>>;

/// Law of exponential skin, fibers along y, for unit µ and k1; b and k2 enter nonlinearly.
///   W = µ/2b (exp(b (I₁ − 3)) − 1) + k1/2k2 (exp(k2 E²) − 1),  E = λy² − 1 > 0
///   I₁ = λx² + λy² + 1/(λx λy)²,  σᵢ = λᵢ ∂W/∂λᵢ
Columns exponential_columns(const std::vector<double>& x, std::span<const BiaxialPoint> points) {
  const double b = std::exp(x[0]), k2 = std::exp(x[1]);
  Columns columns(2);
  for (const BiaxialPoint& p : points)
    for (int axis = 0; axis < 2; axis++) {
      const double a = p.stretch[0] * p.stretch[0], c = p.stretch[1] * p.stretch[1], through = 1 / (a * c);
      const double e = std::max(0.0, c - 1);
      columns[0].push_back(std::exp(std::min(80.0, b * (a + c + through - 3))) *
                           (p.stretch[axis] * p.stretch[axis] - through));
      columns[1].push_back(axis == 0 ? 0 : 2 * c * e * std::exp(std::min(80.0, k2 * e * e)));
    }
  return columns;
}

/// Fiber law of lattices, for unit K and K β: σᵢ = λᵢ s (1 + β s), s = λᵢ − 1 > 0. Fibers do not act on each
/// other.
Columns fiber_columns(std::span<const BiaxialPoint> points) {
  Columns columns(2);
  for (const BiaxialPoint& p : points)
    for (const double stretch : p.stretch) {
      const double s = std::max(0.0, stretch - 1);
      columns[0].push_back(stretch * s);
      columns[1].push_back(stretch * s * s);
    }
  return columns;
}

std::vector<double> stresses(std::span<const BiaxialPoint> points) {
  std::vector<double> list;
  for (const BiaxialPoint& p : points) list.insert(list.end(), {p.stress[0], p.stress[1]});
  return list;
}

std::vector<double> combined(const Columns& columns, const std::vector<double>& coefficients) {
  std::vector<double> sum(columns[0].size(), 0);
  for (std::size_t j = 0; j < columns.size(); j++)
    for (std::size_t n = 0; n < sum.size(); n++) sum[n] += coefficients[j] * columns[j][n];
  return sum;
}

/// One of the three tests, and the points of the other two, which are fitted.
struct SkinProtocol {
  const char *name, *file;
  std::span<const BiaxialPoint> points;
  std::vector<BiaxialPoint> others;
};
std::vector<BiaxialPoint> joined(std::span<const BiaxialPoint> a, std::span<const BiaxialPoint> b) {
  std::vector<BiaxialPoint> points(a.begin(), a.end());
  points.insert(points.end(), b.begin(), b.end());
  return points;
}
std::vector<SkinProtocol> protocols() {
  return {{"skin strip along y", "skin-strip-y", kStripY, joined(kEquibiaxial, kStripX)},
          {"skin strip along x", "skin-strip-x", kStripX, joined(kEquibiaxial, kStripY)},
          {"equibiaxial skin", "skin-equibiaxial", kEquibiaxial, joined(kStripX, kStripY)}};
}

/// Values of the exponential law; stresses in kPa.
struct FittedSkin {
  std::vector<double> shape;     // logarithms of b and k2
  std::vector<double> stresses;  // µ and k1 [kPa]
};
FittedSkin fit_exponential(const std::vector<BiaxialPoint>& points) {
  const std::vector<double> measured = stresses(points);
  const auto error = [&](const std::vector<double>& x) {
    return fit_non_negative(exponential_columns(x, points), measured).squared_error;
  };
  // the best of three starts
  FittedSkin best;
  for (const double start : {1.0, 2.0, 3.0}) {
    const std::vector<double> found = minimize(error, {2, start}, 0.5, 400);
    if (best.shape.empty() || error(found) < error(best.shape)) best.shape = found;
  }
  best.stresses = fit_non_negative(exponential_columns(best.shape, points), measured).coefficients;
  return best;
}

std::vector<double> predict_fiber(const SkinProtocol& protocol) {
  const std::vector<BiaxialPoint>& points = protocol.others;
  return combined(fiber_columns(protocol.points),
                  fit_non_negative(fiber_columns(points), stresses(points)).coefficients);
}

/// Rows and curves of both stresses; bands of 10 % of the largest stress.
void add_law(const SkinProtocol& protocol, const char* file, const char* law,
             const std::vector<double>& predicted, MeasuredResult& result) {
  const std::vector<double> measured = stresses(protocol.points);
  const double largest = *std::max_element(measured.begin(), measured.end());
  double squares = 0;
  for (std::size_t n = 0; n < measured.size(); n++)
    squares += (predicted[n] - measured[n]) * (predicted[n] - measured[n]);
  for (int axis = 0; axis < 2; axis++) {
    const char* along = axis == 0 ? "x" : "y";
    const auto stretched = std::size_t(protocol.points.back().stretch[1] > 1);
    MeasuredCurve curve{fmt::format("{}-{}-{}.svg", protocol.file, along, file),
                        fmt::format("Stress along {}, {}, {}", along, protocol.name, law),
                        fmt::format("stretch along {}", stretched == 0 ? "x" : "y"),
                        "stress [kPa]",
                        {}};
    for (std::size_t n = 0; n < protocol.points.size(); n++) {
      const std::size_t at = 2 * n + std::size_t(axis);
      curve.points.push_back(
          {protocol.points[n].stretch[stretched], measured[at], 0.1 * largest, predicted[at]});
    }
    const auto& last = curve.points.back();
    result.rows.push_back(
        band_row(fmt::format("{}, {}: stress along {} at the end", protocol.name, law, along), kSkinSource,
                 "kPa", last.measured, last.half, last.predicted));
    result.curves.push_back(std::move(curve));
  }
  result.rows.push_back({fmt::format("{}, {}: rms over the largest stress", protocol.name, law), kSkinSource,
                         "1", 0, 0, 0.1, std::sqrt(squares / double(measured.size())) / largest});
}

// ------------------------------------------------------------------------------------------------- body

constexpr double kThickness = 0.0015;  // [m]

/// A sheet of skin without tension and almost without tissue, its fibers along y.
lattice::Model skin_sheet(const FittedSkin& skin) {
  constexpr double kPascals = 1e3;
  lattice::Params params;
  params.skin = {.law = lattice::SkinLaw::kExponential,
                 .tension_along = 0,
                 .tension_across = 0,
                 .shear = skin.stresses[0] * kPascals * kThickness,
                 .stiffening = std::exp(skin.shape[0]),
                 .fiber_stiffness = skin.stresses[1] * kPascals * kThickness,
                 .fiber_stiffening = std::exp(skin.shape[1]),
                 .direction = {0, 1, 0}};
  params.solver.sweeps = 20;
  return lattice::block_model({.size = {9, 9, 1}, .spacing = 0.002, .young = 1e-3}, params);
}

/// Cauchy stresses of a sheet whose border is moved to each point's stretches [kPa]: forces of two sides over
/// their deformed section.
std::vector<double> stretch_sheet(const Exec& exec, const lattice::Model& model,
                                  std::span<const BiaxialPoint> points) {
  const Int3 size = model.anatomy.lattice.size;
  const double h = double(model.anatomy.lattice.spacing.x), length = h * (size.x - 1);
  std::vector<lattice::NodeContact> border;
  for (int j = 0; j < size.y; j++)
    for (int i = 0; i < size.x; i++)
      if (i == 0 || j == 0 || i == size.x - 1 || j == size.y - 1)
        border.push_back({.slot = node_slot(model.anatomy.lattice, {i, j, 0}), .is_held = true});
  std::sort(border.begin(), border.end(), [](const auto& a, const auto& b) { return a.slot < b.slot; });

  lattice::State state = lattice::make_state(model);
  std::vector<double> stress;
  for (const BiaxialPoint& point : points) {
    for (lattice::NodeContact& c : border) {
      const Int3 p = slot_node(model.anatomy.lattice, c.slot);
      c.target = {Real((point.stretch[0] - 1) * h * p.x), Real((point.stretch[1] - 1) * h * p.y), 0};
    }
    for (int n = 0; n < 10; n++) lattice::step(exec, model, state, {.contacts = border}, 1.0 / 60);
    double force[2] = {};
    for (const lattice::NodeContact& c : border) {
      const Int3 p = slot_node(model.anatomy.lattice, c.slot);
      if (p.x == size.x - 1) force[0] += double(c.force.x);
      if (p.y == size.y - 1) force[1] += double(c.force.y);
    }
    // width λ₁ L and thickness t/(λ₁ λ₂) of the section across axis 2
    for (int axis = 0; axis < 2; axis++)
      stress.push_back(force[axis] * point.stretch[axis] / (length * kThickness) * 1e-3);
  }
  return stress;
}

/// Row of the preset: its error in all protocols, relative to the largest stress.
void add_skin_preset(MeasuredResult& result) {
  const TissuePreset& preset = *find_preset("skin-porcine", PresetKind::kSkin);
  const auto stress = [&](const char* key) { return 1e-3 * value_or(&preset, key, 0) / kThickness; };
  const std::vector<double> shape = {std::log(value_or(&preset, "stiffening", 0)),
                                     std::log(value_or(&preset, "fiber_stiffening", 0))};
  const std::vector<BiaxialPoint> all = joined(joined(kEquibiaxial, kStripX), kStripY);
  const std::vector<double> measured = stresses(all);
  const std::vector<double> found =
      combined(exponential_columns(shape, all), {stress("shear"), stress("fiber_stiffness")});
  MeasuredCurve curve;
  for (std::size_t n = 0; n < measured.size(); n++) curve.points.push_back({0, measured[n], 0, found[n]});
  result.rows.push_back({"preset skin-porcine, three protocols: rms over the largest stress", kSkinSource,
                         "1", 0, 0, 0.05, relative_rms(curve)});
}

}  // namespace

void add_skin_sheet(const Exec& exec, MeasuredResult& result) {
  for (const SkinProtocol& protocol : protocols()) {
    const FittedSkin skin = fit_exponential(protocol.others);
    add_law(protocol, "exponential", "exponential law",
            combined(exponential_columns(skin.shape, protocol.points), skin.stresses), result);
    add_law(protocol, "body", "lattice body", stretch_sheet(exec, skin_sheet(skin), protocol.points), result);
  }
  add_skin_preset(result);
  const SkinProtocol strip = protocols()[0];
  add_law(strip, "fiber", "fiber law", predict_fiber(strip), result);
}

}  // namespace turgor
