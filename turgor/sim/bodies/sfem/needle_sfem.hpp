// Needles of an sfem body: the Green's functions around their paths, and their displacement of the whole
// body, once a frame.
#pragma once

#include <vector>

#include "turgor/core/result.hpp"
#include "turgor/sim/bodies/sfem/sfem_body.hpp"

namespace turgor {

/// Solves Green's functions between the vertices around all needles' paths, and gives the touch its needles.
/// Factorizes the body. Error: they exceed SfemBody::patch_memory, or the body is viscous.
Status prepare_needles(const Exec& exec, SfemBody& body, const std::vector<TouchingTool>& tools,
                       const Prony& viscosity);

/// Solves Green's functions around needles that a hand has moved away from their paths, or the body from
/// below them. The haptic thread takes them with the next motion.
void follow_needles(const Exec& exec, SfemBody& body);

/// After reading a state: solves Green's functions whose elements are known only.
void restore_needles(const Exec& exec, SfemBody& body);

/// Displacement of the whole body by its needles, and the motion of the vertices around each of them by
/// everything else.
void displace_by_needles(SfemBody& body);

}  // namespace turgor
