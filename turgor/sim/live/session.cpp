#include "turgor/sim/live/session.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <mutex>
#include <optional>

#include <fmt/format.h>

#include "turgor/core/timing.hpp"
#include "turgor/sim/live/change_world.hpp"
#include "turgor/sim/live/mouse_tools.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

namespace {

/// A mean over some tens of samples.
void average(double& mean, double sample) { mean += (mean > 0 ? 0.1 : 1.0) * (sample - mean); }

/// Those behind the scene's own.
std::vector<lattice::Incision> cuts_by_hand(const Scene& scene, const World& world) {
  std::vector<lattice::Incision> cuts;
  for (std::size_t c = scene.incisions.size(); c < world.cuts.size(); c++) {
    cuts.push_back(world.cuts[c].blade);
    cuts.back().name = world.lattice_bodies[std::size_t(world.cuts[c].body)].name;
  }
  return cuts;
}

/// What a person is told of a step that was undone.
std::string not_finite(const World& world) {
  return fmt::format(
      "the numbers of the next step were not finite; the world stands still as it was "
      "at {:.3f} s (a smaller skin tension or a higher frame rate may help)",
      (world.frame - 1) * world.dt);
}

}  // namespace

/// What the session's thread owns.
struct Session::Thread {
  Session& session;
  Exec exec;
  OpenRequest file;
  std::shared_ptr<const Scene> scene, original;  // with what was changed; as the world was made
  std::vector<RecordedRequest> applied;          // since then
  std::unique_ptr<World> world;                  // stays where it is in memory
  std::vector<MouseTool> mouse;
  std::unique_ptr<LiveTouch> touch;  // after the world and the devices, which it uses
  std::optional<FrameClock> clock;   // where nothing is felt
  SessionNow next;                   // all but `shown`, which is made where it is read
  std::chrono::steady_clock::time_point frame_begun;
  double frame_period = 0;  // by the clock, a mean over some [s]
  std::mutex telling;       // how far loading is
  std::chrono::steady_clock::time_point told;
  double moved = 0;      // at most, that any tissue of the first lattice has since its CT was made [m]
  std::size_t cuts = 0;  // that it had then

  void run();
  bool wait(std::vector<Request>& asked);
  void load();
  void tell(double done);
  Status try_load();
  void unload();
  void frame();
  double wait_for_clock();
  void stand_still(const std::string& why);
  void note_motion();
  bool is_as_it_was(const LatticeBody& body) const;
  void publish();
  void take_felt();
  void set_pace();

  void handle(const PaceRequest& request);
  void handle(const StepRequest&);
  void handle(const ResetRequest&);
  void handle(const ReloadRequest&);
  void handle(const OpenRequest& request);
  void handle(const CtRequest& request);
  void handle(const ChangeRequest& request);
  void handle(const SaveRequest& request);
  template <class AnyAsk>
  void handle(const AnyAsk& request);
};

void Session::Thread::run() {
  load();
  std::vector<Request> asked;
  while (wait(asked)) {
    for (const Request& request : asked) std::visit([this](const auto& one) { handle(one); }, request);
    asked.clear();
    if (next.plays && world) frame();
    publish();
  }
  unload();
}

/// For something to do. False: to end.
bool Session::Thread::wait(std::vector<Request>& asked) {
  std::unique_lock lock(session.mutex_);
  const bool goes_on = next.plays && world;
  if (!goes_on) session.woken_.wait(lock, [this] { return session.ends_ || !session.requests_.empty(); });
  asked.swap(session.requests_);
  return !session.ends_;
}

void Session::Thread::unload() {
  if (touch) touch->stop();
  touch.reset(), clock.reset(), mouse.clear(), world.reset();
}

/// The file as it is now, with what was changed.
void Session::Thread::load() {
  unload();
  const SessionNow before = std::move(next);
  next = {.world = before.world + 1,
          .scene = scene ? before.scene : nullptr,
          .pace = before.pace,
          .plays = before.plays};
  next.doing = "loading " + file.file.filename().string();
  publish();
  if (const Status status = try_load(); !status) {
    unload();
    next.phase = SessionNow::Phase::kFailed, next.error = status.error().message;
  } else {
    next.phase = SessionNow::Phase::kReady, next.notes = notes_of(*world);
  }
  publish();
}

