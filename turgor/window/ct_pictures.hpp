// The deformed CT in a window. Volume rendering runs on its own threads, coarse during motion and fine at
// rest, or always fine on the body's GPU. Three sections through a point complete it.
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

/// Parameters of a volume rendering; a change requires a new picture.
struct VolumeRequest {
  std::shared_ptr<const DeformedCt> ct;
  std::string preset;
  Camera camera;
  int width = 0, height = 0;  // [pixels]
  bool operator==(const VolumeRequest& other) const {
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

/// Freed while its context is current; the destructor waits for a picture in progress.
struct VolumePicture {
  Exec exec;
  VolumeRequest request, made;  // request in progress, and request of the shown image
  int coarseness = 4;           // of the picture in progress: pixels per ray
  int shown_coarseness = 0;
  DevicePictures pictures;
  std::future<Result<Image>> coming;
  ShownImage image;
};
/// Never blocks: shows a finished picture and starts the next one. Error: GPU memory is short.
Status renew(const VolumeRequest& request, VolumePicture& picture);

/// Axial, coronal, sagittal.
struct Sections {
  std::shared_ptr<const DeformedCt> ct;
  Vec3d point;
  std::string window;
  ShownImage images[3];
};
/// Draws the sections again if their input changed.
void renew(const std::shared_ptr<const DeformedCt>& ct, Vec3d point, const std::string& window,
           Sections& sections);

}  // namespace turgor
