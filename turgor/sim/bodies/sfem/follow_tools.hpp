// The patch of a body follows its tools: wanted when a touch has wandered, built on a thread of its own while
// ticks go on with the present one, and taken between two of them. Where the frame ticks itself, that is at a
// tick that is fixed in advance, so that the same path gives the same bits however long the building takes;
// where a haptic thread does, when it is ready.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/core/latest.hpp"
#include "turgor/sim/bodies/sfem/sfem_body.hpp"

namespace turgor {

/// Ticks from when a patch is wanted until it is taken; fewer when a frame has no more.
constexpr long kPatchTicks = 3;

/// A patch that is being built. Refers to the body.
struct NextPatch {
  std::vector<Vec3d> centers;  // where it is built for [m]
  long due = 0;                // the tick that takes it
};

/// A patch where the tools are at the start; it is there before the first tick. Error: see sfem::build_patch.
Result<std::shared_ptr<const sfem::Patch>> first_patch(const Exec& exec, SfemBody& body);

/// Begins to build a patch, to be taken at tick `due`, when a touch has wandered. Commands: of this tick.
std::optional<NextPatch> follow_tools(const Exec& exec, SfemBody& body,
                                      std::span<const contact::ToolCommand> commands, long due);
/// Puts it in place of the present one, and notes what it cost and by how much the force jumps. False when it
/// could not be built, which is noted: the present one stays, and another is tried for when the touch has
/// wandered on.
bool take_next_patch(SfemBody& body, NextPatch& next, double time);

/// The same while a haptic thread ticks, once a frame and after take_touched: begins to build, or offers what
/// is built; never waits for it. The haptic thread reads `offers` and calls contact::take_patch for numbers
/// that it has not seen.
void offer_patch(const Exec& exec, SfemBody& body, double time, latest<contact::PatchOffer>& offers);

}  // namespace turgor
