#include "turgor/sim/report/missed_body.hpp"

#include <algorithm>
#include <limits>

#include <fmt/format.h>

#include "turgor/geometry/body_location.hpp"
#include "turgor/geometry/triangle_tree.hpp"

namespace turgor {

namespace {

constexpr std::size_t kMostMoments = 1000;  // limit of sampled times

/// Smallest distance between tool and body.
struct Nearest {
  double time = 0;                                            // [s]
  Vec3d point;                                                // on the body [m]
  double distance = std::numeric_limits<double>::infinity();  // to the tool's surface [m]
};

void update_nearest(const TriangleTree& body, const TouchingTool& tool, const ForceSample& sample,
                    Nearest& nearest) {
  const contact::Pose pose{sample.position, sample.axes};
  double reach = 0;
  for (const Vec3 x : tool.mesh.vertices) reach = std::max(reach, double(norm(x)));
  if (nearest_point(body, sample.position).distance - reach >= nearest.distance) return;
  for (const Vec3 x : tool.mesh.vertices) {
    const TrianglePoint point = nearest_point(body, contact::to_world(pose, Vec3d(x)));
    if (point.distance < nearest.distance) nearest = {sample.time, point.position, point.distance};
  }
}

}  // namespace

std::string missed_body_note(const World& world, const TouchingTool& tool) {
  // nothing to report
  const bool touched = std::any_of(tool.samples.begin(), tool.samples.end(),
                                   [](const ForceSample& sample) { return sample.contacts > 0; });
  const RestSurface rest = rest_surface(world, tool.body);
  if (touched || tool.samples.empty() || rest.triangles.empty()) return {};

  // smallest distance over sampled times
  const TriangleTree body = build_triangle_tree({rest.vertices.begin(), rest.vertices.end()},
                                                {rest.triangles.begin(), rest.triangles.end()});
  Nearest nearest;
  const std::size_t stride = 1 + (tool.samples.size() - 1) / kMostMoments;
  for (std::size_t s = 0; s < tool.samples.size(); s += stride)
    update_nearest(body, tool, tool.samples[s], nearest);
  return fmt::format(
      "{}: it never touched {}; {} (at {:.3f} s)", tool.name, touched_body(world, tool.body).name,
      describe_location(box_around(rest.vertices), nearest.point, nearest.distance), nearest.time);
}

}  // namespace turgor
