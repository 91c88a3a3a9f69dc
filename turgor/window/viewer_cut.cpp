// Cuts by hand: a line that is drawn on the skin, or a line or curve of 3D Slicer.
#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "turgor/sim/scene/markups.hpp"
#include "turgor/window/viewer.hpp"

namespace turgor {

namespace {

constexpr double kShortest = 0.005;  // cut by hand [m]

/// Sends a blade that moves at 0.2 m/s.
void request_cut(Viewer& viewer, lattice::Incision blade, double length, int body) {
  blade.name = "hand", blade.depth = viewer.cut_depth;
  blade.duration = std::clamp(length / 0.2, 0.1, 1.0);
  viewer.session.request(CutRequest{.blade = blade, .body = body});
  viewer.message = fmt::format("a cut of {:.0f} mm, {:.0f} mm deep", 1e3 * length, 1e3 * blade.depth);
  if (!viewer.now->plays) viewer.message += ": Play makes it";
}

/// Lattice body with the vertex nearest to a point; empty without lattices.
std::optional<int> nearest_lattice(const WorldSnapshot& snapshot, Vec3d point) {
  std::optional<int> nearest;
  double least = std::numeric_limits<double>::max();
  for (const BodySnapshot& body : snapshot.bodies) {
    if (body.id.kind != BodyKind::kLattice) continue;
    for (const Vec3 x : body.x) {
      const Vec3d away = Vec3d(x) - point;
      if (dot(away, away) < least) least = dot(away, away), nearest = body.id.index;
    }
  }
  return nearest;
}

}  // namespace

void update_preview(Viewer& viewer, Vec3d normal) {
  DrawnLine& line = *viewer.cut;
  const BodySnapshot& body = viewer.now->snapshot.bodies[line.body];
  const std::size_t skin = body.wall_begin > 0 ? body.wall_begin : body.triangles.size();
  line.to_normal = normal;
  line.on_skin = line_on_skin(body.x, std::span(body.triangles).first(std::min(skin, body.triangles.size())),
                              line.from, line.from_normal, line.to, line.to_normal);
}

void end_cut(Viewer& viewer) {
  const DrawnLine line = *viewer.cut;
  viewer.cut.reset();
  const BodySnapshot& body = viewer.now->snapshot.bodies[line.body];
  const double length = norm(line.to - line.from);
  if (length < kShortest) {
    viewer.message = viewer.failure = "no cut: expected a line of 5 mm or more";
    return;
  }
  viewer.touched = (line.from + line.to) * 0.5;
  request_cut(viewer, {.name = {}, .from = line.from, .to = line.to}, length, body.id.index);
}

void cut_along_markup(Viewer& viewer, const std::filesystem::path& file) {
  const Result<Markup> markup = read_markup(file);
  if (!markup) return void(viewer.message = viewer.failure = markup.error().message);
  const bool is_ready = viewer.now && viewer.now->phase == SessionStatus::Phase::kReady;
  const std::vector<Vec3d>& points = markup->points;
  const std::optional<int> body =
      is_ready ? nearest_lattice(viewer.now->snapshot, points.front()) : std::nullopt;
  if (!body)
    return void(viewer.message = viewer.failure =
                    file.string() + ": expected a scene with a lattice, which can be cut; found none");
  double length = 0;
  for (std::size_t n = 1; n < points.size(); n++) length += norm(points[n] - points[n - 1]);
  lattice::Incision blade{.name = {}, .from = points.front(), .to = points.back()};
  if (!markup->is_line) blade.path = points;
  viewer.touched = points[points.size() / 2];
  request_cut(viewer, blade, length, *body);
}

double usual_depth(const Scene& scene) {
  return scene.incisions.empty() ? lattice::Incision().depth : scene.incisions.front().blade.depth;
}

std::optional<Vec3d> rest_point(const WorldSnapshot& snapshot, const Picked& picked) {
  const BodySnapshot& body = snapshot.bodies[picked.body];
  if (body.rest.size() != body.x.size() || picked.triangle >= body.triangles.size()) return std::nullopt;
  const Int3 t = body.triangles[picked.triangle];
  const auto at = [](const std::vector<Vec3>& x, int v) { return Vec3d(x[std::size_t(v)]); };
  return at(body.rest, t.x) * picked.share[0] + at(body.rest, t.y) * picked.share[1] +
         at(body.rest, t.z) * picked.share[2];
}

void copy_point(Viewer& viewer) {
  const bool is_ready = viewer.now && viewer.now->phase == SessionStatus::Phase::kReady;
  const auto picked = is_ready
                          ? pick(viewer.now->snapshot, sight_ray(viewer.camera, viewer.cursor, viewer.aspect))
                          : std::nullopt;
  const std::optional<Vec3d> point = picked ? rest_point(viewer.now->snapshot, *picked) : std::nullopt;
  if (!point) {
    viewer.message = viewer.failure = "no point: expected a body under the cursor";
    return;
  }
  viewer.clipboard = fmt::format("[{:.4f}, {:.4f}, {:.4f}]", point->x, point->y, point->z);
  viewer.message = fmt::format("copied {} m, a point of {} at rest", viewer.clipboard,
                               viewer.now->snapshot.bodies[picked->body].name);
}

}  // namespace turgor
