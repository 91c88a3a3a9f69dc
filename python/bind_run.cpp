// Whole run into a folder, as the program does it.
#include <filesystem>

#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "bindings.hpp"
#include "progress.hpp"
#include "turgor/core/thread_limit.hpp"
#include "turgor/pictures/run_scene.hpp"
#include "turgor/view/drawing_process.hpp"

namespace turgor {

using namespace nb::literals;

namespace {

namespace fs = std::filesystem;

/// Calls `on_frame` and returns whether to continue. False ends the run and keeps its results; other answers
/// continue. Ctrl+C and exceptions of `on_frame` cancel the run and leave no folder.
bool continue_after(const nb::object& on_frame, const PyProgress& reporter, const World& world) {
  const nb::gil_scoped_acquire python;
  if (PyErr_CheckSignals() != 0) throw nb::python_error();
  if (reporter.failed()) throw Refused("progress failed");
  if (on_frame.is_none()) return true;
  return !on_frame(time_of(world)).is(nb::handle(Py_False));
}

/// Report as JSON text.
std::string run_to_json(const fs::path& file, const std::optional<std::string>& text,
                        const std::vector<std::string>& overrides, const std::string& folder,
                        const fs::path& out, bool force, int threads, nb::object on_frame,
                        nb::object progress) {
  required(check_threads(threads));
  const Scene scene = given_scene(file, text, overrides, folder);
  PyProgress reporter(std::move(progress));
  const RunOptions options{.out = out, .foreign = force ? Foreign::kRemove : Foreign::kRefuse, .live = {}};
  std::string json;
  try {
    const nb::gil_scoped_release others;
    RunCallbacks callbacks;
    callbacks.begin = reporter.begin();
    callbacks.frame = [&](const World& world) { return continue_after(on_frame, reporter, world); };
    json = json_text(required(run_scene(Exec(threads), scene, options, callbacks)), -1);
  } catch (...) {
    reporter.rethrow();
    throw;
  }
  reporter.rethrow();
  return json;
}

/// Runs draw by this command, or draw nothing for the reason `refusal`.
void draw_by(std::vector<std::string> command, std::string refusal) {
  set_drawing_program({.arguments = std::move(command), .refusal = std::move(refusal)});
}

}  // namespace

void bind_run(nb::module_& module) {
  module.def("serve_drawings", &serve_drawings);
  module.def("set_drawing_program", &draw_by, "command"_a, "refusal"_a);
  module.def("run_to_json", &run_to_json, "scene"_a, "text"_a.none(), "overrides"_a, "folder"_a, "out"_a,
             "force"_a, "threads"_a, "on_frame"_a.none(), "progress"_a.none());
}

}  // namespace turgor
