// Frame of an sfem body: its ticks, then slower corrections.
#include <span>

#include <fmt/format.h>

#include "turgor/core/hash.hpp"
#include "turgor/sim/bodies/sfem/needle_sfem.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

Status begin_body(const Exec& exec, SfemBody& body, const SfemScene& scene, const World& world) {
  const Status status = begin_touch(exec, body, world.tools, scene.viscosity);
  if (const Status needles =
          status ? prepare_needles(exec, body, world.tools, scene.viscosity) : Status(Done{});
      !needles)
    return Error{fmt::format("{}: {}", scene.source_location, needles.error().message)};
  return status ? status : Error{fmt::format("{}.patch: {}", scene.source_location, status.error().message)};
}

void step_body(const Exec& exec, SfemBody& body, World& world, const FrameInput& input, FrameReport&) {
  if (body.haptic) return make_frame(exec, body, input.to, input.to - input.from, body.haptic->exchange);
  touch_body(exec, body, world.tools, input.from, input.to);
  follow_needles(exec, body);
  correct_rotations(exec, body);
}

std::uint64_t state_hash(const SfemBody& body, std::uint64_t seed) {
  seed = hash_values(std::span<const Vec3d>(body.now.x), seed);
  for (const std::vector<Vec3d>& forces : body.now.needle_forces)
    seed = hash_values(std::span<const Vec3d>(forces), seed);
  return hash_values(std::span<const Vec3d>(body.now.force), seed);
}

}  // namespace turgor
