// What the program does, into a folder.
#include <filesystem>

#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "bindings.hpp"
#include "progress.hpp"
#include "turgor/pictures/run_scene.hpp"

namespace turgor {

using namespace nb::literals;

namespace {

namespace fs = std::filesystem;

/// Ctrl+C, and what `on_frame` throws, end the run and leave no folder; false ends it and leaves what there
/// is.
bool go_on_after(const nb::object& on_frame, const PyProgress& told, const World& world) {
  const nb::gil_scoped_acquire python;
  if (PyErr_CheckSignals() != 0) throw nb::python_error();
  if (told.failed()) throw Refused("progress failed");
  if (on_frame.is_none()) return true;
  const nb::object answer = on_frame(time_of(world));
  return answer.is_none() || nb::cast<bool>(answer);
}

/// Reports are plain text to Python, whose json reads them.
std::string run_to_json(const fs::path& file, const std::optional<std::string>& text,
                        const std::vector<std::string>& overrides, const fs::path& out, bool force,
                        int threads, nb::object on_frame, nb::object progress) {
  const Scene scene = required(text ? parse_scene(*text, file, overrides) : read_scene(file, overrides));
  PyProgress told(std::move(progress));
  const RunOptions options{.out = out, .foreign = force ? Foreign::kRemove : Foreign::kRefuse, .live = {}};
  std::string json;
  try {
    const nb::gil_scoped_release others;
    RunCallbacks callbacks;
    callbacks.begin = told.begin();
    callbacks.frame = [&](const World& world) { return go_on_after(on_frame, told, world); };
    json = json_text(required(run_scene(Exec(threads), scene, options, callbacks)), -1);
  } catch (...) {
    told.rethrow();
    throw;
  }
  told.rethrow();
  return json;
}

}  // namespace

void bind_run(nb::module_& module) {
  module.def("run_to_json", &run_to_json, "scene"_a, "text"_a.none(), "overrides"_a, "out"_a, "force"_a,
             "threads"_a, "on_frame"_a.none(), "progress"_a.none());
}

}  // namespace turgor
