// The deformed CT of a lattice as pictures show it: the body alone, here or on the GPU that it steps on.
#pragma once

#include <optional>

#include "turgor/sim/world.hpp"

namespace turgor {

/// Where somebody wants it.
struct CtWish {
  bool here = true;    // for sections
  bool there = false;  // at the CT's own resolution, for pictures that a GPU draws; here where that cannot be

  friend bool operator==(const CtWish&, const CtWish&) = default;
};

struct DeformedCt {
  int frame = 0;
  CtVolume ct;  // no samples where it is wanted there alone, and is there
  CtWish wish = {};
  std::optional<lattice::DeviceResampled> there = {};

  bool answers(CtWish other) const { return (wish.here || !other.here) && wish.there == other.there; }
};

/// `most`: samples along an axis, of what is here.
DeformedCt make_deformed_ct(const Exec& exec, const LatticeBody& body, int frame, CtWish wish, int most);

}  // namespace turgor
