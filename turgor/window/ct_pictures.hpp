// The CT as it would be scanned now, in a window: ray-cast by threads of its own, coarsely while the camera
// or the body moves and finely at rest, or by the GPU that the body steps on, finely; and in three sections
// through a point.
#pragma once

#include <future>
#include <memory>
#include <optional>

#include "turgor/core/exec.hpp"
#include "turgor/pictures/deformed_volume.hpp"
#include "turgor/sim/live/session.hpp"
#include "turgor/view/camera.hpp"
#include "turgor/view/gl.hpp"
#include "turgor/view/section_view.hpp"

namespace turgor {

/// What a volume rendering shows; another one needs another picture.
struct VolumeWish {
  std::shared_ptr<const DeformedCt> ct;
  std::string preset;
  Camera camera;
  int width = 0, height = 0;  // [pixels]
  bool operator==(const VolumeWish& other) const {
    return ct == other.ct && preset == other.preset && camera.eye == other.camera.eye &&
           camera.target == other.camera.target && width == other.width && height == other.height;
  }
};

/// An image in a texture.
struct ShownImage {
  GlObjects objects;
  GLuint texture = 0, framebuffer = 0;
  int width = 0, height = 0;
  void show(const Image& image);
};

/// Is freed while its context is current; waits for the picture that is being made.
struct VolumePicture {
  Exec exec;
  VolumeWish wish, made;  // what is being made, and what the image shows
  int coarseness = 4;     // of what is being made: pixels a ray
  int shown_coarseness = 0;
  DevicePictures pictures;
  std::future<Result<Image>> coming;
  ShownImage image;
};
/// Never waits: takes a picture that is ready, and begins the next one. Error: a GPU has no room for it.
Status renew(const VolumeWish& wish, VolumePicture& picture);

/// Axial, coronal, sagittal.
struct Sections {
  std::shared_ptr<const DeformedCt> ct;
  Vec3d point;
  std::string window;
  ShownImage images[3];
};
/// Draws them anew when something is another.
void renew(const std::shared_ptr<const DeformedCt>& ct, Vec3d point, const std::string& window,
           Sections& sections);

}  // namespace turgor
