// Depth of nodes that are found inside another body: they are pushed out slowly.
#pragma once

#include <span>

#include "turgor/contact/coupling.hpp"

namespace turgor::contact {

/// Permits the depth of nodes that were no sites in the last frame and are inside the other body now, and
/// lowers it by 1/e in 0.2 s. Nodes near a corner become sites where bodies turn so that their normals begin
/// to face each other. Pushed out within a frame, such a node would give its body energy from nowhere.
/// `last`: sites of the last frame; both ascend by node. `dt`: length of the frame [s].
void permit_depth(std::span<const PairSite> last, double dt, std::span<PairSite> sites);

}  // namespace turgor::contact
