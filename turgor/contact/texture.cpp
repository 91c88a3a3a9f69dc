#include "turgor/contact/texture.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "turgor/core/assert.hpp"

namespace turgor::contact {

namespace {

constexpr double kLeastTicks = 4, kFullTicks = 5;  // of a wave

/// Motion of a tool along the surface in a tick.
struct TextureSlide {
  Vec3d along;   // [m]
  double path;   // its length [m]
  Vec3d normal;  // of the surface
  double force;  // normal force [N]
  double dt;     // [s]
};

/// Share of the vibration that is rendered: it begins with the speed, and fades where a wave of this length
/// is short. Counts the wave's frequency.
double rendered_share(const TextureSlide& slide, double wave, TextureState& state, bool& limited) {
  const double waves = slide.path / wave;
  const double fade = std::clamp((1 / waves - kLeastTicks) / (kFullTicks - kLeastTicks), 0.0, 1.0);
  limited = fade < 1;
  state.largest_rate = std::max(state.largest_rate, waves / slide.dt);
  return std::min(1.0, slide.path / slide.dt / kTextureSpeed) * fade;
}

/// Moves the phase along a path that repeats after `length`.
void advance_phase(TextureState& state, double path, double length) {
  state.phase = std::fmod(state.phase + path / length, 1.0);
}

Vec3d wave_force(const Waves& waves, const TextureSlide& slide, TextureState& state) {
  TURGOR_CHECK(waves.wavelength > 0, "waves have a length");
  advance_phase(state, slide.path, waves.wavelength);
  // amplitude within its limits
  const double k = 2 * std::numbers::pi / waves.wavelength;
  const double free = slide.force * k * waves.roughness, stiff = texture_stiffness(slide.dt) / k;
  bool fades = false;
  const double amplitude = rendered_share(slide, waves.wavelength, state, fades) * std::min(free, stiff);
  state.limited_ticks += fades || free > stiff;
  state.largest_force = std::max(state.largest_force, amplitude);
  return slide.along * (-amplitude * std::cos(2 * std::numbers::pi * state.phase) / slide.path);
}

/// Slope of a map at the tool along the surface [1]. A profile follows the path. A map is projected along the
/// axis that is nearest to the normal.
Vec3d map_slope(const HeightMap& map, const TextureSlide& slide, TextureState& state) {
  if (map.rows == 1) {
    const double length = map.columns * map.spacing;
    advance_phase(state, slide.path, length);
    return slide.along * (sample_height(map, state.phase * length, 0).u / slide.path);
  }
  const Vec3d n = slide.normal, size{std::abs(n.x), std::abs(n.y), std::abs(n.z)};
  const int axis = size.x > std::max(size.y, size.z) ? 0 : size.y > size.z ? 1 : 2;
  const int first = (axis + 1) % 3, second = (axis + 2) % 3;
  const HeightSample s = sample_height(map, state.point[first], state.point[second]);
  Vec3d slope;
  slope[first] = s.u, slope[second] = s.v;
  return slope - dot(slope, n) * n;
}

Vec3d map_force(const HeightMap& map, const TextureSlide& slide, TextureState& state) {
  const Vec3d slope = map_slope(map, slide, state);
  // force within its limits
  const double stiff = map.curvature > 0 ? texture_stiffness(slide.dt) / map.curvature : slide.force;
  bool fades = false;
  const double share = rendered_share(slide, 2 * map.spacing, state, fades);
  const Vec3d force = slope * (-share * std::min(slide.force, stiff));
  state.limited_ticks += fades || slide.force > stiff;
  state.largest_force = std::max(state.largest_force, norm(force));
  return force;
}

}  // namespace

double texture_stiffness(double dt) {
  TURGOR_CHECK(dt > 0, "a tick takes time");
  // stiffness up to which hands perceive rendered textures as stable, at two rates of ticks
  constexpr double kSlowRate = 250, kFastRate = 4e4, kSlow = 325, kFast = 904;  // [Hz], [N/m]
  const double share = std::log(1 / (dt * kSlowRate)) / std::log(kFastRate / kSlowRate);
  return kSlow * std::pow(kFast / kSlow, std::clamp(share, 0.0, 1.0));
}

Vec3d texture_force(const Texture& texture, TextureState& state, const TextureContact& contact, double dt) {
  const bool touched = state.is_touching;
  const Vec3d motion = contact.point - state.point,
              along = motion - dot(motion, contact.normal) * contact.normal;
  state.point = contact.point, state.is_touching = contact.force > 0;
  const TextureSlide slide{along, norm(along), contact.normal, contact.force, dt};
  if (!is_rough(texture) || !touched || !state.is_touching || !contact.is_slip || dt <= 0 ||
      !(slide.path > 0))
    return {};
  return texture.map ? map_force(*texture.map, slide, state) : wave_force(texture.waves, slide, state);
}

}  // namespace turgor::contact
