#include "turgor/sim/identify.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

#include <fmt/format.h>

#include "turgor/core/assert.hpp"
#include "turgor/sim/student_quantile.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

namespace {

using Numbers = std::vector<double>;

double product(const Numbers& a, const Numbers& b) {
  return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
}
Numbers difference(const Numbers& a, const Numbers& b) {
  Numbers result(a.size());
  for (std::size_t i = 0; i < a.size(); i++) result[i] = a[i] - b[i];
  return result;
}
double largest(const Numbers& a) {
  double most = 0;
  for (const double x : a) most = std::max(most, std::abs(x));
  return most;
}

/// Inverse of a symmetric positive definite matrix of rows, by elimination without pivots; empty where it is
/// singular relative to its diagonal.
std::vector<Numbers> inverse(std::vector<Numbers> m) {
  constexpr double kSingular = 1e-11;
  const std::size_t n = m.size();
  for (std::size_t i = 0; i < n; i++) m[i].resize(2 * n), m[i][n + i] = 1;
  for (std::size_t i = 0; i < n; i++) {
    const double before = m[i][i];
    for (std::size_t k = 0; k < i; k++) {
      const double factor = m[i][k];
      for (std::size_t j = k; j < 2 * n; j++) m[i][j] -= factor * m[k][j];
    }
    if (!(m[i][i] > kSingular * before)) return {};
    const double pivot = m[i][i];
    for (std::size_t j = i; j < 2 * n; j++) m[i][j] /= pivot;
  }
  for (std::size_t i = n; i-- > 0;)
    for (std::size_t k = 0; k < i; k++) {
      const double factor = m[k][i];
      for (std::size_t j = i; j < 2 * n; j++) m[k][j] -= factor * m[i][j];
    }
  for (Numbers& row : m) row.erase(row.begin(), row.begin() + std::ptrdiff_t(n));
  return m;
}

constexpr double kStep = 0.02;  // of a logarithm, for sensitivities

/// Rows of all tables, each relative to the root mean square of the force of its table.
struct ScaledRows {
  Numbers force, scale;  // [1], [N]
};
ScaledRows scaled_rows(const std::vector<MeasuredForce>& tables) {
  ScaledRows rows;
  for (const MeasuredForce& table : tables) {
    const double rms = std::sqrt(product(table.force, table.force) / double(table.force.size()));
    for (const double force : table.force) rows.force.push_back(force / rms), rows.scale.push_back(rms);
  }
  return rows;
}
Status check_tables(const std::vector<MeasuredForce>& tables, std::size_t parameters) {
  std::size_t rows = 0;
  for (const MeasuredForce& table : tables) {
    if (const Status status = check_measured(table); !status) return status.error();
    rows += table.at.size();
  }
  if (rows >= parameters + 2) return Done{};
  return Error{
      fmt::format("expected at least {} rows for {} parameters, found {}", parameters + 2, parameters, rows)};
}

/// Least squares on logarithms.
struct Fit {
  const ForceModel& model;
  const Numbers& scale;  // of the rows [N]
  int runs = 0;
  std::string failure;  // of the latest run

