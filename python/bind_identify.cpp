// Fit of tissue parameters to a measured force.
#include <filesystem>

#include <fmt/format.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include "bindings.hpp"
#include "turgor/core/thread_limit.hpp"
#include "turgor/sim/identify.hpp"

namespace turgor {

using namespace nb::literals;

namespace {

nb::dict to_dict(const FittedParameter& parameter) {
  nb::dict of;
  of["value"] = parameter.value, of["low"] = parameter.low, of["high"] = parameter.high;
  of["sensitivity"] = parameter.sensitivity, of["observable"] = parameter.is_observable;
  return of;
}

nb::dict to_dict(const Identified& found) {
  nb::dict parameters, result;
  for (const FittedParameter& parameter : found.parameters)
    parameters[parameter.key.c_str()] = to_dict(parameter);
  result["parameters"] = parameters, result["force_N"] = new_array(std::vector<double>(found.force), 0);
  result["residuals"] = nb::cast(found.residuals);
  result["residual"] = found.residual, result["start_residual"] = found.start_residual;
  result["iterations"] = found.iterations, result["runs"] = found.runs;
  result["converged"] = found.converged, result["notes"] = nb::cast(found.notes);
  return result;
}

/// Rows of a tool: its name, depths [m] or times [s], and forces [N].
using Rows = std::tuple<std::string, std::vector<double>, std::vector<double>>;

/// Fits `start` values of keys to forces at depths, or at times. Ctrl+C ends the fit.
nb::dict fit(const std::filesystem::path& file, const std::optional<std::string>& text,
             const std::vector<std::string>& overrides, bool by_time, const std::vector<Rows>& rows,
             const std::vector<std::pair<std::string, double>>& start, int threads) {
  required(check_threads(threads));
  std::vector<MeasuredForce> tables;
  for (const auto& [tool, at, force] : rows) {
    if (at.size() != force.size())
      throw Refused(fmt::format("expected a force for each of {} rows, found {}", at.size(), force.size()));
    tables.push_back({by_time, at, force, tool});
  }
  IdentifyInput input{.scene = file, .text = text, .overrides = overrides};
  for (const auto& [key, value] : start) input.parameters.push_back({key, value});
  input.before_frame = [] {
    const nb::gil_scoped_acquire python;
    if (PyErr_CheckSignals() != 0) throw nb::python_error();
  };
  Identified found;
  {
    const nb::gil_scoped_release others;
    found = required(identify(Exec(threads), input, tables));
  }
  return to_dict(found);
}

}  // namespace

void bind_identify(nb::module_& module) {
  module.def("identify", &fit, "scene"_a, "text"_a.none(), "overrides"_a, "by_time"_a, "rows"_a, "start"_a,
             "threads"_a);
}

}  // namespace turgor
