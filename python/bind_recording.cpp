// Recordings of runs: surfaces at every snapshot, and their files for other programs.
#include <filesystem>
#include <memory>
#include <mutex>

#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/unique_ptr.h>
#include <nanobind/stl/vector.h>

#include "bindings.hpp"
#include "turgor/core/thread_limit.hpp"
#include "turgor/io/files/file.hpp"
#include "turgor/pictures/animated_surfaces.hpp"
#include "turgor/pictures/picture_items.hpp"
#include "turgor/sim/recording/recording.hpp"

namespace turgor {

using namespace nb::literals;

namespace {

namespace fs = std::filesystem;

/// A recording, with the world that its snapshots are restored into. Its functions are called without the
/// interpreter lock; threads that read the same recording wait for each other.
class PyRecording {
 public:
  PyRecording(const fs::path& file, const std::vector<std::string>& overrides, int threads)
      : exec_(threads), recording_(required(Recording::open(file))) {
    scene_ = required(recording_.scene(overrides));
    world_ = std::make_unique<World>(required(load_world(exec_, scene_, {}, Purpose::kDraw)));
    required(recording_.check_world(*world_));
  }

  int count() const { return recording_.snapshot_count(); }
  const std::string& report() const { return recording_.report(); }
  double frame_rate() const { return scene_.frame_rate; }

  WorldSnapshot snapshot(int index) {
    const std::lock_guard alone(reading_);
    return restored(index);
  }

  SurfaceAnimation animation() {
    const std::lock_guard alone(reading_);
    SurfaceAnimation animation{.frame_rate = scene_.frame_rate, .times = {}, .surfaces = {}};
    for (int s = 0; s < count(); s++) add_surfaces(restored(s), animation);
    remove_empty_surfaces(animation);
    return animation;
  }

 private:
  const WorldSnapshot& restored(int index) {
    if (index < 0 || index >= count()) throw nb::index_error("the recording has no such snapshot");
    required(recording_.restore(exec_, index, *world_, snapshot_));
    snapshot_.time = time_of(*world_), snapshot_.frame = world_->frame;
    return snapshot_;
  }

  std::mutex reading_;
  Exec exec_;
  Recording recording_;
  Scene scene_;
  std::unique_ptr<World> world_;
  WorldSnapshot snapshot_;
};

nb::dict surface_dict(const BodySnapshot& body) {
  nb::dict columns;
  columns["model"] = model_name(body.id.kind);
  columns["rest_points"] = rows_of(body.rest);
  columns["points"] = rows_of(body.x);
  columns["displacement"] = rows_of(body.displacement);
  columns["normals"] = rows_of(body.normals);
  columns["pressure"] = new_array(std::vector<float>(body.pressure), 0);
  columns["triangles"] = rows_of(body.triangles);
  columns["wall_begin"] = body.wall_begin;
  return columns;
}

nb::dict tool_dict(const ToolSnapshot& tool) {
  const TriMesh mesh = posed_mesh(tool);
  nb::dict columns;
  columns["points"] = rows_of(mesh.vertices);
  columns["triangles"] = rows_of(mesh.triangles);
  columns["position"] =
      new_array<double>({tool.pose.position.x, tool.pose.position.y, tool.pose.position.z}, 0);
  columns["force"] = new_array<double>({tool.force.x, tool.force.y, tool.force.z}, 0);
  return columns;
}

/// Time, frame, and the arrays of every body and tool.
nb::dict snapshot_dict(PyRecording& recording, int index) {
  const WorldSnapshot snapshot = [&] {
    const nb::gil_scoped_release others;
    return recording.snapshot(index);
  }();
  nb::dict bodies, tools, out;
  for (const BodySnapshot& body : snapshot.bodies) bodies[body.name.c_str()] = surface_dict(body);
  for (const ToolSnapshot& tool : snapshot.tools) tools[tool.name.c_str()] = tool_dict(tool);
  out["time"] = snapshot.time, out["frame"] = snapshot.frame;
  out["bodies"] = bodies, out["tools"] = tools;
  return out;
}

template <class Write>
void write_surfaces(PyRecording& recording, const fs::path& file, Write write) {
  const nb::gil_scoped_release others;
  required(check_file_goal(file));
  required(write(file, recording.animation()));
}

}  // namespace

void bind_recording(nb::module_& module) {
  nb::class_<PyRecording>(module, "RecordingFile", "recording.h5 of a run.")
      .def_prop_ro("count", &PyRecording::count)
      .def_prop_ro("frame_rate", &PyRecording::frame_rate)
      .def_prop_ro("report", &PyRecording::report)
      .def("snapshot", &snapshot_dict, "index"_a)
      .def("write_usda", [](PyRecording& r, const fs::path& file) { write_surfaces(r, file, &write_usda); })
      .def("write_glb", [](PyRecording& r, const fs::path& file) {
        write_surfaces(r, file, [](const fs::path& to, const SurfaceAnimation& animation) {
          return write_glb(to, animation);
        });
      });
  module.def(
      "open_recording",
      [](const fs::path& file, const std::vector<std::string>& overrides, int threads) {
        required(check_threads(threads));
        const nb::gil_scoped_release others;
        return std::make_unique<PyRecording>(file, overrides, threads);
      },
      "file"_a, "overrides"_a, "threads"_a);
}

}  // namespace turgor
