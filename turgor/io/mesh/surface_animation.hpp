// Surfaces over time, and their files for programs of animation, rendering and games: USD as text (.usda) and
// glTF 2.0 in one binary file (.glb). Both files hold every sample of every surface, in meters and in the
// patient frame LPS (z to the head).
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "turgor/core/result.hpp"
#include "turgor/geometry/tri_mesh.hpp"

namespace turgor {

/// Shape of a surface at one time.
struct ShapeSample {
  std::vector<Vec3> points;       // [m]; empty: the surface does not exist at that time
  std::vector<Vec3> normals;      // unit, outward; one a point, or none
  std::size_t triangulation = 0;  // index into AnimatedSurface::triangulations
};

/// Appearance of a surface.
struct SurfaceLook {
  Vec3 color{0.5f, 0.5f, 0.5f};  // linear light, 0 … 1
  float opacity = 1;
  bool two_sided = false;
};

struct AnimatedSurface {
  std::string name;
  SurfaceLook look;
  std::vector<std::vector<Int3>>
      triangulations;  // a new one when triangles, the number of points or colors change
  std::vector<std::vector<Vec3>>
      colors;                        // of each triangulation's points, as the look's; empty: that of the look
  std::vector<ShapeSample> samples;  // one a time
};

struct SurfaceAnimation {
  double frame_rate = 60;     // of the simulation [1/s]
  std::vector<double> times;  // of the samples, ascending [s]
  std::vector<AnimatedSurface> surfaces;
};

/// Appends the present shape to a surface. `colors`: of its points, or none.
void add_sample(TriMesh mesh, AnimatedSurface& surface, std::vector<Vec3> colors = {});
/// True if a triangulation has colors of its own.
bool has_point_colors(const AnimatedSurface& surface);
/// Colors of a triangulation's points, also where all have that of the look.
std::vector<Vec3> point_colors(const AnimatedSurface& surface, const ShapeSample& sample);

/// Names of the surfaces as identifiers of USD: letters, digits and underscores, each name once.
std::vector<std::string> usd_names(const SurfaceAnimation& animation);

/// Writes USD as text: a Mesh with time samples and a material for every surface. Time codes are frames of
/// the simulation; triangles have a time sample where they change.
/// [OpenUSD, https://openusd.org/release/api/usd_geom_page_front.html]
Status write_usda(const std::filesystem::path& path, const SurfaceAnimation& animation);

/// Largest number of samples in a glTF file, whose size grows with its square.
constexpr std::size_t kMostGltfSamples = 1000;

/// Largest size of a .glb, whose lengths have 32 bits [bytes].
constexpr std::uint64_t kMostGlbBytes = 0xffffffff;

/// Size of the binary chunk of a .glb with these samples [bytes].
std::uint64_t glb_bytes(const SurfaceAnimation& animation);
/// Error: more than kMostGltfSamples times, or a binary chunk of more than `most_bytes`. It names no file.
Status check_glb(const SurfaceAnimation& animation, std::uint64_t most_bytes = kMostGlbBytes);

/// Writes glTF 2.0: samples are morph targets, whose weights are animated. Where triangles change, another
/// mesh takes over: the scale of its node is 0 at all other times. The root node turns z up to glTF's y up.
/// Error: as check_glb, or a file of more than `most_bytes`. [Khronos, glTF 2.0 specification]
Status write_glb(const std::filesystem::path& path, const SurfaceAnimation& animation,
                 std::uint64_t most_bytes = kMostGlbBytes);

}  // namespace turgor
