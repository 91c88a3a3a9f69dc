// Loads an sfem body: shape from a file, a surface, a segmentation or a block; Green's functions from the
// cache or computed; tools on their paths.
#pragma once

#include <string>
#include <vector>

#include "turgor/core/result.hpp"
#include "turgor/sim/bodies/sfem/sfem_body.hpp"
#include "turgor/sim/loading.hpp"

namespace turgor {

/// Body without tools. Error: has the source location or the file.
Result<SfemBody> load_body(const Loading& loading, const SfemScene& scene, const World& world);
inline const std::vector<std::string>& notes(const SfemBody& body) { return body.facts.notes; }

/// Surface for contact.
RestSurface rest_surface(const SfemBody& body);
inline void make_rest_surface(const Exec&, SfemBody&) {}  // exists already
/// Error: see begin_touch; the message has the source location.
Status begin_body(const Exec& exec, SfemBody& body, const SfemScene& scene, const World& world);

/// Runs the ticks of a frame, then corrects large rotations.
void step_body(const Exec& exec, SfemBody& body, World& world, const FrameInput& input, FrameReport& report);
std::uint64_t state_hash(const SfemBody& body, std::uint64_t seed);

/// State of tool `t` of tool_indices.
inline ToolNow tool_now(const SfemBody& body, std::size_t t, const World&) {
  return {body.now.poses[t].pose, body.now.forces[t].force, 0};
}
inline Look look_of(const SfemBody&) { return Look::kFlesh; }
/// Coarse surface joined with the patch, or the finer surface of the scene.
void show(const Exec& exec, const SfemBody& body, BodySnapshot& out);

}  // namespace turgor
