// Pictures of triangle meshes by OpenGL through EGL: no window, no display, no X server; with or without a
// GPU.
#pragma once

#include <vector>

#include "turgor/core/result.hpp"
#include "turgor/geometry/tri_mesh.hpp"
#include "turgor/io/files/image.hpp"
#include "turgor/view/camera.hpp"
#include "turgor/view/color.hpp"

namespace turgor {

/// kFull: lit at every pixel, with shadows, dark hollows and smooth edges. kQuick: one pass, lit at the
/// vertices; for pictures that move where no GPU draws.
enum class MeshCare : std::uint8_t { kFull, kQuick };

struct MeshPart {
  const TriMesh* mesh = nullptr;
  Rgb color{224, 172, 145};                  // where there is no scale
  const ColorScale* scale = nullptr;         // colour by mesh->scalars, with a legend
  const std::vector<Rgb>* colors = nullptr;  // one a vertex, instead of `color`
  bool through = false;                      // paler, but seen also through what lies before it
  bool closed = false;  // triangles are counter-clockwise seen from outside, and nobody looks at their backs
};

/// Both sides of every triangle are seen; normals are computed where the mesh has none; scalars that are no
/// numbers show the part's colour. Error: OpenGL or EGL is missing on this machine, or failed; the message
/// says which call.
Result<Image> draw_meshes(const std::vector<MeshPart>& parts, const Camera& camera, int width, int height,
                          MeshCare care = MeshCare::kFull);

}  // namespace turgor
