// Fit of tissue parameters to a measured force.
#include <filesystem>

#include <fmt/format.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
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
  result["residual"] = found.residual, result["start_residual"] = found.start_residual;
  result["iterations"] = found.iterations, result["runs"] = found.runs;
  result["converged"] = found.converged, result["notes"] = nb::cast(found.notes);
  return result;
}

/// Fits `start` values of keys to a force at depths [m], or at times [s]. Ctrl+C ends the fit.
nb::dict fit(const std::filesystem::path& file, const std::optional<std::string>& text,
             const std::vector<std::string>& overrides, bool by_time, const std::vector<double>& at,
             const std::vector<double>& force, const std::vector<std::pair<std::string, double>>& start,
             const std::string& tool, int threads) {
  required(check_threads(threads));
  if (at.size() != force.size())
    throw Refused(fmt::format("expected a force for each of {} rows, found {}", at.size(), force.size()));
  IdentifyInput input{.scene = file, .text = text, .overrides = overrides, .tool = tool};
  for (const auto& [key, value] : start) input.parameters.push_back({key, value});
  input.before_frame = [] {
    const nb::gil_scoped_acquire python;
    if (PyErr_CheckSignals() != 0) throw nb::python_error();
  };
  Identified found;
  {
    const nb::gil_scoped_release others;
    found = required(identify(Exec(threads), input, {by_time, at, force}));
  }
  return to_dict(found);
}

}  // namespace

void bind_identify(nb::module_& module) {
  module.def("identify", &fit, "scene"_a, "text"_a.none(), "overrides"_a, "by_time"_a, "at"_a, "force"_a,
             "start"_a, "tool"_a, "threads"_a);
}

}  // namespace turgor
