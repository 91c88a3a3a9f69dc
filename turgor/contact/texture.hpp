// Vibration of a tool that slides over a rough surface. The surface is a plane with waves of height
// h(s) = a sin(2π s/λ) along the slid path s. A frictionless contact that carries the normal force N on the
// slope h' is pushed along the path by −N h' (the gradient force of [Minsky 1995]; [Ho, Basdogan, Srinivasan
// 1999]):
//
//   f = −N (2π a/λ) cos(2π s/λ) t        t: unit direction of sliding
//
// The tool feels the frequency v/λ with an amplitude of 2π N a/λ. A sampled spring of stiffness K needs a
// damping above K T/2 to be passive [Colgate, Brown 1994], and rendered textures are perceived as stable up
// to a stiffness that grows with the rate of ticks [Choi, Tan 2004]. The steepest change of f along the path,
// N (2π/λ)² a, is such a stiffness, and therefore limited. Less than four ticks a wave fade the vibration.
//
// A map of heights h(u, v) replaces the waves by f = −N ∇h at the point of the surface that the tool touches.
// On a plane this force is conservative: for a constant N it returns no more than N times the range of
// heights.
//
// s is a path over the material: a surface that moves or deforms with the tool adds nothing to it. Each model
// gives the point of its surface at rest that a tool touches:
//
//   rhombus               foot of the tool on the surface at rest                       (rhombus_touch.cpp)
//   sfem                  sum of the tool's motion less that of the body under it       (sfem_touch.cpp)
//   lattice, cloth, rigid sum of the slip of the proxy on the contact planes of frames  (local_contact.cpp)
#pragma once

#include <memory>

#include "turgor/contact/height_map.hpp"
#include "turgor/core/vec.hpp"

namespace turgor::contact {

/// Waves of a surface.
struct Waves {
  double roughness = 0;      // height a above the mean plane; 0 = none [m]
  double wavelength = 1e-3;  // [m]

  bool operator==(const Waves&) const = default;
};

/// Waves or a map of heights of a surface; neither = smooth.
struct Texture {
  Waves waves;
  std::shared_ptr<const HeightMap> map = {};  // null = none
};
inline bool is_rough(const Texture& texture) { return texture.waves.roughness > 0 || texture.map != nullptr; }

/// Largest stiffness of the vibration along the path at ticks of `dt` seconds [N/m]: 430 at 1 kHz.
///   325 N/m (1/(250 Hz · dt))^0.2015, between 325 N/m at 250 Hz and 904 N/m at 40 kHz [Choi, Tan 2004]
/// Colgate's bound is then kept by a damping of 0.22 N·s/m at 1 kHz, less than that of a hand with a device.
double texture_stiffness(double dt);
/// Sliding speed from which the vibration is whole; it begins at 0 with the speed [m/s].
constexpr double kTextureSpeed = 1e-3;

/// Contact of a tool with a textured surface in a tick.
struct TextureContact {
  Vec3d point;           // of the surface at rest that the tool touches [m]
  Vec3d normal;          // unit, of the surface
  double force = 0;      // normal force N [N]
  bool is_slip = false;  // false: the surface sticks to the tool or is held
};

/// State of one tool on a textured surface, and its statistics.
struct TextureState {
  Vec3d point;               // of the latest contact [m]
  bool is_touching = false;  // in the last tick
  double phase = 0;          // slid path over the wavelength or the length of a profile, 0 … 1 [1]
  double largest_force = 0;  // [N]
  double largest_rate = 0;   // frequency; with a map that of its finest wave, two spacings [Hz]
  long limited_ticks = 0;    // ticks in which the stiffness or the tick limited the vibration
};

/// Force on the tool in a tick of `dt` seconds [N]. Zero if the tool does not slide.
Vec3d texture_force(const Texture& texture, TextureState& state, const TextureContact& contact, double dt);

/// Touched point of a tool that slid over the material in a tick. `start`: point of a contact that begins
/// [m].
inline Vec3d slid_point(const TextureState& state, Vec3d start, Vec3d slid) {
  return state.is_touching ? state.point + slid : start;
}

}  // namespace turgor::contact
