// Deformed CT of a lattice for pictures: the body without its surroundings, in host memory or on the GPU on
// which the body steps.
#pragma once

#include <optional>

#include "turgor/sim/world.hpp"

namespace turgor {

/// Memories that shall hold the deformed CT.
struct CtTargets {
  bool host = true;     // for sections
  bool device = false;  // in the CT's own resolution, for pictures drawn on a GPU; without a GPU on the host

  friend bool operator==(const CtTargets&, const CtTargets&) = default;
};

struct DeformedCt {
  int frame = 0;
  CtVolume ct;  // without samples if only the device holds them
  CtTargets targets = {};
  std::optional<lattice::DeviceResampled> device = {};

  bool covers(CtTargets other) const {
    return (targets.host || !other.host) && targets.device == other.device;
  }
};

/// `max_samples`: limit of the host's samples along an axis.
DeformedCt make_deformed_ct(const Exec& exec, const LatticeBody& body, int frame, CtTargets targets,
                            int max_samples);

}  // namespace turgor
