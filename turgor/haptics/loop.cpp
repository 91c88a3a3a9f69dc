#include "turgor/haptics/loop.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>
#include <utility>

#include <fmt/format.h>

#include "turgor/core/assert.hpp"
#include "turgor/core/flush_denormals.hpp"
#include "turgor/core/start_thread.hpp"
#include "turgor/haptics/real_time.hpp"
#include "turgor/haptics/ticker.hpp"

namespace turgor::haptics {

namespace {

constexpr int kLastTicks = 50;    // ticks after stop; a force that has not faded by then ends with the device
constexpr double kUnheard = 0.1;  // time without a call after which a device's thread counts as ended [s]
constexpr double kLook = 0.005;   // between two checks for such calls [s]

/// True for a device that calls and has not done so for some time.
bool is_unheard(const RunningHand& hand) {
  return hand.calls() && steady_seconds() - hand.mailbox.called_at > kUnheard;
}

constexpr const char* kThrew = "the model threw an exception in a haptic tick; forces are off";

/// "the device NAME was lost: REASON".
std::string sentence_of(const Loss& loss, const std::string& name, const std::string& times) {
  return fmt::format("the device {} was lost{}{}{}", name, times, loss.reason.empty() ? "" : ": ",
                     loss.reason);
}

/// Note on all losses of a device.
std::string summary_of(const Loss& loss, const std::string& name) {
  TURGOR_CHECK(loss.count > 0, "a lost device was lost at least once");
  const std::string times = loss.count > 1 ? fmt::format(" {} times", loss.count) : "";
  return sentence_of(loss, name, times) +
         (loss.is_lost ? "; its forces are off" : "; it returned, and its force started softly");
}

}  // namespace

struct Loop::Thread {
  Ticker ticker;
  LoopParams params;
  std::thread own;               // its ticks stand in for those of the pacer, if there is one
  RunningHand* pacer = nullptr;  // its device calls and thereby keeps the time
  std::atomic<bool> is_ticking = false;
  int last_ticks = 0;
  bool locked = false, stopped = false, told_throw = false;
  std::vector<std::string> news;  // for Loop::news
  std::string no_priority, no_lock;
  std::atomic<bool> began = false, ended = false;

  struct Caller {
    Thread* thread;
    RunningHand* hand;
  };
  std::vector<Caller> callers;

