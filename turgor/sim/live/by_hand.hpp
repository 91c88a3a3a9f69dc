// Cuts and stitches by a program, between two frames of a running world. They are requests (requests.hpp)
// with the limits of a scene, and name wounds and stitches as the report does. The interfaces for C and
// Python use them.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/core/result.hpp"
#include "turgor/sim/scene/scene.hpp"

namespace turgor {

struct World;

/// Cut along points on or near the present skin: a straight line, or a smooth curve through more than two.
struct CutByHand {
  BodyId body;
  std::string name;           // of the wound; empty: the first of hand-1, hand-2, … that is free
  std::vector<Vec3d> points;  // patient frame [m]
  double depth = 0.01;        // below the skin [m]
  double tilt = 0;            // lattice::Incision::tilt [degrees]
  double duration = 0.2;      // of the blade's motion; 0 = instantaneous [s]
};

/// Single stitch through a wound (StitchRequest).
struct StitchByHand {
  BodyId body;
  std::string wound;                 // name; empty: the nearest one that the stitch crosses
  std::vector<Vec3d> points;         // in the CT in the order of the thread, patient frame [m]
  std::string thread = "nylon 3-0";  // name of its preset
  std::optional<double> tension;     // at which it is knotted [N]; empty: when the lips meet under it
  double duration = 0.5;             // of the pull [s]
};

/// Starts a cut in the frame that is computed next, and returns the name of its wound. On error the world is
/// unchanged. Errors: a body that is no lattice, a name that is taken, numbers out of range, no skin.
Result<std::string> cut_by_hand(const Exec& exec, const CutByHand& cut, std::shared_ptr<const Scene>& scene,
                                World& world);

/// Lays a stitch in the frame that is computed next, and returns its name. Errors: a body that is no lattice,
/// and those of StitchRequest.
Result<std::string> stitch_by_hand(const Exec& exec, const StitchByHand& stitch,
                                   std::shared_ptr<const Scene>& scene, World& world);

/// Pulls a stitch by hand to a tension [N], or without one until the lips meet, during a time [s].
Status tighten_by_hand(const Exec& exec, const std::string& stitch, std::optional<double> tension,
                       double duration, std::shared_ptr<const Scene>& scene, World& world);

}  // namespace turgor
