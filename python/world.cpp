#include "world.hpp"

#include <algorithm>
#include <cmath>
#include <exception>
#include <thread>

#include <fmt/format.h>

#include "turgor/core/start_thread.hpp"
#include "turgor/core/thread_limit.hpp"
#include "turgor/geometry/reorient.hpp"
#include "turgor/sim/tools/tool_path.hpp"

namespace turgor {

namespace {

constexpr const char* kBusy = "this world is in a call of another thread";

/// Throws Refused for a number of threads that no run can have.
Exec checked_exec(int threads) {
  required(check_threads(threads));
  return Exec(threads);
}

/// Command from seven numbers. Error: numbers that are not finite, or a zero quaternion.
contact::ToolCommand command_of(const double* pose, bool hold, std::size_t tick, std::size_t tool) {
  double length = 0;
  for (int n = 3; n < 7; n++) length += pose[n] * pose[n];
  length = std::sqrt(length);
  bool finite = length > 0;
  for (int n = 0; n < 7; n++) finite = finite && std::isfinite(pose[n]);
  if (!finite)
    throw Refused(
        fmt::format("pose of tick {}, tool {}: expected x, y, z [m] and a quaternion w, x, y, z that is not "
                    "0, found {}, {}, {}, {}, {}, {}, {}",
                    tick, tool, pose[0], pose[1], pose[2], pose[3], pose[4], pose[5], pose[6]));
  std::array<double, 4> orientation{};
  for (std::size_t n = 0; n < 4; n++) orientation[n] = pose[3 + n] / length;
  return {.pose = {{pose[0], pose[1], pose[2]}, axes_of(orientation)}, .hold = hold};
}

/// Six numbers of every reading: force [N] and torque [N·m].
void put_readings(const std::vector<contact::ToolReading>& readings, double* forces) {
  for (std::size_t t = 0; t < readings.size(); t++)
    for (int axis = 0; axis < 3; axis++)
      forces[6 * t + std::size_t(axis)] = readings[t].force[axis],
                     forces[6 * t + 3 + std::size_t(axis)] = readings[t].torque[axis];
}

}  // namespace

PyWorld::Entered::Entered(PyWorld& world) : world_(world) {
  if (world.busy_.exchange(true)) throw std::runtime_error(kBusy);
}

PyWorld::PyWorld(Scene scene, std::map<std::string, Grid> left_handed, int threads, bool keeps_forces,
                 const BeginWork& begin)
    : exec_(checked_exec(threads)),
      scene_(std::make_shared<const Scene>(std::move(scene))),
      left_handed_(std::move(left_handed)),
      keeps_forces_(keeps_forces) {
  world_ = std::make_unique<World>(required(load_world(exec_, *scene_, begin)));
  measures_ = make_measures(*world_);
  loaded_ = loaded_world(*world_);
  limit_logs();
}

PyWorld::PyWorld(PyWorld& other, int threads) : PyWorld(Entered(other), other, threads) {}

PyWorld::PyWorld(const Entered&, PyWorld& other, int threads)
    : exec_(threads == 0 ? other.exec_ : checked_exec(threads)),
      scene_(other.scene_),
      left_handed_(other.left_handed_),
      keeps_forces_(other.keeps_forces_),
      driven_(other.driven_),
      was_touched_(other.was_touched_),
      measures_(other.measures_),
      loaded_(other.loaded_) {
  other.expect_untouched("a copy");
  const nb::gil_scoped_release others;
  world_ = std::make_unique<World>(copy_of(*other.world_));
}

void PyWorld::limit_logs() {
  if (keeps_forces_) return;
  for (TouchingTool& tool : world_->tools) {
    TouchLog empty;
    empty.start(turgor::command_of(tool.samples.start()));
    empty.preallocate(0);
    tool.samples = std::move(empty);
  }
}

void PyWorld::forget_snapshot(std::uint64_t cuts_before) {
  if (cuts_hash(*world_) != cuts_before) snapshot_ = {};
  is_shown_ = false;
}

void PyWorld::step(int frames) {
  if (!is_touched_) expect_no_touch("step()");
  if (driven_ && !is_touched_)
    throw Refused("this world runs tick by tick: expected tick(), which includes frames, found step()");
  is_shown_ = false;
  for (int f = 0; f < frames; f++) {
    const FrameReport report = required(turgor::step(exec_, *world_));
    if (!report.finite) throw Refused("a step was not finite; the state before it was kept");
    measure_frame(exec_, *world_, report, false, measures_);
  }
}

void PyWorld::expect_untouched(const char* call) const {
  if (is_touched_)
    throw Refused(
        fmt::format("expected {} before begin_touch() or after end_touch(), found it between", call));
}

void PyWorld::expect_no_touch(const char* call) const {
  if (is_touched_) throw Refused(fmt::format("expected {} before begin_touch(), found it after", call));
  if (was_touched_)
    throw Refused(fmt::format(
        "{}: expected a new world, or set_state() with a state from before begin_touch(), found a "
        "world whose haptic session has ended",
        call));
}

void PyWorld::begin_touch() {
  const Entered entered(*this);
  if (!is_touched_) expect_no_touch("begin_touch()");
  if (driven_) throw Refused("begin_touch: expected a world without ticks, found one with earlier ticks");
  commands_.resize(world_->tools.size()), readings_.resize(world_->tools.size());
  driven_ = begin_driven(*world_), is_touched_ = was_touched_ = true;
}

void PyWorld::touch_tick(const double* poses, const bool* holds, double* forces, double* used) {
  if (!is_touched_) throw Refused("touch_tick: expected an earlier begin_touch(), found none");
  if (is_ticking_.exchange(true)) throw std::runtime_error("this world is being ticked by another thread");
  const std::unique_ptr<std::atomic<bool>, void (*)(std::atomic<bool>*)> ticking(
      &is_ticking_, [](std::atomic<bool>* flag) { *flag = false; });
  // commands; frames change neither driven_ nor its paths
  const double end = time_of(*driven_) + kTick;
  for (std::size_t t = 0; t < commands_.size(); t++) {
    const bool is_led = std::isfinite(poses[7 * t]);
    commands_[t] =
        is_led ? command_of(poses + 7 * t, holds && holds[t], 0, t) : turgor::path_command(*driven_, t, end);
    const PathRow row = path_of({{0, {.pose = commands_[t].pose}}}).rows[0];
    for (int axis = 0; axis < 3; axis++) used[7 * t + std::size_t(axis)] = row.position[axis];
    std::copy(row.orientation.begin(), row.orientation.end(), used + 7 * t + 3);
  }
  tick_tools(*world_, *driven_, commands_, readings_);
  put_readings(readings_, forces);
}

void PyWorld::end_touch() {
  const Entered entered(*this);
  if (!is_touched_) throw Refused("end_touch: expected an earlier begin_touch(), found none");
  if (is_ticking_) throw std::runtime_error("this world is being ticked by another thread");
  end_driven(*world_), is_touched_ = false;
}

void PyWorld::tick(std::size_t ticks, const double* poses, const bool* holds, double* forces) {
  const std::size_t tools = world_->tools.size();
  expect_no_touch("tick()");
  commands_.resize(tools), readings_.resize(tools);
  is_shown_ = false;
  if (!driven_) driven_ = begin_driven(*world_);
  for (std::size_t n = 0; n < ticks; n++) {
    for (std::size_t t = 0; t < tools; t++)
      commands_[t] = command_of(poses + 7 * (n * tools + t), holds && holds[n * tools + t], n, t);
    required(tick_driven(exec_, *world_, *driven_, commands_, readings_));
    put_readings(readings_, forces + 6 * n * tools);
  }
}

std::string PyWorld::cut(const CutByHand& cut) {
  const Entered entered(*this);
  return required(cut_by_hand(exec_, cut, scene_, *world_));
}

std::string PyWorld::stitch(const StitchByHand& stitch) {
  const Entered entered(*this);
  return required(stitch_by_hand(exec_, stitch, scene_, *world_));
}

void PyWorld::tighten(const std::string& stitch, std::optional<double> tension, double duration) {
  const Entered entered(*this);
  required(tighten_by_hand(exec_, stitch, tension, duration, scene_, *world_));
}

PyState PyWorld::state() {
  const Entered entered(*this);
  expect_untouched("get_state()");
  const nb::gil_scoped_release others;
  return {scene_, state_of(*world_), driven_, was_touched_, measures_};
}

void PyWorld::set_state(const PyState& state) {
  const Entered entered(*this);
  expect_untouched("set_state()");
  if (state.scene != scene_)
    throw Refused("expected a state of this world or of a copy of it, found one of another world");
  const nb::gil_scoped_release others;
  const std::uint64_t cuts_before = cuts_hash(*world_);
  turgor::set_state(*world_, state.state);
  driven_ = state.driven, was_touched_ = state.was_touched, measures_ = state.measures;
  forget_snapshot(cuts_before);
}

void PyWorld::expect_frames(const char* call) const {
  expect_no_touch(call);
  if (driven_)
    throw Refused(
        fmt::format("this world runs tick by tick: expected get_state() or copy(), found {}", call));
}

void PyWorld::save(const std::filesystem::path& path) {
  const Entered entered(*this);
  expect_frames("save()");
  const nb::gil_scoped_release others;
  required(save_world(path, *scene_, *world_, measures_, loaded_));
}

void PyWorld::load(const std::filesystem::path& path) {
  const Entered entered(*this);
  expect_frames("load()");
  const nb::gil_scoped_release others;
  const std::uint64_t cuts_before = cuts_hash(*world_);
  required(read_saved_world(exec_, path, *scene_, loaded_, *world_, measures_));
  limit_logs();
  forget_snapshot(cuts_before);
}

World& PyWorld::world() const {
  if (busy_) throw std::runtime_error(kBusy);
  return *world_;
}

WorldSnapshot& PyWorld::snapshot() {
  world();
  if (!is_shown_ || has_writers_) show(exec_, *world_, snapshot_);
  is_shown_ = true;
  return snapshot_;
}

TouchingTool& PyWorld::tool(const std::string& name) const {
  for (TouchingTool& tool : world().tools)
    if (tool.name == name) return tool;
  throw nb::key_error(("the scene has no tool " + name).c_str());
}

contact::ToolCommand PyWorld::path_command(std::size_t tool) const {
  const double now = time_of(world());
  return driven_ ? turgor::path_command(*driven_, tool, now) : command_at(world_->tools[tool], now);
}

void PyWorld::drive(const std::string& name, const std::vector<std::vector<double>>& rows) {
  TouchingTool& driven = tool(name);
  expect_no_touch("drive()");
  if (driven_) throw Refused(name + ": this world runs tick by tick: expected tick(), found drive()");
  std::vector<PathRow> path = required(path_rows(rows));
  if (path.empty()) throw Refused(name + ": expected a path of at least one row, found none");
  if (path.front().time < 0) throw Refused(name + ": expected times from now on, found one before");
  const double now = time_of(*world_);
  const PathRow present = path_at(driven.path, now);
  for (PathRow& row : path) row.time += now;
  if (path.front().time > now) path.insert(path.begin(), present);
  driven.path = {std::move(path), false};
  driven.hand.clear();
}

CtVolume PyWorld::as_given(const std::string& body, CtVolume ct) const {
  const auto given = left_handed_.find(body);
  if (given == left_handed_.end()) return ct;
  CtVolume turned = reordered(ct, AxisOrder{.flip = {true, false, false}});
  turned.grid = given->second;  // the same grid apart from rounding
  return turned;
}

void tick_worlds(const std::vector<PyWorld*>& worlds, std::size_t ticks, std::size_t tools,
                 const double* poses, const bool* holds, double* forces, int threads) {
  std::vector<std::exception_ptr> failures(worlds.size());
  std::atomic<std::size_t> next{0};
  const auto work = [&] {
    for (std::size_t w = next++; w < worlds.size(); w = next++) {
      const std::size_t first = w * ticks * tools;
      try {
        worlds[w]->tick(ticks, poses + 7 * first, holds ? holds + first : nullptr, forces + 6 * first);
      } catch (...) {
        failures[w] = std::current_exception();
      }
    }
  };
  // not parallel_for, which flushes denormal numbers to zero: results must not depend on the other worlds
  const std::size_t count = std::min(worlds.size(), std::size_t(checked_exec(threads).threads()));
  std::vector<std::thread> others;
  for (std::size_t n = 1; n < count; n++)
    if (Result<std::thread> other = start_thread("a world", work)) others.push_back(std::move(*other));
  work();
  for (std::thread& other : others) other.join();
  for (const std::exception_ptr& failure : failures)
    if (failure) std::rethrow_exception(failure);
}

}  // namespace turgor
