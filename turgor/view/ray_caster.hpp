// The light that comes along one ray through a CT, from behind to the eye. Everything is prepared once a
// picture; a caster is then shared by all threads.
#pragma once

#include "turgor/view/camera.hpp"
#include "turgor/view/lights.hpp"
#include "turgor/view/opacity_blocks.hpp"
#include "turgor/view/transfer.hpp"

namespace turgor {

/// A ray inside the volume.
struct Ray {
  Vec3 start, step;   // index; per step
  Vec3 direction;     // unit, patient frame
  Vec3 entry_normal;  // of the volume's face where the ray comes in, patient frame
  int last = -1;      // steps to take; < 0: misses the volume
};

/// A few steps along a ray, from the value `before` to the value `here`.
struct Segment {
  int end = 0, steps = 1;      // it ends at this step of the ray
  float before = 0, here = 0;  // [HU]
};

/// What rays need. Volumes one sample thick cannot be seen.
struct RayCaster {
  const CtVolume& ct;
  const CtVolume& smooth;
  const Transfer& transfer;
  const OpacityBlocks& blocks;
  Lights lights;
  CameraFrame frame;
  Mat3d to_index;  // index per metre
  Mat3d gradient_to_patient;
  Vec3d eye;             // index
  float step;            // [m]
  float noise_gradient;  // [HU/m]
  int width, height;

  /// Linear light at a place of the picture, in pixels from the top left.
  Vec3 pixel(float x, float y) const;

 private:
  Ray make_ray(float x, float y) const;
  Vec3 gradient(Vec3 index) const;
  Vec3 lit(Vec3 color, Vec3 index, const Ray& ray, bool at_entry) const;
  Vec3 cloud(Vec3 color) const;
  float openness(Vec3 index, Vec3 normal) const;
  float surface_place(float before, float here, int steps) const;
  std::size_t block_at(Vec3 index) const;
  Vec3 segment_light(const Ray& ray, const Segment& segment, const Optical& optical, float alpha) const;
  int leap(const Ray& ray, Vec3 index, int distance) const;
};

/// The CT, `smooth` (smooth_half), the transfer function and the blocks must outlive the caster.
RayCaster make_ray_caster(const CtVolume& ct, const CtVolume& smooth, const Transfer& transfer,
                          const OpacityBlocks& blocks, const Camera& camera, int width, int height);

}  // namespace turgor