/// Any thread that loads calls it, while the session's waits; some twenty times a second it is shown.
void Session::Thread::tell(double done) {
  const std::unique_lock lock(telling, std::try_to_lock);
  const auto now = std::chrono::steady_clock::now();
  if (!lock || now - told < std::chrono::milliseconds(50)) return;
  told = now, next.done = done;
  publish();
}

Status Session::Thread::try_load() {
  if (!scene) {
    Result<Scene> read = read_scene(file.file, file.overrides);
    if (!read) return read.error();
    scene = std::make_shared<const Scene>(std::move(*read));
  }
  next.scene = original = scene;
  applied.clear();
  const Scene with_tools = with_mouse_tools(*scene);
  const BeginWork begin = [this](const std::string& label, const std::string&) -> Progress {
    next.doing = label, next.done = 0;
    publish();
    return [this](double done) { tell(done); };
  };
  Result<World> loaded = load_world(exec, with_tools, begin);
  if (!loaded) return loaded.error();
  world = std::make_unique<World>(std::move(*loaded));
  next.haptic.resize(world->tools.size());
  clock.emplace(world->dt);
  Result<LiveHands> hands = hold_mouse_tools(*world);
  if (!hands) return hands.error();
  mouse = hands->mouse;
  if (!hands->held.empty()) {
    auto started = LiveTouch::start(*world, hands->held, {session.params_.loop, session.params_.longest});
    if (!started) return started.error();
    touch = std::move(*started);
  }
  next.mouse = mouse, next.is_haptic = touch != nullptr;
  set_pace();
  return Done{};
}

/// One of the world, and then until the next is due.
void Session::Thread::frame() {
  const Timer timer;
  const Result<FrameReport> report = step(exec, *world);
  average(next.frame_seconds, timer.seconds());
  if (touch && report) touch->note_frame();
  if (!report) return stand_still(report.error().message);
  if (!report->finite) return stand_still(not_finite(*world));
  take_felt(), note_motion();
  const double late = wait_for_clock();
  constexpr double kForgotten = 0.25;  // what cannot be made up for [s]
  if (late > kForgotten) set_pace();
}

double Session::Thread::wait_for_clock() {
  const double late = touch ? touch->wait_for_frame() : clock->wait(world->frame);
  const auto now = std::chrono::steady_clock::now();
  const double passed = std::chrono::duration<double>(now - frame_begun).count();
  frame_begun = now;
  average(frame_period, passed);
  next.real_pace = world->dt / std::max(frame_period, 1e-6);
  return late;
}

void Session::Thread::note_motion() {
  if (world->lattice_bodies.empty()) return;
  moved += world->lattice_bodies[0].last_way;
}

void Session::Thread::stand_still(const std::string& why) {
  next.error = why, next.plays = false;
  set_pace();
}

/// What passed since the last time is forgotten.
void Session::Thread::set_pace() {
  if (touch) touch->set_pace(next.plays ? next.pace : 0);
  clock->set_pace(next.pace);
  frame_begun = std::chrono::steady_clock::now();
}

void Session::Thread::take_felt() {
  if (!touch) return;
  const std::vector<HapticStatus>& haptic = touch->haptic();
  for (std::size_t t = 0; t < haptic.size(); t++) {
    std::vector<HapticSample>& points = next.haptic[t];
    if (points.size() == SessionNow::kMaxHapticSamples) points.erase(points.begin());
    points.push_back(
        {time_of(*world), norm(haptic[t].reading.force), haptic[t].reading.depth, haptic[t].work});
  }
}

/// All of it where the reader finds it; what is shown is made there, in memory of before.
void Session::Thread::publish() {
  if (touch) next.haptics = touch->timing();
  if (world) next.cuts = cuts_by_hand(*scene, *world);
  next.frames = touch ? touch->frames() : clock ? clock->timing() : FrameTiming();
  SessionNow& out = session.now_.writing();
  WorldSnapshot snapshot = out.world == next.world ? std::move(out.snapshot) : WorldSnapshot();
  out = next;
  out.snapshot = std::move(snapshot);
  if (world && next.phase == SessionNow::Phase::kReady) {
    const Timer timer;
    show(exec, *world, out.snapshot);
    average(next.show_seconds, timer.seconds());
  }
  session.now_.publish();
}

