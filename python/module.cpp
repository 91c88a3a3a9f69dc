// The Python module. Arrays are copies, which nothing changes behind one's back; places in metres, in the
// patient frame. While the engine works, other Python threads run; a world that works is not entered a second
// time.
#include <atomic>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/function.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "turgor/core/hash.hpp"
#include "turgor/pictures/run_scene.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace turgor {
namespace {

namespace fs = std::filesystem;

/// Becomes turgor.Error with the sentence.
struct Refused : std::runtime_error {
  using std::runtime_error::runtime_error;
};

template <class T>
T required(Result<T> result) {
  if (!result) throw Refused(result.error().message);
  return std::move(*result);
}

template <class T>
using Array = nb::ndarray<nb::numpy, T>;

/// A new array of rows × columns that owns its numbers; columns 0 = one dimension.
template <class T>
Array<T> new_array(std::vector<T> numbers, std::size_t columns) {
  auto* kept = new std::vector<T>(std::move(numbers));
  nb::capsule owner(kept, [](void* p) noexcept { delete static_cast<std::vector<T>*>(p); });
  if (columns == 0) return Array<T>(kept->data(), {kept->size()}, owner);
  return Array<T>(kept->data(), {kept->size() / columns, columns}, owner);
}

Array<float> places(const std::vector<Vec3>& points) {
  std::vector<float> numbers;
  numbers.reserve(3 * points.size());
  for (const Vec3 p : points) numbers.insert(numbers.end(), {p.x, p.y, p.z});
  return new_array(std::move(numbers), 3);
}

/// A scene that is being simulated.
class PyWorld {
 public:
  PyWorld(Scene scene, int threads) : exec_(threads), scene_(std::move(scene)) {
    const nb::gil_scoped_release others;
    world_ = std::make_unique<World>(required(load_world(exec_, scene_)));
    show(exec_, *world_, shown_);
  }

  void step(int frames) {
    const Entered entered(*this);
    const nb::gil_scoped_release others;
    for (int f = 0; f < frames; f++)
      if (!required(turgor::step(exec_, *world_)).finite)
        throw Refused("the numbers of a step were not finite; the state before it was kept");
    show(exec_, *world_, shown_);
  }

  double time() const { return time_of(world()); }
  int frame() const { return world().frame; }
  double dt() const { return world_->dt; }
  double duration() const { return scene_.duration; }
  std::string hash() const { return hash_text(state_hash(world())); }
  std::vector<std::string> notes() const { return notes_of(world()); }

  std::vector<std::string> bodies() const {
    std::vector<std::string> names;
    for (const ShownBody& body : shown().bodies) names.push_back(body.name);
    return names;
  }
  std::vector<std::string> tools() const {
    std::vector<std::string> names;
    for (const TouchingTool& tool : world().tools) names.push_back(tool.name);
    return names;
  }

  const ShownBody& body(const std::string& name) const {
    for (const ShownBody& body : shown().bodies)
      if (body.name == name) return body;
    throw nb::key_error(("the scene has no body " + name).c_str());
  }
  TouchingTool& tool(const std::string& name) const {
    for (TouchingTool& tool : world().tools)
      if (tool.name == name) return tool;
    throw nb::key_error(("the scene has no tool " + name).c_str());
  }

  nb::dict forces(const std::string& name) const {
    const TouchLog& log = tool(name).samples;
    std::vector<double> time, position, force, torque, depth;
    std::vector<int> contacts;
    for (const ForceSample& s : log) {
      time.push_back(s.time), depth.push_back(s.depth), contacts.push_back(s.contacts);
      for (int axis = 0; axis < 3; axis++)
        position.push_back(s.position[axis]), force.push_back(s.force[axis]),
            torque.push_back(s.torque[axis]);
    }
    nb::dict columns;
    columns["time_s"] = new_array(std::move(time), 0),
    columns["position_m"] = new_array(std::move(position), 3);
    columns["force_N"] = new_array(std::move(force), 3),
    columns["torque_Nm"] = new_array(std::move(torque), 3);
    columns["depth_m"] = new_array(std::move(depth), 0),
    columns["contacts"] = new_array(std::move(contacts), 0);
    return columns;
  }

  /// From where it is now in straight lines along rows of [t, x, y, z(, hold(, w, x, y, z))], t from now on.
  void drive(const std::string& name, nb::ndarray<double, nb::ndim<2>, nb::c_contig, nb::device::cpu> rows) {
    TouchingTool& driven = tool(name);
    std::vector<std::vector<double>> wanted;
    for (std::size_t r = 0; r < rows.shape(0); r++) {
      const double* begin = rows.data() + r * rows.shape(1);
      wanted.emplace_back(begin, begin + rows.shape(1));
    }
    std::vector<PathRow> path = required(path_rows(wanted));
    if (path.empty()) throw Refused(name + ": expected at least one row to drive it along, found none");
    if (path.front().time < 0) throw Refused(name + ": expected times from now on, found one before");
    const double now = time();
    PathRow here = path_at(driven.path, now);
    for (PathRow& row : path) row.time += now;
    if (path.front().time > now) path.insert(path.begin(), here);
    driven.path = {std::move(path), false};
    driven.hand.clear();
  }

