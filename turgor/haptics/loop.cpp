#include "turgor/haptics/loop.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>

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

}  // namespace

struct Loop::Thread {
  Ticker ticker;
  LoopParams params;
  std::thread own;               // none if a device calls
  RunningHand* pacer = nullptr;  // its device calls and thereby keeps the time
  int last_ticks = 0;
  bool locked = false, stopped = false;
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
  bool is_paced() const;
  static void device_callback(void* context, const DeviceInput& input, DeviceOutput& output);
};

/// Runs a tick, or finishes the loop after the last one. Returns false when finished.
bool Loop::Thread::tick_or_finish() {
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
  if (params.priority > 0) no_priority = set_real_time_priority(params.priority);
  prefault_stack();
  began = true;
  began.notify_all();
  // ticks at absolute deadlines
  TURGOR_CHECK(ticker.rate > 0, "a loop has a rate");
  const double period = 1 / ticker.rate;
  double next = steady_seconds();
  while (tick_or_finish()) {
    const double now = steady_seconds();
    next = is_paced() ? now : next + period;
    if (now > next + period) {  // whole periods were missed
      const double passed = std::floor((now - next) / period);
      ticker.record.missed += std::uint64_t(passed);
      next += passed * period;
    }
    if (!is_paced()) sleep_until(next);
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
  constexpr double kStale = 0.02;  // [s]
  const bool fresh = !caller.thread->ended && now - newest.time < kStale;
  output = (fresh ? newest.output : SafeOutput()).value();
}

Status Loop::Thread::begin(const std::vector<Hand>& hands) {
  // state of each hand
  for (const Hand& hand : hands) {
    TURGOR_ASSERT(hand.device, "a hand holds a device");
    auto running = std::make_unique<RunningHand>();
    running->safety = make_safety(hand.device->spec(), hand.safety);
    running->hand = hand;
    if (running->calls() && !pacer) pacer = running.get();
    if (running->hand.device->pacing() != Pacing::kLoop) params.rate = running->hand.device->spec().rate;
    ticker.hands.push_back(std::move(running));
  }
  // storage and memory lock
  TURGOR_CHECK(params.rate > 0, "a device has a rate");
  ticker.rate = params.rate;
  ticker.is_device_paced = pacer != nullptr;
  ticker.commands.resize(ticker.hands.size());
  ticker.readings.resize(ticker.hands.size());
  if (params.lock_memory) no_lock = lock_memory(), locked = no_lock.empty();
  // start the device's thread or our own
  if (pacer) return begin_calls();
  Result<std::thread> started = start_thread("the haptic loop", [this] { run(); });
  if (!started) return started.error();
  own = std::move(*started);
  began.wait(false);
  return Done{};
}

Status Loop::Thread::begin_calls() {
  began = true;
  for (const auto& hand : ticker.hands) callers.push_back({this, hand.get()});
  for (Caller& caller : callers)
    if (caller.hand->calls()) {
      caller.hand->mailbox.called_at = steady_seconds();
      if (Status status = caller.hand->hand.device->start(device_callback, &caller); !status) return status;
    }
  return Done{};
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
  const bool calls = !t.pacer || steady_seconds() - t.pacer->mailbox.called_at < kUnheard;
  return t.began && !t.ended && !t.ticker.threw && calls;
}

void Loop::stop() noexcept {
  Thread& t = *thread_;
  if (t.stopped) return;
  t.stopped = true;
  t.ticker.stopping = true;
  if (t.own.joinable()) t.own.join();
  while (t.pacer && running()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  for (const auto& hand : t.ticker.hands) hand->hand.device->close();
  t.ended = true;
  if (t.locked) unlock_memory();
}

const HandStatus& Loop::status(std::size_t hand) { return thread_->ticker.hands.at(hand)->status.read(); }

const TimingReport& Loop::report() { return thread_->ticker.report.read(); }

std::vector<std::string> Loop::notes() const {
  const Thread& t = *thread_;
  // refused system settings
  std::vector<std::string> notes;
  for (const std::string& note : {t.no_priority, t.no_lock})
    if (!note.empty()) notes.push_back(note);
  // failures and lost devices
  if (t.ticker.threw) notes.emplace_back("the model threw an exception in a haptic tick; forces are off");
  for (const auto& hand : t.ticker.hands) {
    const std::string why = hand->hand.device->trouble(), remarks = hand->hand.device->remarks();
    if (!remarks.empty()) notes.push_back(fmt::format("{}: {}", hand->hand.device->spec().name, remarks));
    if (hand->lost)
      notes.push_back(fmt::format("the device {} was lost{}{}; its forces are off",
                                  hand->hand.device->spec().name, why.empty() ? "" : ": ", why));
  }
  return notes;
}

}  // namespace turgor::haptics
