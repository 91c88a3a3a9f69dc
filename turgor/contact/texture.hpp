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
// A map of heights h(u, v) replaces the waves by f = −N ∇h at the spot of the surface that the tool touches.
// On a plane this force is conservative: for a constant N it returns no more than N times the range of
// heights.
#pragma once

#include <memory>

#include "turgor/contact/height_map.hpp"
#include "turgor/core/vec.hpp"

namespace turgor::contact {

/// Waves or a map of heights of a surface; neither = smooth.
struct Texture {
  double roughness = 0;                       // height a of the waves above the mean plane; 0 = none [m]
  double wavelength = 1e-3;                   // [m]
  std::shared_ptr<const HeightMap> map = {};  // null = none
};
inline bool is_rough(const Texture& texture) { return texture.roughness > 0 || texture.map != nullptr; }

/// Largest stiffness of the vibration along the path at ticks of `dt` seconds [N/m]: 430 at 1 kHz.
///   325 N/m (1/(250 Hz · dt))^0.2015, between 325 N/m at 250 Hz and 904 N/m at 40 kHz [Choi, Tan 2004]
/// Colgate's bound is then kept by a damping of 0.22 N·s/m at 1 kHz, less than that of a hand with a device.
double texture_stiffness(double dt);
/// Sliding speed from which the vibration is whole; it begins at 0 with the speed [m/s].
constexpr double kTextureSpeed = 1e-3;

/// State of one tool on a textured surface, and its statistics.
struct TextureState {
  Vec3d position;  // of the tool in the last tick [m]
  bool has_position = false;
  double phase = 0;          // slid path over the wavelength or the length of a profile, 0 … 1 [1]
  Vec3d spot;                // of the surface at rest that a map has under the tool [m]
  double largest_force = 0;  // [N]
  double largest_rate = 0;   // frequency; with a map that of its finest wave, two spacings [Hz]
  long limited_ticks = 0;    // ticks in which the stiffness or the tick limited the vibration
};

/// Force on the tool in a tick of `dt` seconds [N]. `normal`: unit normal of the surface; `force`: normal
/// force N. Zero if the tool does not slide.
Vec3d texture_force(const Texture& texture, TextureState& state, Vec3d position, Vec3d normal, double force,
                    bool slides, double dt);

}  // namespace turgor::contact