void Session::Thread::handle(const PaceRequest& request) {
  next.plays = request.plays, next.pace = request.pace;
  if (next.plays) next.error.clear();
  if (world) set_pace();
}

void Session::Thread::handle(const StepRequest&) {
  if (!world || next.plays) return;
  if (touch) touch->allow(world->dt);
  if (touch) std::this_thread::sleep_for(std::chrono::duration<double>(1.5 * world->dt / next.pace));
  const Result<FrameReport> report = step(exec, *world);
  if (touch && report) touch->note_frame();
  next.error = report ? "" : report.error().message;
  take_felt(), note_motion();
  if (report && !report->finite) next.error = not_finite(*world);
}

void Session::Thread::handle(const ResetRequest&) { load(); }

/// After a file that could not be read: that file.
void Session::Thread::handle(const ReloadRequest&) {
  if (scene) file.overrides = scene->overrides;
  scene.reset();
  load();
}

void Session::Thread::handle(const OpenRequest& request) {
  file = request, scene.reset();
  load();
}

void Session::Thread::handle(const CtRequest& request) {
  if (!world || world->lattice_bodies.empty()) return;
  const LatticeBody& body = world->lattice_bodies[0];
  if (next.ct && next.ct->answers(request.wish) && is_as_it_was(body)) return;
  next.ct = std::make_shared<const DeformedCt>(
      make_deformed_ct(exec, body, world->frame, request.wish, SessionNow::kMostSamples));
  moved = 0, cuts = body.state.cuts();
}

/// Since its CT was made, but for what no picture shows. Before the first frame it is not yet where it steps.
bool Session::Thread::is_as_it_was(const LatticeBody& body) const {
  const Vec3d spacing = body.ct.grid.spacing;
  return next.ct->frame > 0 && body.state.cuts() == cuts &&
         moved <= 0.01 * std::min({spacing.x, spacing.y, spacing.z});
}

/// A cut, a wind, another value of a key: of a world, or a sentence why not.
template <class AnyAsk>
void Session::Thread::handle(const AnyAsk& request) {
  if (!world) return;
  const Status status = apply_request(exec, request, scene, *world);
  next.error = status ? "" : status.error().message;
  if (!status) return;
  applied.push_back({world->frame, request});
  next.scene = scene;
}

/// Where there is no world, what another will be made of.
void Session::Thread::handle(const ChangeRequest& request) {
  if (world) return handle<ChangeRequest>(request);
  if (!scene) return;
  Result<Scene> changed = with_change(*scene, request.key, request.value);
  next.error = changed ? "" : changed.error().message;
  if (changed) next.scene = scene = std::make_shared<const Scene>(std::move(*changed));
}

void Session::Thread::handle(const SaveRequest& request) {
  if (!world) return;
  Result<HapticRecording> run =
      touch ? touch->haptic_recording() : HapticRecording{.frames = world->frame, .hash = state_hash(*world)};
  Status status = run ? Status(Done{}) : run.error();
  if (status) {
    note_scene(*original, true, *run);
    run->requests = applied;
    status = write_haptic_recording(request.file, *run);
  }
  next.saved = status ? fmt::format("saved {}: turgor replay does it again", request.file.string())
                      : status.error().message;
}

Session::Session(const std::filesystem::path& file, std::vector<std::string> overrides,
                 const SessionParams& params)
    : params_(params) {
  thread_ = std::thread([this, opened = OpenRequest{file, std::move(overrides)}] {
    Thread thread{*this, Exec(params_.threads), opened, {}, {}, {}, {}, {}, {}, {}, {}, {}, 0};
    thread.run();
  });
}

Session::~Session() {
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
  }
  woken_.notify_one();
  thread_.join();
}

void Session::request(Request request) {
  {
    const std::lock_guard lock(mutex_);
    requests_.push_back(std::move(request));
  }
  woken_.notify_one();
}

}  // namespace turgor