  /// Scaled forces of the model at these logarithms; empty where it fails.
  Numbers at(const Numbers& logs) {
    Numbers values;
    for (const double l : logs) values.push_back(std::exp(l));
    runs++;
    Result<Numbers> force = model(values);
    if (!force) return failure = force.error().message, Numbers();
    TURGOR_ASSERT(force->size() == scale.size(), "a force a row");
    for (std::size_t i = 0; i < scale.size(); i++) (*force)[i] /= scale[i];
    return std::move(*force);
  }
  /// ∂force/∂logarithms, a column a parameter, by differences to one side. Empty where a run fails on both.
  std::vector<Numbers> sensitivities(const Numbers& logs, const Numbers& force) {
    std::vector<Numbers> slopes;
    for (std::size_t p = 0; p < logs.size(); p++) {
      Numbers moved = logs;
      double length = kStep;
      moved[p] += length;
      Numbers changed = at(moved);
      if (changed.empty()) {
        moved[p] = logs[p] + (length = -kStep);
        changed = at(moved);
      }
      if (changed.empty()) return {};
      slopes.push_back(difference(changed, force));
      for (double& slope : slopes.back()) slope /= length;
    }
    return slopes;
  }
};

std::vector<Numbers> normal_matrix(const std::vector<Numbers>& slopes) {
  std::vector<Numbers> normal(slopes.size(), Numbers(slopes.size()));
  for (std::size_t p = 0; p < slopes.size(); p++)
    for (std::size_t q = 0; q < slopes.size(); q++) normal[p][q] = product(slopes[p], slopes[q]);
  return normal;
}

/// Step of Levenberg and Marquardt, at most `kLongest` in a logarithm.
Numbers damped_step(std::vector<Numbers> normal, const std::vector<Numbers>& slopes, const Numbers& residual,
                    double damping) {
  constexpr double kLongest = 1.0;
  double most = 0;
  for (std::size_t p = 0; p < normal.size(); p++) most = std::max(most, normal[p][p]);
  for (std::size_t p = 0; p < normal.size(); p++) normal[p][p] += damping * normal[p][p] + 1e-9 * most;
  const std::vector<Numbers> inverted = inverse(std::move(normal));
  Numbers step(slopes.size());
  if (inverted.empty()) return step;
  for (std::size_t p = 0; p < step.size(); p++)
    for (std::size_t q = 0; q < step.size(); q++) step[p] += inverted[p][q] * product(slopes[q], residual);
  if (const double length = largest(step); length > kLongest)
    for (double& s : step) s *= kLongest / length;
  return step;
}

/// Confidence intervals and notes from the sensitivities at the solution.
void add_confidence(const std::vector<FitParameter>& parameters, const Numbers& logs,
                    const std::vector<Numbers>& slopes, const Numbers& residual, Identified& result) {
  constexpr double kNarrow = 0.6931, kAlike = 0.98;  // ln 2; correlation
  const double rows = double(residual.size()), freedom = rows - double(logs.size());
  const double noise = product(residual, residual) / freedom;
  const std::vector<Numbers> covariance = inverse(normal_matrix(slopes));
  for (std::size_t p = 0; p < logs.size(); p++) {
    FittedParameter fitted{.key = parameters[p].key, .value = std::exp(logs[p])};
    const double width = covariance.empty()
                             ? std::numeric_limits<double>::infinity()
                             : student_quantile(int(freedom)) * std::sqrt(noise * covariance[p][p]);
    fitted.low = fitted.value * std::exp(-width), fitted.high = fitted.value * std::exp(width);
    fitted.sensitivity = std::sqrt(product(slopes[p], slopes[p]) / rows);
    fitted.is_observable = width < kNarrow;
    if (!fitted.is_observable)
      result.notes.push_back(
          fmt::format("{}: the table hardly shows it (10 % of it change the force by {:.2g} %)", fitted.key,
                      10 * fitted.sensitivity));
    for (std::size_t q = 0; !covariance.empty() && q < p; q++)
      if (std::abs(covariance[p][q]) > kAlike * std::sqrt(covariance[p][p] * covariance[q][q]))
        result.notes.push_back(
            fmt::format("{} and {} can hardly be told apart by this table", parameters[q].key, fitted.key));
    result.parameters.push_back(fitted);
  }
}

/// Root mean square of the scaled residual in each table.
Numbers table_residuals(const std::vector<MeasuredForce>& tables, const Numbers& residual) {
  Numbers result;
  auto first = residual.begin();
  for (const MeasuredForce& table : tables) {
    const auto last = first + std::ptrdiff_t(table.at.size());
    result.push_back(std::sqrt(std::inner_product(first, last, first, 0.0) / double(table.at.size())));
    first = last;
  }
  return result;
}

/// Overrides of the scene for these values. Entries of an array are joined to one value.
std::vector<std::string> overrides_of(const std::vector<FitParameter>& parameters,
                                      const std::vector<double>& values) {
  std::vector<std::string> overrides;
  std::map<std::string, std::map<int, std::map<int, double>>> arrays;
  for (std::size_t p = 0; p < parameters.size(); p++) {
    const std::string& key = parameters[p].key;
    int i = 0, j = 0;
    const std::size_t at = key.find('[');
    if (at != std::string::npos && std::sscanf(key.c_str() + at, "[%d][%d]", &i, &j) == 2)
      arrays[key.substr(0, at)][i][j] = values[p];
    else
      overrides.push_back(fmt::format("{}={:.17g}", key, values[p]));
  }
  for (const auto& [key, rows] : arrays) {
    std::string text;
    for (const auto& [i, row] : rows) {
      std::string numbers;
      for (const auto& [j, value] : row)
        numbers += fmt::format("{}{:.17g}", numbers.empty() ? "" : ", ", value);
      text += fmt::format("{}[{}]", text.empty() ? "" : ", ", numbers);
    }
    overrides.push_back(fmt::format("{}=[{}]", key, text));
  }
  return overrides;
}

/// Forces of a tool at the rows of the table, interpolated between its ticks.
Result<std::vector<double>> forces_at(const TouchingTool& tool, const MeasuredForce& measured) {
  // curve of the tool: over time, or while it moves in
  std::vector<std::pair<double, double>> curve{{0, 0}};
  for (const ForceSample& s : tool.samples) {
    const double at = measured.by_time ? s.time : s.depth;
    if (at > curve.back().first) curve.emplace_back(at, norm(s.force));
  }
  if (measured.at.back() > curve.back().first * (1 + 1e-6))
    return Error{fmt::format("the table goes to {:.6g} {}, the tool {} of the scene only to {:.6g} {}",
                             measured.at.back(), measured.by_time ? "s" : "m", tool.name, curve.back().first,
                             measured.by_time ? "s" : "m")};
  std::vector<double> forces;
  for (const double at : measured.at) {
    const auto next = std::lower_bound(curve.begin(), curve.end(), std::pair(at, -1.0));
    if (next == curve.begin() || next == curve.end()) {
      forces.push_back(next == curve.end() ? curve.back().second : next->second);
      continue;
    }
    const auto before = next - 1;
    const double share = (at - before->first) / (next->first - before->first);
    forces.push_back(before->second + share * (next->second - before->second));
  }
  return forces;
}

/// One run of the scene without a cache: every trial has another stiffness.
Result<std::vector<double>> run_trial(const Exec& exec, const IdentifyInput& input,
                                      const std::vector<MeasuredForce>& tables,
                                      const std::vector<double>& values) {
  // world
  std::vector<std::string> overrides = input.overrides;
  for (const std::string& text : overrides_of(input.parameters, values)) overrides.push_back(text);
  Result<Scene> scene =
      input.text ? parse_scene(*input.text, input.scene, overrides) : read_scene(input.scene, overrides);
  if (!scene) return scene.error();
  for (SfemScene& body : scene->sfem_bodies) body.cached = false;
  Result<World> world = load_world(exec, *scene);
  if (!world) return world.error();
  // tools
  std::vector<const TouchingTool*> tools;
  double last_time = 0;  // that a table compares; infinite with a depth
  for (const MeasuredForce& table : tables) {
    const auto tool = std::find_if(world->tools.begin(), world->tools.end(), [&](const TouchingTool& t) {
      return table.tool.empty() || t.name == table.tool;
    });
    if (tool == world->tools.end())
      return Error{fmt::format("{}: expected a tool{}, found none", input.scene.string(),
                               table.tool.empty() ? "" : " named " + table.tool)};
    tools.push_back(&*tool);
    last_time =
        std::max(last_time, table.by_time ? table.at.back() : std::numeric_limits<double>::infinity());
  }
  // frames
  for (int frame = 0; frame < frame_count(*scene); frame++) {
    if (input.before_frame) input.before_frame();
    const auto stepped = step(exec, *world);
    if (!stepped) return stepped.error();
    if (!stepped->finite) return Error{"a trial run was not finite"};
    if (time_of(*world) > last_time + 1e-9) break;
  }
  // forces
  std::vector<double> forces;
  for (std::size_t t = 0; t < tables.size(); t++) {
    const Result<std::vector<double>> found = forces_at(*tools[t], tables[t]);
    if (!found) return found.error();
    forces.insert(forces.end(), found->begin(), found->end());
  }
  return forces;
}

}  // namespace