 private:
  static std::runtime_error entered_twice() {
    return std::runtime_error("this world is being stepped by another thread");
  }
  /// One caller at a time.
  struct Entered {
    PyWorld& world;
    explicit Entered(PyWorld& w) : world(w) {
      if (world.busy_.exchange(true)) throw entered_twice();
    }
    ~Entered() { world.busy_ = false; }
  };
  /// For those who look without letting other Python threads run: none of them can begin a step meanwhile.
  World& world() const {
    if (busy_) throw entered_twice();
    return *world_;
  }
  const ShownWorld& shown() const {
    if (busy_) throw entered_twice();
    return shown_;
  }

  Exec exec_;
  Scene scene_;
  std::unique_ptr<World> world_;
  ShownWorld shown_;
  std::atomic<bool> busy_{false};
};

/// Reports are plain text to Python, whose json reads them.
std::string run_to_json(const fs::path& file, const std::vector<std::string>& overrides, const fs::path& out,
                        bool force, int threads) {
  const Scene scene = required(read_scene(file, overrides));
  const nb::gil_scoped_release others;
  RunOptions options{.out = out, .foreign = force ? Foreign::kRemove : Foreign::kRefuse, .live = {}};
  return json_text(required(run_scene(Exec(threads), scene, options)), -1);
}

void bind_body(nb::module_& module) {
  constexpr auto kOwn = nb::rv_policy::automatic;  // arrays own their numbers
  nb::class_<ShownBody>(module, "Body", "A body as it was when it was asked for. Arrays are copies.")
      .def_ro("name", &ShownBody::name)
      .def_prop_ro(
          "model", [](const ShownBody& b) { return model_name(b.id.kind); },
          "sfem, lattice, rhombus or cloth")
      .def_prop_ro(
          "rest_points", [](const ShownBody& b) { return places(b.rest); }, kOwn, "(n, 3), at rest [m]")
      .def_prop_ro(
          "points", [](const ShownBody& b) { return places(b.x); }, kOwn, "(n, 3), now [m]")
      .def_prop_ro(
          "displacement", [](const ShownBody& b) { return places(b.displacement); }, kOwn, "(n, 3) [m]")
      .def_prop_ro(
          "normals", [](const ShownBody& b) { return places(b.normals); }, kOwn, "(n, 3), unit, outward")
      .def_prop_ro(
          "pressure", [](const ShownBody& b) { return new_array(std::vector<float>(b.pressure), 0); }, kOwn,
          "(n,) of the contact [Pa]; empty where it is not known")
      .def_prop_ro(
          "triangles",
          [](const ShownBody& b) {
            std::vector<int> corners;
            for (const Int3 t : b.triangles) corners.insert(corners.end(), {t.x, t.y, t.z});
            return new_array(std::move(corners), 3);
          },
          kOwn, "(m, 3), counter-clockwise seen from outside");
}

void bind_world(nb::module_& module) {
  nb::class_<PyWorld>(module, "World", "A scene that is being simulated.")
      .def(
          "__init__",
          [](PyWorld* self, const fs::path& scene, const std::optional<std::string>& text,
             const std::vector<std::string>& overrides, int threads) {
            new (self)
                PyWorld(required(text ? parse_scene(*text, scene, overrides) : read_scene(scene, overrides)),
                        threads);
          },
          "scene"_a, "text"_a.none(), "overrides"_a, "threads"_a)
      .def("step", &PyWorld::step, "frames"_a = 1, "Simulates so many frames.")
      .def_prop_ro("time", &PyWorld::time, "simulated so far [s]")
      .def_prop_ro("frame", &PyWorld::frame, "finished frames")
      .def_prop_ro("dt", &PyWorld::dt, "of a frame [s]")
      .def_prop_ro("duration", &PyWorld::duration, "of the scene [s]")
      .def_prop_ro("state_hash", &PyWorld::hash, "equal for equal bits in all bodies and forces")
      .def_prop_ro("bodies", &PyWorld::bodies, "their names")
      .def_prop_ro("tools", &PyWorld::tools, "their names")
      .def_prop_ro("notes", &PyWorld::notes, "what a person should know of how it was made")
      .def(
          "__getitem__", [](const PyWorld& w, const std::string& name) { return ShownBody(w.body(name)); },
          "name"_a)
      .def("forces", &PyWorld::forces, "tool"_a,
           "What a tool felt, tick by tick: time_s, position_m, force_N, torque_Nm, depth_m, contacts.")
      .def("drive", &PyWorld::drive, "tool"_a, "rows"_a,
           "Leads a tool from where it is in straight lines along rows of [t, x, y, z], t [s] from now on; a "
           "fifth column takes hold (1) or "
           "not (0), four more turn it (a quaternion w, x, y, z).");
}

}  // namespace
}  // namespace turgor

NB_MODULE(_turgor, module) {
  nb::exception<turgor::Refused>(module, "Error", PyExc_ValueError);
  module.def("run_to_json", &turgor::run_to_json, "scene"_a, "overrides"_a, "out"_a, "force"_a, "threads"_a);
  module.attr("__version__") = turgor::program_version();
  turgor::bind_body(module);
  turgor::bind_world(module);
}
