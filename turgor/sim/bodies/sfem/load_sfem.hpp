// From a scene to a body that can be touched: its shape from a file, a surface, a segmentation or a block;
// its Green's functions from the cache or computed; its tools on their paths.
#pragma once

#include <string>
#include <vector>

#include "turgor/core/result.hpp"
#include "turgor/sim/bodies/sfem/sfem_body.hpp"
#include "turgor/sim/loading.hpp"

namespace turgor {

/// Without its tools. Error: names the scene's place, or the file.
Result<SfemBody> load_body(const Loading& loading, const SfemScene& scene, const World& world);
inline const std::vector<std::string>& notes(const SfemBody& body) { return body.facts.notes; }

/// The surface that tools touch.
RestSurface rest_surface(const SfemBody& body);
inline void make_rest_surface(SfemBody&) {}  // it is there
/// Error: see begin_touch; names the scene's place.
Status begin_body(const Exec& exec, SfemBody& body, const SfemScene& scene, const World& world);

/// The ticks of a frame, and large rotations after them.
void step_body(const Exec& exec, SfemBody& body, World& world, const FrameInput& input, FrameReport& report);
std::uint64_t state_hash(const SfemBody& body, std::uint64_t seed);

/// Tool `t` of its tool_indices.
inline ToolNow tool_now(const SfemBody& body, std::size_t t, const World&) {
  return {body.now.poses[t].pose, body.now.forces[t].force, 0};
}
inline Look look_of(const SfemBody&) { return Look::kFlesh; }
/// The coarse surface with the patch in it, or the finer one that the scene names.
void show(const Exec& exec, const SfemBody& body, BodySnapshot& out);

}  // namespace turgor
