// Python module. Positions are in meters, in the patient frame.
#include <nanobind/stl/string.h>

#include "bindings.hpp"
#include "turgor/core/plain_text.hpp"
#include "turgor/sim/report/report.hpp"

NB_MODULE(_turgor, module) {
  nanobind::exception<turgor::Refused>(module, "Error", PyExc_ValueError);
  module.attr("__version__") = turgor::program_version();
  module.attr("instructions") = turgor::program_instructions();
  module.def("plain_text", [](const std::string& text) { return turgor::plain_text(text); });
  turgor::bind_body(module);
  turgor::bind_live(module);
  turgor::bind_world(module);
  turgor::bind_identify(module);
  turgor::bind_run(module);
  turgor::bind_recording(module);
}
