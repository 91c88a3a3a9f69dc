// Patches that follow the tools of a body. When the contact has moved far enough, a new patch is built on its
// own thread while ticks use the present one; it is exchanged between two ticks. If the frame thread ticks,
// the exchange happens at a fixed tick, so that results do not depend on build time. If a haptic thread
// ticks, the patch is taken as soon as it is ready.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/core/latest.hpp"
#include "turgor/sim/bodies/sfem/sfem_body.hpp"

namespace turgor {

/// Ticks between the request of a patch and its use; fewer at the end of a frame.
constexpr long kPatchTicks = 3;

/// A patch under construction. It refers to the body.
struct NextPatch {
  std::vector<Vec3d> centers;  // contact positions that it covers [m]
  long due = 0;                // tick of its first use
};

/// Patch at the initial tool positions, before the first tick. Error: see sfem::build_patch.
Result<std::shared_ptr<const sfem::Patch>> first_patch(const Exec& exec, SfemBody& body);

/// Starts building a patch for tick `due` if the contact has moved far enough. `commands`: of this tick.
std::optional<NextPatch> follow_tools(const Exec& exec, SfemBody& body,
                                      std::span<const contact::ToolCommand> commands, long due);
/// Starts solving the nonlinear patch for the present forces, to be used from tick `due` on. None without a
/// law, while the forces are those of the latest solution, or where that is less than kLawTicks ago.
std::optional<NextPatch> solve_law(SfemBody& body, long due);

/// Replaces the present patch, and records cost and force jump. False if building failed: the present patch
/// stays, and another is tried when the contact has moved on.
bool take_next_patch(SfemBody& body, NextPatch& next, double time);

/// Makes the nonlinear patch of the patch in use again, after a state was read from a file.
void restore_nonlinear(SfemBody& body, const sfem::Patch& patch);
/// Counts a patch that could not be built or solved.
void reject_patch(SfemBody& body, const Error& why);
/// Keeps a patch until no other thread has it, and releases those that none has: the haptic thread must not
/// free memory.
void retain_patch(std::vector<std::shared_ptr<const sfem::Patch>>& patches,
                  const std::shared_ptr<const sfem::Patch>& patch);

/// The same for a haptic thread, once per frame after read_touch_snapshot: starts building, or offers a
/// finished patch, without waiting. The haptic thread reads `offers` and calls contact::take_patch for new
/// numbers.
void offer_patch(const Exec& exec, SfemBody& body, double time, latest<contact::FinishedPatch>& offers);

}  // namespace turgor
