// Lighting of all pictures: a warm key light above the viewer's left shoulder, a soft cool fill from the
// right, a rim light from behind, and ambient light from sky and floor. It moves with the camera.
#pragma once

#include "turgor/view/camera.hpp"

namespace turgor {

struct Lights {
  Vec3 key, fill, rim;                                            // unit, towards the light
  Vec3 up;                                                        // towards the sky
  Vec3 key_color, fill_color, rim_color, sky_color, floor_color;  // linear
};

inline Lights camera_lights(const CameraFrame& frame) {
  const auto towards = [&frame](double right, double up, double back) {
    return Vec3(normalized(frame.right * right + frame.up * up + frame.back * back));
  };
  return {.key = towards(-0.70, 0.75, 0.62),
          .fill = towards(0.85, -0.05, 0.55),
          .rim = towards(0.35, 0.55, -0.75),
          .up = Vec3(frame.up),
          .key_color = {1.08f, 1.03f, 0.96f},
          .fill_color = {0.19f, 0.21f, 0.25f},
          .rim_color = {0.30f, 0.33f, 0.38f},
          .sky_color = {0.27f, 0.28f, 0.30f},
          .floor_color = {0.14f, 0.12f, 0.11f}};
}

}  // namespace turgor
