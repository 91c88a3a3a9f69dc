// Stretch of skin around closed wounds: its map on a snapshot, and its largest value in reports.
#pragma once

#include <optional>
#include <vector>

#include "turgor/sim/report/json_numbers.hpp"
#include "turgor/sim/snapshot.hpp"

namespace turgor {

struct World;

/// Largest principal stretch of the skin at every vertex, relative to the CT [1]. Walls of wounds have 1.
/// Empty for bodies without skin.
std::vector<float> skin_stretches(const BodySnapshot& body);

/// The most stretched disc of a body's skin, of 5 mm radius in the CT.
struct SkinStretch {
  std::string body;
  double largest = 1;  // mean of the disc, relative to the CT [1]
  Vec3d now, rest;     // its center, and the same in the CT, patient frame [m]
};
/// Empty for bodies without skin.
std::optional<SkinStretch> largest_skin_stretch(const BodySnapshot& body);

/// The same of a lattice body now.
std::optional<SkinStretch> largest_skin_stretch(const Exec& exec, const World& world, int lattice_body);

/// A row for every lattice body with an excision or a suture.
Json skin_report(const Exec& exec, const World& world);

}  // namespace turgor
