// Solutions of nonlinear patches beside a haptic thread. A thread of its own takes the forces of the newest
// tick, does a few Newton steps and publishes the linearized patch, at a rate that does not depend on the
// frames. It begins the next solution when a tick uses the last one. Every tick records the tick whose forces
// its patch was solved for, so that a replay solves the same sequence on one thread.
#pragma once

#include <atomic>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "turgor/contact/sfem_touch.hpp"
#include "turgor/core/result.hpp"
#include "turgor/models/sfem/nonlinear_patch.hpp"

namespace turgor {

/// Ticks between two solutions of a nonlinear patch: 125 a second.
constexpr long kLawTicks = 8;
/// Newton steps of a solution that follows another one.
constexpr int kLawSteps = 3;

/// Solutions of a nonlinear patch so far.
struct LawSummary {
  int solutions = 0, unconverged = 0;
  int most_steps = 0;        // Newton steps of one
  double seconds = 0;        // wall time of all
  double longest = 0;        // wall time of one [s]
  double strain = 0;         // largest Green strain in the patch [1]
  double border_strain = 0;  // beside its border, where the body is linear [1]
};
/// Adds a solution; `seconds` is 0 where it is a part of building a patch.
void add_solution(LawSummary& sum, const sfem::NonlinearReport& report, double seconds);
/// Adds the solutions of another summary.
void add_solutions(LawSummary& sum, const LawSummary& more);

/// A nonlinear patch that ticks use or will use.
struct LawBase {
  std::shared_ptr<const sfem::Patch> patch;  // as it was built
  sfem::NonlinearPatch nonlinear;
  long number = 0;  // FinishedPatch::number
};

/// Solutions since the last look.
struct LawProgress {
  LawSummary sum;
  int failed = 0;
  std::string failure;  // message of the first one
};

class LawSolver {
 public:
  LawSolver() = default;
  /// A copy has no patches and no thread: the world of a copy does not tick.
  LawSolver(const LawSolver&) {}
  LawSolver& operator=(const LawSolver&) = delete;
  ~LawSolver() { stop(); }

  // frame thread
  /// Hands over a patch, before the haptic thread gets it.
  void add(LawBase base);
  /// Starts the thread. The exchange outlives it. Error: the system refuses a thread.
  Status start(contact::SfemExchange& exchange);
  /// Waits for the solution in progress.
  void stop();
  LawProgress take_progress();

  // the thread, or a replay
  /// Solves the patch of these forces, from its latest solution. None if it was not handed over, or if its
  /// tangent cannot be factored.
  std::optional<contact::PatchSolution> solve(const contact::LawForces& now);

 private:
  void work(contact::SfemExchange& exchange);
  LawBase* base_of(long number);

  std::mutex mutex_;
  std::deque<LawBase> offered_;  // with the next, guarded by mutex_
  LawProgress progress_;

  std::deque<LawBase> bases_;                                  // of the solving thread, as the next
  std::vector<std::shared_ptr<const sfem::Patch>> solutions_;  // that other threads may use

  std::atomic<bool> ends_ = false;
  std::thread thread_;
};

/// Forces of recent ticks of a replay, for the solutions that later ticks use.
class ReplayedForces {
 public:
  void push(const contact::LawForces& now);
  /// Forces after this tick; null if there are none. Forgets those of earlier ticks.
  const contact::LawForces* after(long tick);

 private:
  std::deque<contact::LawForces> forces_;  // ascending; none for a tick that changed nothing
};

}  // namespace turgor
