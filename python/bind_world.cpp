#include <cmath>
#include <filesystem>
#include <functional>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/function.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include "bindings.hpp"
#include "progress.hpp"
#include "turgor/core/hash.hpp"
#include "turgor/core/thread_limit.hpp"
#include "turgor/sim/report/report.hpp"

namespace turgor {

using namespace nb::literals;

namespace {

namespace fs = std::filesystem;

void init_world(PyWorld* self, const fs::path& file, const std::optional<std::string>& text,
                const std::vector<std::string>& overrides, const std::string& folder, int threads,
                bool keeps_forces, const VolumesOfPython<std::int16_t>& volumes,
                const VolumesOfPython<std::uint16_t>& labels, nb::object progress) {
  required(check_threads(threads));
  Scene scene = given_scene(file, text, overrides, folder);
  const GivenVolumes given = given_volumes(volumes, labels);
  required(set_volumes(given, scene));
  PyProgress reporter(std::move(progress));
  {
    const nb::gil_scoped_release others;
    new (self) PyWorld(std::move(scene), given.left_handed, threads, keeps_forces, reporter.begin());
  }
  try {
    reporter.rethrow();
  } catch (...) {
    self->~PyWorld();
    throw;
  }
}

nb::dict forces(const PyWorld& world, const std::string& name) {
  const TouchLog& log = world.tool(name).samples;
  std::vector<double> time, position, force, torque, depth;
  std::vector<int> contacts;
  for (const ForceSample& s : log) {
    time.push_back(s.time), depth.push_back(s.depth), contacts.push_back(s.contacts);
    for (int axis = 0; axis < 3; axis++)
      position.push_back(s.position[axis]), force.push_back(s.force[axis]), torque.push_back(s.torque[axis]);
  }
  nb::dict columns;
  columns["time_s"] = new_array(std::move(time), 0);
  columns["position_m"] = new_array(std::move(position), 3);
  columns["force_N"] = new_array(std::move(force), 3);
  columns["torque_Nm"] = new_array(std::move(torque), 3);
  columns["depth_m"] = new_array(std::move(depth), 0);
  columns["contacts"] = new_array(std::move(contacts), 0);
  return columns;
}

template <class Row>
using Columns = std::vector<std::pair<const char*, double Row::*>>;
template <class Row>
nb::dict columns_of(const std::vector<Row>& rows, const Columns<Row>& wanted) {
  nb::dict columns;
  for (const auto& [name, member] : wanted) {
    std::vector<double> numbers;
    for (const Row& row : rows) numbers.push_back(row.*member);
    columns[name] = new_array(std::move(numbers), 0);
  }
  return columns;
}

/// Force of an attachment or of a contact between bodies, one row per frame.
nb::dict coupling_columns(const std::vector<CouplingSample>& samples) {
  nb::dict columns = columns_of<CouplingSample>(
      samples, {{"time_s", &CouplingSample::time}, {"largest_force_N", &CouplingSample::most}});
  std::vector<double> force;
  std::vector<int> bearing, sliding;
  for (const CouplingSample& s : samples) {
    for (int axis = 0; axis < 3; axis++) force.push_back(s.force[axis]);
    bearing.push_back(s.bearing), sliding.push_back(s.sliding);
  }
  columns["force_N"] = new_array(std::move(force), 3);
  columns["bearing"] = new_array(std::move(bearing), 0);
  columns["sliding"] = new_array(std::move(sliding), 0);
  return columns;
}

/// Motion of a rigid body, one row per frame.
nb::dict rigid_columns(const std::vector<RigidSample>& samples) {
  nb::dict columns = columns_of<RigidSample>(samples, {{"time_s", &RigidSample::time}});
  std::vector<double> center, rotation, velocity, spin;
  for (const RigidSample& s : samples) {
    rotation.insert(rotation.end(), s.rotation.begin(), s.rotation.end());
    for (int axis = 0; axis < 3; axis++)
      center.push_back(s.center[axis]), velocity.push_back(s.velocity[axis]), spin.push_back(s.spin[axis]);
  }
  columns["center_m"] = new_array(std::move(center), 3);
  columns["rotation"] = new_array(std::move(rotation), 4);
  columns["velocity_m_per_s"] = new_array(std::move(velocity), 3);
  columns["spin_rad_per_s"] = new_array(std::move(spin), 3);
  return columns;
}

/// Columns by name. A name that an earlier kind has taken gets its kind before it, as suture.NAME.
class MeasuresByName {
 public:
  void add(const char* kind, const std::string& name, nb::dict columns) {
    const std::string key = all_.contains(name.c_str()) ? fmt::format("{}.{}", kind, name) : name;
    all_[key.c_str()] = std::move(columns);
  }
  nb::dict take() { return std::move(all_); }