  Status begin(const std::vector<Hand>& hands);
  Status begin_calls();
  void run();
  bool tick_or_finish();
  bool next_tick();
  bool is_paced() const;
  void look();
  void look_at(RunningHand& hand);
  static void device_callback(void* context, const DeviceInput& input, DeviceOutput& output);
};

/// Runs a tick, or finishes the loop after the last one. Returns false when finished. A thread that finds
/// another one in a tick runs none.
bool Loop::Thread::tick_or_finish() {
  if (is_ticking.exchange(true)) return !ended;
  const bool more = next_tick();
  is_ticking = false;
  return more;
}

bool Loop::Thread::next_tick() {
  if (ended) return false;
  const bool more = run_tick(ticker) && !(ticker.stopping && ++last_ticks > kLastTicks);
  if (more) return true;
  send_zero_forces(ticker);
  publish_report(ticker, steady_seconds());
  ended = true;
  return false;
}

/// True when a device kept the time of this tick.
bool Loop::Thread::is_paced() const {
  return std::any_of(ticker.hands.begin(), ticker.hands.end(), [](const auto& hand) {
    return hand->answered && hand->hand.device->pacing() == Pacing::kDevice;
  });
}

void Loop::Thread::run() {
  const FlushDenormals flush;
  // real-time settings
  const std::string refused = params.priority > 0 ? set_real_time_priority(params.priority) : "";
  if (!pacer) no_priority = refused;
  prefault_stack();
  began = true;
  began.notify_all();
  // ticks at absolute deadlines
  TURGOR_CHECK(ticker.rate > 0, "a loop has a rate");
  const double period = 1 / ticker.rate;
  double next = steady_seconds();
  while (!ended) {
    // a device that calls runs the ticks; this thread stands in for it while it does not call
    if (pacer && !is_unheard(*pacer)) {
      next = steady_seconds() + kLook;
      sleep_until(next);
      continue;
    }
    if (!tick_or_finish()) break;
    const double now = steady_seconds();
    const bool keeps_time = pacer || !is_paced();
    next = keeps_time ? next + period : now;
    if (pacer) next = std::max(next, now);  // it may run ticks again and owns the record then
    if (now > next + period) {              // whole periods were missed
      const double passed = std::floor((now - next) / period);
      ticker.record.missed += std::uint64_t(passed);
      next += passed * period;
    }
    if (keeps_time) sleep_until(next);
  }
}

/// Runs on the thread of a device that calls.
void Loop::Thread::device_callback(void* context, const DeviceInput& input, DeviceOutput& output) {
  const FlushDenormals flush;
  const Caller& caller = *static_cast<Caller*>(context);
  TURGOR_CHECK(caller.thread != nullptr && caller.hand != nullptr, "a device calls for a hand of the loop");
  Mailbox& mailbox = caller.hand->mailbox;
  // the hand's state to the mailbox; the pacing device runs the tick
  const double now = steady_seconds();
  mailbox.hand.write(input);
  mailbox.called_at = now;
  if (caller.thread->pacer == caller.hand) caller.thread->tick_or_finish();
  // newest output from the mailbox, unless it is stale
  const Mailbox::TimedOutput& newest = mailbox.output.read();
  const bool fresh = !caller.thread->ended && now - newest.time < kStale;
  output = (fresh ? newest.output : SafeOutput()).value();
}

Status Loop::Thread::begin(const std::vector<Hand>& hands) {
  // state of each hand
  ticker.rate = loop_rate(hands, params.rate);
  for (const Hand& hand : hands) {
    auto running = std::make_unique<RunningHand>();
    running->safety = make_safety(hand.device->spec(), hand.safety, 1 / ticker.rate);
    running->hand = hand;
    if (running->calls() && !pacer) pacer = running.get();
    running->is_pacer = running.get() == pacer;
    ticker.hands.push_back(std::move(running));
  }
  // storage and memory lock
  ticker.is_device_paced = pacer != nullptr;
  for (const Hand& hand : hands)  // until the first answer, the tool is in the middle of the workspace
    ticker.commands.push_back({.pose = to_world(hand.workspace, {})});
  ticker.readings.resize(ticker.hands.size());
  if (params.lock_memory) no_lock = lock_memory(), locked = no_lock.empty();
  // start our own thread and those of devices
  if (pacer) pacer->mailbox.called_at = steady_seconds();
  Result<std::thread> started = start_thread("the haptic loop", [this] { run(); });
  if (!started) return started.error();
  own = std::move(*started);
  began.wait(false);
  return begin_calls();
}

/// Starts the devices that call. No ticks stand in for a device that is being started.
Status Loop::Thread::begin_calls() {
  is_ticking = pacer != nullptr;
  Status status = Done{};
  for (const auto& hand : ticker.hands) callers.push_back({this, hand.get()});
  for (Caller& caller : callers)
    if (caller.hand->calls() && status) {
      caller.hand->mailbox.called_at = steady_seconds();
      status = caller.hand->hand.device->start(device_callback, &caller);
    }
  is_ticking = false;
  return status;
}

/// Looks for devices that were lost or returned since the last look. Not for the haptic thread.
void Loop::Thread::look() {
  for (const auto& hand : ticker.hands) look_at(*hand);
  if (ticker.threw && !std::exchange(told_throw, true)) news.emplace_back(kThrew);
}

void Loop::Thread::look_at(RunningHand& hand) {
  const Device& device = *hand.hand.device;
  Loss& loss = hand.loss;
  // state, and the reason as far as the device states it
  const bool was_lost = std::exchange(loss.is_lost, hand.lost || is_unheard(hand));
  const int before = std::exchange(loss.count, std::max(hand.losses.load(), loss.count));
  if (loss.is_lost && !was_lost && loss.count == before) loss.count++;  // no tick has counted it yet
  if (std::string reason = device.trouble(); loss.is_lost && !reason.empty()) loss.reason = std::move(reason);
  loss.remarks = device.remarks();
  // sentences
  const std::string& name = device.spec().name;
  if (loss.count > before) news.push_back(sentence_of(loss, name, "") + "; its forces are off");
  if (!loss.is_lost && (was_lost || loss.count > before))
    news.push_back(fmt::format("the device {} has returned; its force starts softly", name));
}

double loop_rate(std::span<const Hand> hands, double requested) {
  double slowest = 0;
  for (const Hand& hand : hands) {
    TURGOR_ASSERT(hand.device, "a hand holds a device");
    const double rate = hand.device->spec().rate;
    TURGOR_CHECK(rate > 0, "a device has a rate");
    if (hand.device->pacing() == Pacing::kCallback) return rate;
    if (hand.device->pacing() == Pacing::kDevice) slowest = slowest > 0 ? std::min(slowest, rate) : rate;
  }
  return slowest > 0 ? slowest : requested;
}

Loop::Loop() : thread_(std::make_unique<Thread>()) {}

Loop::~Loop() { stop(); }

Result<std::unique_ptr<Loop>> Loop::start(const std::vector<Hand>& hands, ToolTick tick, void* context,
                                          const LoopParams& params) {
  TURGOR_ASSERT(tick != nullptr, "a loop ticks a model");
  if (hands.empty()) return Error{"the haptic loop: expected a device, found none"};
  if (!(params.rate >= 1 && params.rate <= 1e5))
    return Error{fmt::format("the haptic loop: expected a rate from 1 to 100000 Hz, found {}", params.rate)};
  std::unique_ptr<Loop> loop(new Loop);
  loop->thread_->params = params;
  loop->thread_->ticker.model_tick = tick;
  loop->thread_->ticker.context = context;
  if (Status began = loop->thread_->begin(hands); !began) return began.error();
  return loop;
}

bool Loop::running() const {
  const Thread& t = *thread_;
  return t.began && !t.ended && !t.ticker.threw;
}

void Loop::stop() noexcept {
  Thread& t = *thread_;
  if (t.stopped) return;
  // devices say why they were lost only while they are open
  try {
    t.look();
  } catch (...) {  // no memory for the text
  }
  t.stopped = true;
  t.ticker.stopping = true;
  if (t.own.joinable()) t.own.join();
  for (const auto& hand : t.ticker.hands) hand->hand.device->close();
  t.ended = true;
  if (t.locked) unlock_memory();
}

const HandStatus& Loop::status(std::size_t hand) { return thread_->ticker.hands.at(hand)->status.read(); }

const TimingReport& Loop::report() { return thread_->ticker.report.read(); }

std::vector<std::string> Loop::news() {
  Thread& t = *thread_;
  if (!t.stopped) t.look();
  return std::exchange(t.news, {});
}

std::vector<std::string> Loop::notes() {
  Thread& t = *thread_;
  if (!t.stopped) t.look();
  // refused system settings
  std::vector<std::string> notes;
  for (const std::string& note : {t.no_priority, t.no_lock})
    if (!note.empty()) notes.push_back(note);
  // rate of a device
  if (t.ticker.rate != t.params.rate)
    notes.push_back(fmt::format("the device keeps its own time: the loop has {:g} ticks per second, not {:g}",
                                t.ticker.rate, t.params.rate));
  // failures and lost devices
  if (t.ticker.threw) notes.emplace_back(kThrew);
  for (const auto& hand : t.ticker.hands) {
    const std::string& name = hand->hand.device->spec().name;
    if (!hand->loss.remarks.empty()) notes.push_back(fmt::format("{}: {}", name, hand->loss.remarks));
    if (hand->loss.count > 0) notes.push_back(summary_of(hand->loss, name));
  }
  return notes;
}

}  // namespace turgor::haptics
