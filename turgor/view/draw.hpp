// Pictures of meshes, CT volumes and sections, without a window. Meshes are drawn by OpenGL through EGL (no display, no X
// server); volumes by a threaded ray-caster on the CPU; everything lands in an Image. Patient frame LPS, metres.
#pragma once

#include <string>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/core/result.hpp"
#include "turgor/geometry/tri_mesh.hpp"
#include "turgor/geometry/volume.hpp"
#include "turgor/io/image.hpp"

namespace turgor {

struct Camera {
  Vec3d eye, target, up{0, 0, 1};
  double field_of_view = 30;  // vertical [degrees]
};

struct Box {
  Vec3d low, high;
};
Box bounding_box(const TriMesh& mesh);
Box bounding_box(const Grid& grid);
/// A camera that sees the whole box from `direction` (from the box towards the eye).
Camera frame_box(const Box& box, Vec3d direction, Vec3d up, double aspect);

/// Scalars to colours: `low` and `high` map to the ends of a perceptually even map.
struct ColorScale {
  float low = 0, high = 1;
  std::string label;  // for the legend, with unit: "displacement [mm]"
  float factor = 1;   // scalar · factor = the number the legend shows
};

struct MeshPart {
  const TriMesh* mesh = nullptr;
  Rgb color{224, 172, 145};          // where there is no scale
  const ColorScale* scale = nullptr;  // colour by mesh->scalars, with a legend
};

/// Error: OpenGL or EGL is missing on this machine, or failed; the message says which call.
Result<Image> draw_meshes(const std::vector<MeshPart>& parts, const Camera& camera, int width, int height);

/// Tissue presets of volume rendering: "skin", "soft tissue", "muscle", "bone", "lung".
std::vector<std::string> volume_presets();
Image draw_volume(const Exec& exec, const CtVolume& ct, const std::string& preset, const Camera& camera, int width,
                  int height);

enum class Plane : std::uint8_t { kAxial, kCoronal, kSagittal };
/// Window of grey values: black at level − width/2, white at level + width/2 [HU].
struct Window {
  double width = 350, level = 40;
};
/// "abdomen", "bone", "lung", "brain", "air".
Result<Window> window_preset(const std::string& name);
/// The section through `point` as a radiologist sees it (patient's right on the left, front up in axial sections, head up
/// in the others), with orientation letters and a scale bar.
Image draw_section(const CtVolume& ct, Plane plane, Vec3d point, Window window, int height);

/// Several pictures in a row, each with a caption above.
Image side_by_side(const std::vector<Image>& images, const std::vector<std::string>& captions);

}  // namespace turgor
