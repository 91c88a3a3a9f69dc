// Replaces bind_run.cpp in the slim module: a run into a folder draws pictures, which needs OpenGL.
#include <nanobind/stl/string.h>

#include "bindings.hpp"

namespace turgor {

void bind_run(nb::module_& module) {
  module.def("run_to_json", [](const nb::args&) -> std::string {
    throw Refused(
        "run: this build of turgor draws no pictures and writes no folders; expected a build by `pip install "
        ".`. "
        "World simulates, and World.report() returns the content of report.json");
  });
}

}  // namespace turgor
