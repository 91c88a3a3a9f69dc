// Sections of a CT in radiological convention: through any point, along the patient's axes even for oblique
// volumes, in gray values of a window, with orientation letters and a scale bar.
#pragma once

#include <cstdint>
#include <string>

#include "turgor/core/result.hpp"
#include "turgor/geometry/volume.hpp"
#include "turgor/io/files/image.hpp"

namespace turgor {

enum class Plane : std::uint8_t { kAxial, kCoronal, kSagittal };

/// Gray value window: black at level − width/2, white at level + width/2 [HU].
struct Window {
  double width = 350, level = 40;
};
/// "abdomen", "bone", "lung", "brain", "air".
Result<Window> window_preset(const std::string& name);

/// Gray value of a sample, 0 to 255.
std::uint8_t gray_value(double hu, Window window);

/// Pixel grid of a section: pixel (0, 0) is centered on `corner`; the next pixels right and below are `pixel`
/// away.
struct SectionFrame {
  Vec3d corner, right, down;  // [m], unit directions
  double pixel = 0;           // [m]
  int width = 0, height = 0;  // [pixels]
};
/// Frame of draw_section's pictures: the volume's bounding box. The patient's right is on the left; the front
/// is up in axial sections, the head up in the others, and the front on the left in sagittal ones.
SectionFrame section_frame(const Grid& grid, Plane plane, Vec3d point, int height);

/// Section through `point` in radiological convention, with orientation letters and a scale bar.
Image draw_section(const CtVolume& ct, Plane plane, Vec3d point, Window window, int height);

}  // namespace turgor
