#include "turgor/sim/smooth_snapshot.hpp"

#include "turgor/core/assert.hpp"

namespace turgor {

namespace {

/// Surface with the number of coarse triangles that it was made from.
struct KeptSurface {
  std::size_t from = 0;
  std::shared_ptr<const SmoothSurface> surface;
};

}  // namespace

std::shared_ptr<const SmoothSurface> smooth_for_drawing(std::span<const Int3> triangles, BodySnapshot& body) {
  const int levels = levels_for_drawing(triangles.size());
  if (levels == 0) {
    body.smooth = {};
    return nullptr;
  }
  const KeptSurface* kept = std::any_cast<KeptSurface>(&body.cache);
  if (!kept || kept->from != triangles.size())
    body.cache = KeptSurface{triangles.size(),
                             std::make_shared<const SmoothSurface>(loop_subdivision(triangles, levels))};
  return std::any_cast<KeptSurface>(&body.cache)->surface;
}

void place_smooth(const SmoothSurface& surface, std::span<const Vec3> rest, SmoothSnapshot& smooth) {
  TURGOR_CHECK(rest.size() == surface.size() && smooth.displacement.size() == rest.size(),
               "every smooth vertex has a displacement");
  smooth.x.resize(rest.size());
  for (std::size_t v = 0; v < rest.size(); v++) smooth.x[v] = rest[v] + smooth.displacement[v];
  smooth.triangles = surface.triangles;
  const TriMesh mesh{.vertices = smooth.x, .triangles = smooth.triangles, .normals = {}, .scalars = {}};
  smooth.normals = vertex_normals(mesh);
}

}  // namespace turgor
