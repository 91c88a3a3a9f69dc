// Fit of tissue parameters to a measured force: the model of a scene is run with trial parameters, and the
// forces of tools are compared with tables, over depth or over time. Levenberg-Marquardt on the logarithms
// of the parameters, with sensitivities by differences of runs. The covariance of the least squares gives
// confidence intervals; a parameter that the data do not show is named. [Marquardt 1963; Bard 1974]
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/core/result.hpp"
#include "turgor/sim/measured_force.hpp"

namespace turgor {

/// A parameter of the scene. `key` is a scene key, of an array with indices: body.pad.viscosity.pairs[0][1].
/// All entries of an array are parameters.
struct FitParameter {
  std::string key;
  double start = 1;  // above 0
};

struct IdentifyInput {
  std::filesystem::path scene;
  std::optional<std::string> text;     // of the scene; its relative paths are those of a file named `scene`
  std::vector<std::string> overrides;  // key=value, for all runs
  std::vector<FitParameter> parameters;
  int most_iterations = 12;
  std::function<void()> before_frame;  // of every run; an exception of it ends the fit
};

/// A parameter after the fit.
struct FittedParameter {
  std::string key;
  double value = 0;
  double low = 0, high = 0;    // 95 % confidence interval; infinite where the data do not show it
  double sensitivity = 0;      // root mean square of ∂force/∂ln value over that of the force [1]
  bool is_observable = false;  // interval narrower than a factor of two to each side
};

struct Identified {
  std::vector<FittedParameter> parameters;
  std::vector<double> force;      // of the model at MeasuredForce::at, table after table [N]
  std::vector<double> residuals;  // of the tables: root mean square, relative to that of the force [1]
  double residual = 0;            // the same of all rows [1]
  double start_residual = 0;      // the same at the start values [1]
  int iterations = 0, runs = 0;
  bool converged = false;
  std::vector<std::string> notes;  // parameters that the data do not show or do not tell apart
};

/// Forces of a model at MeasuredForce::at, table after table, for parameters. Error: the model cannot be run
/// with them.
using ForceModel = std::function<Result<std::vector<double>>(const std::vector<double>&)>;

/// The fit with any model. Rows count relative to the root mean square of the force of their table. Error:
/// fewer rows than parameters and two, values that are not finite, no force, a start value that is not above
/// 0, or a model that fails at the start values.
Result<Identified> fit_parameters(const ForceModel& model, const std::vector<MeasuredForce>& tables,
                                  const std::vector<FitParameter>& parameters, int most_iterations = 12);

/// Runs the scene. Error: see fit_parameters; a key that the scene does not have; a tool that does not touch
/// as deep or as long as its table.
Result<Identified> identify(const Exec& exec, const IdentifyInput& input,
                            const std::vector<MeasuredForce>& tables);

}  // namespace turgor
