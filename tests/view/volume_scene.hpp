// A small CT with visible tissue for every preset, and cameras around it.
#pragma once

#include <cmath>

#include "tests/view/shapes.hpp"
#include "turgor/view/camera.hpp"

namespace turgor::test {

constexpr int kWidth = 150, kHeight = 110;

/// Skin, flesh, bone and a lung in oblique axes, with texture.
inline CtVolume layered_ct(Int3 size) {
  const Vec3d spacing{0.0012, 0.001, 0.0015}, half = hadamard(Vec3d(size), spacing) * 0.5;
  CtVolume ct = fill_volume(centered_grid(size, spacing, {}, oblique_axes()), [&](Vec3d x) {
    const Vec3d at{x.x / half.x, x.y / half.y, x.z / half.z};
    const double r = norm(at) + 0.05 * std::sin(9 * at.x) * std::cos(11 * at.y);
    if (norm(at - Vec3d{0.3, 0, 0}) < 0.3) return -830.0;
    return r > 0.85 ? -1000.0 : r > 0.75 ? -100.0 : r > 0.5 || at.z > 0 ? 60.0 : 700.0;
  });
  for (std::size_t n = 0; n < ct.samples.size(); n++)
    ct.samples[n] = std::int16_t(ct.samples[n] + int(n * 7919 % 31));
  return ct;
}

inline Camera camera_around(int turn) {
  return turn == 0 ? Camera{.eye = {0.02, -0.2, 0.1}, .target = {}}
                   : Camera{.eye = {0.15, 0.05, -0.1}, .target = {0, 0.01, 0}};
}

}  // namespace turgor::test
