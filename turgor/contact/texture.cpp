#include "turgor/contact/texture.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "turgor/core/assert.hpp"

namespace turgor::contact {

Vec3d texture_force(const Texture& texture, TextureState& state, Vec3d position, Vec3d normal, double force,
                    bool slides, double dt) {
  constexpr double kLeastTicks = 4, kFullTicks = 5;  // of a wave
  const Vec3d motion = position - state.position, along = motion - dot(motion, normal) * normal;
  const bool had_position = state.has_position;
  state.position = position, state.has_position = true;
  const double path = norm(along);
  if (texture.roughness <= 0 || !had_position || !slides || dt <= 0 || force <= 0 || !(path > 0)) return {};
  TURGOR_CHECK(texture.wavelength > 0, "waves have a length");
  // phase at the end of the tick
  const double waves = path / texture.wavelength;
  state.phase = std::fmod(state.phase + waves, 1.0);
  // amplitude within its limits
  const double k = 2 * std::numbers::pi / texture.wavelength;
  const double free = force * k * texture.roughness, stiff = kTextureStiffness / k;
  const double fade = std::clamp((1 / waves - kLeastTicks) / (kFullTicks - kLeastTicks), 0.0, 1.0);
  const double begin = std::min(1.0, path / dt / kTextureSpeed);
  const double amplitude = begin * fade * std::min(free, stiff);
  // statistics
  state.limited_ticks += fade < 1 || free > stiff;
  state.largest_force = std::max(state.largest_force, amplitude);
  state.largest_rate = std::max(state.largest_rate, waves / dt);
  return along * (-amplitude * std::cos(2 * std::numbers::pi * state.phase) / path);
}

}  // namespace turgor::contact