Result<Identified> fit_parameters(const ForceModel& model, const std::vector<MeasuredForce>& tables,
                                  const std::vector<FitParameter>& parameters, int most_iterations) {
  constexpr double kSmallStep = 1e-3, kLeastGain = 1e-6;
  constexpr int kAttempts = 6;
  // input
  if (parameters.empty()) return Error{"expected at least one parameter to fit"};
  if (const Status status = check_tables(tables, parameters.size()); !status) return status.error();
  Numbers logs;
  for (const FitParameter& parameter : parameters) {
    if (!(parameter.start > 0) || !std::isfinite(parameter.start))
      return Error{
          fmt::format("{}: expected a start value above 0, found {}", parameter.key, parameter.start)};
    logs.push_back(std::log(parameter.start));
  }
  // start
  const ScaledRows measured = scaled_rows(tables);
  Fit fit{.model = model, .scale = measured.scale};
  Numbers force = fit.at(logs);
  if (force.empty()) return Error{fit.failure};
  const double rows = double(measured.force.size());
  Numbers residual = difference(measured.force, force);
  Identified result;
  result.start_residual = std::sqrt(product(residual, residual) / rows);
  // Levenberg-Marquardt
  double damping = 1e-3;
  bool is_better = true;
  for (; result.iterations < most_iterations && !result.converged && is_better; result.iterations++) {
    const std::vector<Numbers> slopes = fit.sensitivities(logs, force);
    if (slopes.empty()) return Error{fit.failure};
    const std::vector<Numbers> normal = normal_matrix(slopes);
    const double before = product(residual, residual);
    is_better = false;
    for (int attempt = 0; attempt < kAttempts && !is_better && !result.converged; attempt++) {
      const Numbers step = damped_step(normal, slopes, residual, damping);
      Numbers moved = logs;
      for (std::size_t p = 0; p < logs.size(); p++) moved[p] += step[p];
      const Numbers found = fit.at(moved);
      const Numbers rest = found.empty() ? Numbers() : difference(measured.force, found);
      is_better = !found.empty() && product(rest, rest) <= before;
      result.converged =
          largest(step) < kSmallStep || (is_better && before - product(rest, rest) <= kLeastGain * before);
      damping = is_better ? std::max(1e-9, damping / 10) : damping * 10;
      if (is_better) logs = moved, force = found, residual = rest;
    }
  }
  // result
  const std::vector<Numbers> slopes = fit.sensitivities(logs, force);
  if (slopes.empty()) return Error{fit.failure};
  result.residual = std::sqrt(product(residual, residual) / rows);
  for (std::size_t i = 0; i < force.size(); i++) result.force.push_back(force[i] * measured.scale[i]);
  result.residuals = table_residuals(tables, residual);
  add_confidence(parameters, logs, slopes, residual, result);
  if (!result.converged)
    result.notes.emplace_back("the fit has not converged: better start values, or fewer parameters");
  result.runs = fit.runs;
  return result;
}

Result<Identified> identify(const Exec& exec, const IdentifyInput& input,
                            const std::vector<MeasuredForce>& tables) {
  const ForceModel model = [&](const std::vector<double>& values) {
    return run_trial(exec, input, tables, values);
  };
  return fit_parameters(model, tables, input.parameters, input.most_iterations);
}

}  // namespace turgor
