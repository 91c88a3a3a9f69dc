// Deformed CT of a session's first lattice, cached until the body changes visibly.
#pragma once

#include <memory>

#include "turgor/core/exec.hpp"
#include "turgor/sim/deformed_ct.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

struct SessionCt {
  std::shared_ptr<const DeformedCt> ct;  // null: not yet computed for this world
  double motion = 0;                     // upper bound of the body's displacement since `ct` was computed [m]
  std::size_t cuts = 0;                  // cut version of `ct`
};

/// Computes the CT if the cached one is outdated or lacks a requested target. `max_samples` limits the
/// samples along an axis on the host. Does nothing in a world without lattices.
void update_ct(const Exec& exec, const World& world, CtTargets targets, int max_samples, SessionCt& cached);
/// Adds the largest displacement of the latest frame to `motion`.
void add_motion(const World& world, SessionCt& cached);

}  // namespace turgor
