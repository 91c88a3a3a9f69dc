// Python module. Positions are in meters, in the patient frame.
#include <nanobind/stl/string.h>

#include "bindings.hpp"
#include "turgor/sim/report/report.hpp"

NB_MODULE(_turgor, module) {
  nanobind::exception<turgor::Refused>(module, "Error", PyExc_ValueError);
  module.attr("__version__") = turgor::program_version();
  module.attr("instructions") = turgor::program_instructions();
  turgor::bind_body(module);
  turgor::bind_live(module);
  turgor::bind_world(module);
  turgor::bind_run(module);
}
