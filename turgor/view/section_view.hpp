// Sections of a CT as a radiologist reads them: through any point, across the patient's own axes even when
// the volume lies oblique, in grey values of a window, with orientation letters and a scale bar.
#pragma once

#include <cstdint>
#include <string>

#include "turgor/core/result.hpp"
#include "turgor/geometry/volume.hpp"
#include "turgor/io/files/image.hpp"

namespace turgor {

enum class Plane : std::uint8_t { kAxial, kCoronal, kSagittal };

/// Window of grey values: black at level − width/2, white at level + width/2 [HU].
struct Window {
  double width = 350, level = 40;
};
/// "abdomen", "bone", "lung", "brain", "air".
Result<Window> window_preset(const std::string& name);

/// Where a section's pixels lie: pixel (0, 0) is centred on `corner`, the next ones right and below are
/// `pixel` away.
struct SectionFrame {
  Vec3d corner, right, down;  // [m], unit directions
  double pixel = 0;           // [m]
  int width = 0, height = 0;  // [pixels]
};
/// The frame of draw_section's pictures: the volume's bounding box, the patient's right on the left and the
/// front up in axial sections, the head up in the others, the front on the left in sagittal ones.
SectionFrame section_frame(const Grid& grid, Plane plane, Vec3d point, int height);

/// The section through `point` as a radiologist sees it, with orientation letters and a scale bar.
Image draw_section(const CtVolume& ct, Plane plane, Vec3d point, Window window, int height);

}  // namespace turgor
