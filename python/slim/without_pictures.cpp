// In place of bind_run.cpp in the slim module: a run into a folder is drawn, which needs OpenGL.
#include <nanobind/stl/string.h>

#include "bindings.hpp"

namespace turgor {

void bind_run(nb::module_& module) {
  module.def("run_to_json", [](const nb::args&) -> std::string {
    throw Refused(
        "run: this build of turgor draws no pictures and writes no folders; expected the one that `pip "
        "install .` makes. "
        "World simulates, and report() says what report.json would");
  });
}

}  // namespace turgor
