// Replaces bind_run.cpp and bind_recording.cpp in the slim module: a run into a folder draws pictures, which
// needs OpenGL, and recordings need HDF5.
#include <nanobind/stl/string.h>

#include "bindings.hpp"

namespace turgor {

void bind_run(nb::module_& module) {
  module.def("set_drawing_program", [](const nb::args&) {});
  module.def("run_to_json", [](const nb::args&) -> std::string {
    throw Refused(
        "run: this build of turgor draws no pictures and writes no folders; expected a build by `pip install "
        ".`. "
        "World simulates, and World.report() returns the content of report.json");
  });
}

void bind_recording(nb::module_& module) {
  module.def("open_recording", [](const nb::args&) -> nb::object {
    throw Refused("a recording: this build of turgor has no HDF5; expected a build by `pip install .`");
  });
}

}  // namespace turgor
