#include "turgor/sim/bodies/sfem/law_solver.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include "turgor/core/assert.hpp"
#include "turgor/core/start_thread.hpp"
#include "turgor/core/timing.hpp"

namespace turgor {

namespace {

/// A solution, which keeps the patch that was solved: its Green's functions stay in use.
struct SolvedPatch {
  sfem::Patch patch;
  std::shared_ptr<const sfem::Patch> base;
};

std::shared_ptr<const sfem::Patch> shared_solution(sfem::Patch solved,
                                                   const std::shared_ptr<const sfem::Patch>& base) {
  auto owner = std::make_shared<const SolvedPatch>(SolvedPatch{std::move(solved), base});
  return {owner, &owner->patch};
}

std::vector<double> numbers_of(const std::vector<Vec3d>& forces) {
  std::vector<double> numbers;
  for (const Vec3d f : forces) numbers.insert(numbers.end(), {f.x, f.y, f.z});
  return numbers;
}

}  // namespace

void add_solution(LawSummary& sum, const sfem::NonlinearReport& report, double seconds) {
  add_solutions(sum, {.solutions = 1,
                      .unconverged = !report.converged,
                      .most_steps = report.steps,
                      .seconds = seconds,
                      .longest = seconds,
                      .strain = report.strain,
                      .border_strain = report.border_strain});
}

void add_solutions(LawSummary& sum, const LawSummary& more) {
  sum.solutions += more.solutions, sum.unconverged += more.unconverged;
  sum.most_steps = std::max(sum.most_steps, more.most_steps);
  sum.seconds += more.seconds, sum.longest = std::max(sum.longest, more.longest);
  sum.strain = std::max(sum.strain, more.strain);
  sum.border_strain = std::max(sum.border_strain, more.border_strain);
}

void LawSolver::add(LawBase base) {
  TURGOR_ASSERT(base.patch != nullptr, "a nonlinear patch was built");
  const std::lock_guard lock(mutex_);
  offered_.push_back(std::move(base));
}

Status LawSolver::start(contact::SfemExchange& exchange) {
  TURGOR_ASSERT(!thread_.joinable(), "a solver has one thread");
  Result<std::thread> started = start_thread("the nonlinear patch", [this, &exchange] { work(exchange); });
  if (!started) return started.error();
  thread_ = std::move(*started);
  return Done{};
}

void LawSolver::stop() {
  ends_ = true;
  if (thread_.joinable()) thread_.join();
}

LawProgress LawSolver::take_progress() {
  const std::lock_guard lock(mutex_);
  return std::exchange(progress_, {});
}

/// Patch of this number; null if it was not handed over. Patches before it are not used again.
LawBase* LawSolver::base_of(long number) {
  {
    const std::lock_guard lock(mutex_);
    for (LawBase& base : offered_) bases_.push_back(std::move(base));
    offered_.clear();
  }
  while (!bases_.empty() && bases_.front().number < number) bases_.pop_front();
  return !bases_.empty() && bases_.front().number == number ? &bases_.front() : nullptr;
}

std::optional<contact::PatchSolution> LawSolver::solve(const contact::LawForces& now) {
  LawBase* base = base_of(now.patch_number);
  if (base == nullptr) return {};
  // a solution that fails leaves the patch as it was, since no tick records it
  const Timer timer;
  sfem::NonlinearPatch& nonlinear = base->nonlinear;
  std::vector<double> before = nonlinear.u;
  const double largest_before = nonlinear.largest_force;
  nonlinear.law.stiffening = now.stiffening;
  sfem::NonlinearReport report;
  Result<sfem::Patch> solved = sfem::solve_nonlinear(nonlinear, numbers_of(now.force), kLawSteps, &report);
  if (!solved) nonlinear.u = std::move(before), nonlinear.largest_force = largest_before;
  // report
  {
    const std::lock_guard lock(mutex_);
    if (solved)
      add_solution(progress_.sum, report, timer.seconds());
    else if (progress_.failed++ == 0)
      progress_.failure = solved.error().message;
  }
  if (!solved) return {};
  // other threads must not free its memory
  std::erase_if(solutions_, [](const auto& kept) { return kept.use_count() == 1; });
  solutions_.push_back(shared_solution(std::move(*solved), base->patch));
  return contact::PatchSolution{solutions_.back(), base->number, now.ticks};
}

void LawSolver::work(contact::SfemExchange& exchange) {
  constexpr auto kPause = std::chrono::microseconds(250);
  long patch = -1;     // number of the patch that was solved last
  long published = 0;  // tick of the forces of its latest solution
  long begun = 0;      // tick of the forces of the latest attempt
  std::vector<Vec3d> forces;
  double stiffening = 0;  // of the law of the latest attempt
  while (!ends_) {
    const contact::LawForces& now = exchange.forces.read();
    if (now.patch_number != patch)
      patch = now.patch_number, published = 0, begun = now.ticks - kLawTicks, forces.clear();
    // ticks use the latest solution, and the forces or the law have changed since
    const bool is_due = now.solution_tick == published && now.ticks - begun >= kLawTicks;
    if (now.ticks == 0 || !is_due || (now.force == forces && now.stiffening == stiffening)) {
      std::this_thread::sleep_for(kPause);
      continue;
    }
    begun = now.ticks, forces = now.force, stiffening = now.stiffening;
    std::optional<contact::PatchSolution> solution = solve(now);
    if (!solution) continue;
    published = solution->tick;
    exchange.solutions.write(*solution);
  }
}

void ReplayedForces::push(const contact::LawForces& now) {
  const bool is_new = forces_.empty() || forces_.back().patch_number != now.patch_number ||
                      forces_.back().force != now.force || forces_.back().stiffening != now.stiffening;
  if (is_new) forces_.push_back(now);
}

const contact::LawForces* ReplayedForces::after(long tick) {
  while (forces_.size() > 1 && forces_[1].ticks <= tick) forces_.pop_front();
  return !forces_.empty() && forces_.front().ticks <= tick ? &forces_.front() : nullptr;
}

}  // namespace turgor
