#include "turgor/sim/smooth_snapshot.hpp"

#include <algorithm>
#include <memory>

#include "turgor/contact/sites.hpp"
#include "turgor/core/assert.hpp"

namespace turgor {

namespace {

/// Subdivision with the number of coarse triangles that it was made from, and its levels.
struct KeptSurface {
  std::size_t from = 0;
  int levels = 0;
  std::shared_ptr<const SmoothSurface> surface;
};

/// Null for a mesh that is drawn as it is.
std::shared_ptr<const SmoothSurface> subdivision_of(std::span<const Int3> triangles, std::size_t most,
                                                    BodySnapshot& body) {
  const int levels = triangles.empty() ? 0 : levels_for_drawing(triangles.size(), most);
  if (levels == 0) return nullptr;
  const KeptSurface* kept = std::any_cast<KeptSurface>(&body.cache);
  if (!kept || kept->from != triangles.size() || kept->levels != levels)
    body.cache = KeptSurface{triangles.size(), levels,
                             std::make_shared<const SmoothSurface>(loop_subdivision(triangles, levels))};
  return std::any_cast<KeptSurface>(&body.cache)->surface;
}

/// Triangles with a vertex that the mesh does not have, and the boxes around them.
struct FineTriangles {
  std::vector<Int3> triangles;
  std::vector<Box> boxes;
  std::vector<std::uint8_t> is_corner;  // by vertex of the snapshot
};
FineTriangles fine_triangles(const BodySnapshot& body) {
  FineTriangles fine{.triangles = {}, .boxes = {}, .is_corner = std::vector<std::uint8_t>(body.rest.size())};
  if (body.mesh_vertex.size() != body.rest.size()) return fine;
  const auto is_new = [&](int v) { return body.mesh_vertex[std::size_t(v)] < 0; };
  for (const Int3 t : body.triangles) {
    if (!is_new(t.x) && !is_new(t.y) && !is_new(t.z)) continue;
    const Vec3d a(body.rest[std::size_t(t.x)]), b(body.rest[std::size_t(t.y)]),
        c(body.rest[std::size_t(t.z)]);
    const double margin = 1e-3 * norm(b - a);
    Box box{min(a, min(b, c)), max(a, max(b, c))};
    box.low -= Vec3d{margin, margin, margin}, box.high += Vec3d{margin, margin, margin};
    fine.triangles.push_back(t), fine.boxes.push_back(box);
    for (const int v : {t.x, t.y, t.z}) fine.is_corner[std::size_t(v)] = 1;
  }
  return fine;
}

/// Point of the snapshot's surface: corners of a triangle and weights.
struct SurfacePoint {
  Int3 corner;
  Vec3 weight;
};

/// Point of the fine triangles nearest to a rest position on them; the given one if no triangle is there.
SurfacePoint on_fine(const FineTriangles& fine, const BodySnapshot& body, Vec3d rest,
                     SurfacePoint otherwise) {
  double nearest = 1e300;
  for (std::size_t n = 0; n < fine.triangles.size(); n++) {
    if (squared_distance(fine.boxes[n], rest) > 0) continue;
    const Int3 t = fine.triangles[n];
    const Vec3d a(body.rest[std::size_t(t.x)]), b(body.rest[std::size_t(t.y)]),
        c(body.rest[std::size_t(t.z)]);
    const Vec3d w = contact::closest_weights(rest, a, b, c);
    const double distance = norm(a * w.x + b * w.y + c * w.z - rest);
    if (distance < nearest) nearest = distance, otherwise = {t, Vec3(w)};
  }
  return otherwise;
}

template <class T>
T value_at(const SurfacePoint& at, const std::vector<T>& values) {
  return values[std::size_t(at.corner.x)] * at.weight.x + values[std::size_t(at.corner.y)] * at.weight.y +
         values[std::size_t(at.corner.z)] * at.weight.z;
}

}  // namespace

void set_coarse(std::span<const Int3> triangles, BodySnapshot& body) {
  body.smooth.triangles.clear();
  body.smooth.coarse.assign(triangles.begin(), triangles.end());
}

void show_smooth(WorldSnapshot& snapshot, std::size_t most, const Exec& exec) {
  for (BodySnapshot& body : snapshot.bodies) show_smooth(body, most, exec);
}

void show_smooth(BodySnapshot& body, std::size_t most, const Exec& exec) {
  SmoothSnapshot& smooth = body.smooth;
  smooth.triangles.clear();
  const std::shared_ptr<const SmoothSurface> surface = subdivision_of(smooth.coarse, most, body);
  if (!surface) return;
  TURGOR_CHECK(body.displacement.size() == body.rest.size(), "every vertex has a displacement");
  const FineTriangles fine = fine_triangles(body);
  const std::span<const Vec3> rest(body.rest);
  const bool has_pressure = body.pressure.size() == body.rest.size();
  smooth.x.resize(surface->size()), smooth.displacement.resize(surface->size());
  smooth.pressure.assign(has_pressure ? surface->size() : 0, 0);
  constexpr std::size_t kGrain = 4096;  // vertices per task
  const auto move_vertex = [&](std::size_t v) {
    // point on the surface of the snapshot
    SurfacePoint at{surface->on[v], surface->on_weight[v]};
    const bool may_be_fine = fine.is_corner[std::size_t(at.corner.x)] ||
                             fine.is_corner[std::size_t(at.corner.y)] ||
                             fine.is_corner[std::size_t(at.corner.z)];
    if (may_be_fine) at = on_fine(fine, body, Vec3d(on_coarse(*surface, v, rest)), at);
    // quantities there
    smooth.displacement[v] = value_at(at, body.displacement);
    smooth.x[v] = interpolated(*surface, v, rest) + smooth.displacement[v];
    if (has_pressure) smooth.pressure[v] = value_at(at, body.pressure);
  };
  parallel_for(exec, surface->size(), move_vertex, kGrain);
  smooth.triangles = surface->triangles;
  smooth.normals =
      vertex_normals({.vertices = smooth.x, .triangles = smooth.triangles, .normals = {}, .scalars = {}});
}

}  // namespace turgor