 private:
  nb::dict all_;
};

/// Measurements of every wound, suture, cloth, rigid body, attachment and contact between bodies, one row per
/// frame.
nb::dict measures(const PyWorld& world) {
  MeasuresByName of;
  for (const CutMeasures& cut : world.measures().cuts)
    of.add("wound", cut.name,
           columns_of<WoundSample>(cut.series, {{"time_s", &WoundSample::time},
                                                {"gape_max_m", &WoundSample::gape_max},
                                                {"gape_mean_m", &WoundSample::gape_mean},
                                                {"opening_area_m2", &WoundSample::opening_area},
                                                {"edge_displacement_m", &WoundSample::edge_displacement}}));
  for (const SutureMeasures& suture : world.measures().sutures)
    of.add("suture", suture.name,
           columns_of<SutureSample>(suture.series, {{"time_s", &SutureSample::time},
                                                    {"closing_force_N", &SutureSample::closing_force},
                                                    {"tension_max_N", &SutureSample::tension_max},
                                                    {"gape_max_m", &SutureSample::gape_max}}));
  for (const ClothBody& body : world.world().cloth_bodies)
    of.add("body", body.name,
           columns_of<ClothSample>(body.samples, {{"time_s", &ClothSample::time},
                                                  {"largest_speed_m_per_s", &ClothSample::largest_speed}}));
  for (const RigidBody& body : world.world().rigid_bodies)
    of.add("body", body.name, rigid_columns(body.samples));
  const Coupling& coupling = world.world().coupling;
  for (const Attachment& a : coupling.attachments) of.add("attachment", a.name, coupling_columns(a.samples));
  for (const BodyContact& c : coupling.contacts) of.add("contact", c.name, coupling_columns(c.samples));
  return of.take();
}

std::string report(const PyWorld& world) {
  world.expect_untouched("report()");
  RunFacts facts;
  facts.warnings = notes_of(world.world());
  return json_text(simulation_report(world.exec(), world.scene(), world.world(), world.measures(), facts),
                   -1);
}

template <class Names>
std::vector<std::string> names_of(const Names& named) {
  std::vector<std::string> names;
  for (const auto& one : named) names.push_back(one.name);
  return names;
}
std::vector<std::string> bodies(const PyWorld& world) {
  std::vector<std::string> names;
  for_each_body(world.world(), [&](BodyId, const auto& body) { names.push_back(body.name); });
  return names;
}

std::string text_of(const PyWorld& world) {
  const std::vector<std::string> tools = names_of(world.world().tools);
  return fmt::format("<turgor.World {}: {:.4g} of {:.4g} s, bodies {}{}>", world.scene().file.string(),
                     time_of(world.world()), world.scene().duration, fmt::join(bodies(world), ", "),
                     tools.empty() ? "" : fmt::format(", tools {}", fmt::join(tools, ", ")));
}

void drive(PyWorld& world, const std::string& tool,
           nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu> rows) {
  std::vector<std::vector<double>> path;
  for (std::size_t r = 0; r < rows.shape(0); r++) {
    const double* begin = rows.data() + r * rows.shape(1);
    path.emplace_back(begin, begin + rows.shape(1));
  }
  world.drive(tool, path);
}

void check_poses(std::size_t ticks, std::size_t tools, std::size_t expected, const std::optional<Holds>& hold,
                 std::size_t rows) {
  const auto refuse = [](const std::string& what) { throw Refused("tick: " + what); };
  if (tools != expected)
    refuse("expected poses of " + std::to_string(expected) + " tools, found those of " +
           std::to_string(tools));
  if (hold && (hold->shape(0) != rows * ticks || hold->shape(1) != tools))
    refuse("expected hold for every tick and tool, found another shape");
}

Array<double> tick(PyWorld& world, const Poses& poses, const std::optional<Holds>& hold) {
  const PyWorld::Entered entered(world);
  const std::size_t ticks = poses.shape(0), tools = poses.shape(1);
  check_poses(ticks, tools, world.scene().tools.size(), hold, 1);
  std::vector<double> forces(ticks * tools * 6);
  {
    const nb::gil_scoped_release others;
    world.tick(ticks, poses.data(), hold ? hold->data() : nullptr, forces.data());
  }
  return shaped_array(std::move(forces), {ticks, tools, 6});
}

/// Poses of all worlds, concatenated: worlds · ticks rows.
Array<double> tick_all(const std::vector<PyWorld*>& worlds, const Poses& poses,
                       const std::optional<Holds>& hold, int threads) {
  if (worlds.empty() || poses.shape(0) % worlds.size() != 0)
    throw Refused("tick_all: expected as many ticks for every world, found " +
                  std::to_string(poses.shape(0)) + " poses for " + std::to_string(worlds.size()) + " worlds");
  const std::size_t ticks = poses.shape(0) / worlds.size(), tools = poses.shape(1);
  std::vector<std::unique_ptr<PyWorld::Entered>> entered;
  for (PyWorld* world : worlds) {
    check_poses(ticks, tools, world->scene().tools.size(), hold, worlds.size());
    entered.push_back(std::make_unique<PyWorld::Entered>(*world));
  }
  std::vector<double> forces(worlds.size() * ticks * tools * 6);
  {
    const nb::gil_scoped_release others;
    tick_worlds(worlds, ticks, tools, poses.data(), hold ? hold->data() : nullptr, forces.data(), threads);
  }
  return shaped_array(std::move(forces), {worlds.size(), ticks, tools, 6});
}

/// Holds the interpreter lock, since a tick is shorter than a change of threads.
std::pair<Array<double>, Array<double>> touch_tick(PyWorld& world, const Poses& poses,
                                                   const std::optional<Holds>& hold) {
  const std::size_t tools = poses.shape(1);
  if (poses.shape(0) != 1) throw Refused("touch_tick: expected one tick");
  check_poses(1, tools, world.scene().tools.size(), hold, 1);
  std::vector<double> forces(tools * 6), used(tools * 7);
  world.touch_tick(poses.data(), hold ? hold->data() : nullptr, forces.data(), used.data());
  return {new_array(std::move(forces), 6), new_array(std::move(used), 7)};
}

void step_frames(PyWorld& world, int frames) {
  const PyWorld::Entered entered(world);
  const nb::gil_scoped_release others;
  world.step(frames);
}

Array<double> tool_poses(const PyWorld& world) {
  std::vector<double> poses;
  for (std::size_t t = 0; t < world.world().tools.size(); t++) {
    const PathRow row = path_of({{0, {.pose = world.path_command(t).pose}}}).rows[0];
    poses.insert(poses.end(), {row.position.x, row.position.y, row.position.z});
    poses.insert(poses.end(), row.orientation.begin(), row.orientation.end());
  }
  return new_array(std::move(poses), 7);
}

void bind_ticks(nb::class_<PyWorld>& world, nb::module_& module) {
  world.def("_tick", &tick, "poses"_a, "hold"_a.none())
      .def("begin_touch", &PyWorld::begin_touch,
           "Starts ticks on a thread of their own: one thread calls touch_tick(), another one step(). "
           "Once for a world, before its first tick.")
      .def("_touch_tick", &touch_tick, "poses"_a, "hold"_a.none())
      .def("end_touch", &PyWorld::end_touch,
           "Ends them; no call of touch_tick() may be in progress. Afterwards the world neither steps nor "
           "ticks, until set_state() returns it to a state from before begin_touch().")
      .def_prop_ro(
          "is_ticked", [](const PyWorld& w) { return w.world(), w.is_driven(); },
          "true after the first tick() or begin_touch(); drive() is refused then, and step() but between "
          "begin_touch() and end_touch()")
      .def_prop_ro("tool_poses", &tool_poses, nb::rv_policy::automatic,
                   "(tools, 7) present poses from the tools' paths: x, y, z [m] and a quaternion w, x, y, z");
  module.def("tick_all", &tick_all, "worlds"_a, "poses"_a, "hold"_a.none(), "threads"_a);
}

}  // namespace

void bind_world(nb::module_& module) {
  nb::class_<PyState>(module, "State", "State of a world at one moment, for World.set_state.");
  nb::class_<PyWorld> world(module, "World", "A scene during simulation.");
  world
      .def("__init__", &init_world, "scene"_a, "text"_a.none(), "overrides"_a, "folder"_a, "threads"_a,
           "keeps_forces"_a, "volumes"_a, "labels"_a, "progress"_a.none())
      .def(
          "__init__", [](PyWorld* self, PyWorld& other, int threads) { new (self) PyWorld(other, threads); },
          "other"_a, "threads"_a)
      .def("step", &step_frames, "frames"_a = 1, "Simulates this number of frames.")
      .def_prop_ro(
          "time", [](const PyWorld& w) { return time_of(w.world()); }, "simulated time [s]")
      .def_prop_ro(
          "frame", [](const PyWorld& w) { return w.world().frame; }, "finished frames")
      .def_prop_ro(
          "dt", [](const PyWorld& w) { return w.world().dt; }, "duration of a frame [s]")
      .def_prop_ro(
          "duration", [](const PyWorld& w) { return w.scene().duration; }, "duration of the scene [s]")
      .def_prop_ro("_frame_rate", [](const PyWorld& w) { return w.scene().frame_rate; })
      .def_prop_ro("_frame_count", [](const PyWorld& w) { return frame_count(w.scene()); })
      .def_prop_ro(
          "state_hash",
          [](const PyWorld& w) {
            w.expect_untouched("state_hash");
            return hash_text(state_hash(w.world()));
          },
          "hash of all bodies and forces; equal hashes mean equal bits")
      .def_prop_ro("bodies", &bodies, "names of the bodies")
      .def_prop_ro(
          "tools", [](const PyWorld& w) { return names_of(w.world().tools); }, "names of the tools")
      .def_prop_ro(
          "notes", [](const PyWorld& w) { return notes_of(w.world()); },
          "notes of loading: old names in the scene, guesses, limits")
      .def("__repr__", &text_of)
      .def("get_state", &PyWorld::state, "Copies the state, for set_state.")
      .def("set_state", &PyWorld::set_state, "state"_a, "Restores a state of this world or of a copy of it.")
      .def("save", &PyWorld::save, "path"_a,
           "Writes the state to a file, with cuts and stitches by the caller and with measures. On an error "
           "an "
           "earlier file is kept.")
      .def("load", &PyWorld::load, "path"_a,
           "Continues from a file of save(), with the bits of the world that was saved. Raises Error for a "
           "file "
           "of another program or scene, or a damaged one; the world is unchanged then.")
      .def("_forces", &forces, "tool"_a)
      .def("_measures", &measures)
      .def("_report", &report)
      .def("drive", &drive, "tool"_a, "rows"_a,
           "Moves a tool from its present position along rows of [t, x, y, z], linearly interpolated, with t "
           "[s] "
           "from now on. A fifth column grasps (1) or not (0), four more are the orientation (a quaternion "
           "w, x, "
           "y, z).");
  bind_ticks(world, module);
  bind_by_hand(world);
}

}  // namespace turgor
