// Views of a run: the whole scene from the side of the tools or from the front, a close-up of every cut, and
// the cameras of the scene.
#include <algorithm>
#include <cmath>
#include <limits>

#include "turgor/pictures/outputs.hpp"

namespace turgor {

namespace {

Vec3d to_patient(const Grid& grid, Vec3d local) { return grid.origin + grid.axes * local; }

Box grown(Box box, double margin) {
  const Vec3d m{margin, margin, margin};
  return {box.low - m, box.high + m};
}

/// View of a cut from outside and slightly from below, with its line vertical or horizontal as in the
/// patient.
SurfaceView view_of_cut(const World& world, const Cut& cut, const lattice::BladePath& path, double aspect) {
  const Grid& grid = world.lattice_bodies[std::size_t(cut.body)].model.anatomy.grid;
  Box box{to_patient(grid, path.points.front()), to_patient(grid, path.points.front())};
  for (const Vec3d p : path.points)
    box = {min(box.low, to_patient(grid, p)), max(box.high, to_patient(grid, p))};
  const double length = norm(box.high - box.low);
  const Vec3d outward = -(grid.axes * mean_inward(path));
  const Vec3d direction = outward + Vec3d{0.15, 0, -0.35};
  return {cut.blade.name, cut.blade.name + " from near",
          frame_box(grown(box, std::max(0.01, 0.08 * length)), direction, {0, 0, 1}, aspect)};
}

constexpr double kFarAway = std::numeric_limits<double>::max();
constexpr Box kNothing{{kFarAway, kFarAway, kFarAway}, {-kFarAway, -kFarAway, -kFarAway}};

/// Box of the bodies at rest.
Box box_of(const WorldSnapshot& snapshot) {
  Box box = kNothing;
  for (const BodySnapshot& body : snapshot.bodies)
    if (!body.rest.empty()) box = joined(box, body.box);
  return box;
}

/// Box of the bodies in their current state.
Box box_now(const WorldSnapshot& snapshot) {
  Box box = kNothing;
  for (const BodySnapshot& body : snapshot.bodies)
    for (const Vec3 x : body.x) box = {min(box.low, Vec3d(x)), max(box.high, Vec3d(x))};
  return box;
}

/// Adds the targets of cloth holds.
void add_holds(const World& world, Box& box) {
  const Box rest = box;
  for (const ClothBody& cloth : world.cloth_bodies)
    for (const ClothHold& hold : cloth.holds) {
      std::vector<Vec3d> positions;
      if (hold.scene.ball) positions.push_back(hold.scene.ball->center);
      if (hold.scene.box)
        for (const Vec3d corner : *hold.scene.box) positions.push_back(max(rest.low, min(rest.high, corner)));
      for (const auto& [t, x, y, z] : hold.scene.path)
        for (const Vec3d position : positions) {
          const Vec3d moved = position + Vec3d{x, y, z};
          box = {min(box.low, moved), max(box.high, moved)};
        }
    }
}

/// Adds margins for arrows beside tools, on the side of the tools, and for obstacles beside the cloth.
void add_surroundings(const WorldSnapshot& snapshot, Box& box) {
  const double margin = 0.15 * norm(box.high - box.low);
  const Box most = grown(box, margin);
  for (const TriMesh& obstacle : snapshot.obstacles) {
    const Box whole = bounding_box(obstacle);
    box = joined(box, {max(most.low, min(most.high, whole.low)), max(most.low, min(most.high, whole.high))});
  }
  for (const ToolSnapshot& tool : snapshot.tools) {
    const Vec3d position = max(most.low, min(most.high, tool.pose.position));
    box = {min(box.low, position), max(box.high, position)};
  }
}

/// Box of all motion that the run will show, as far as it is known at the start.
Box box_of_motion(const World& world, const WorldSnapshot& snapshot) {
  Box box = box_of(snapshot);
  add_holds(world, box);
  add_surroundings(snapshot, box);
  return box;
}

/// Side from which a tool approaches the first body with one; empty without tools.
std::optional<Vec3d> side_of_tools(const WorldSnapshot& snapshot) {
  const Box box = box_of(snapshot);
  for (const BodySnapshot& body : snapshot.bodies)
    for (const ToolSnapshot& tool : snapshot.tools)
      if (tool.body == body.id) return tool.pose.position - (box.low + box.high) * 0.5;
  return {};
}

SurfaceView view_of_bodies(const World& world, const WorldSnapshot& snapshot, Vec3d outward, double aspect) {
  const Vec3d out = normalized(outward);
  const bool from_head = std::abs(out.z) > 0.8;  // then the front is visible too
  const Vec3d direction = out + (from_head ? Vec3d{0.5, -1.1, 0} : Vec3d{0.45, 0, 0.2});
  const bool skin = shows_skin(snapshot);
  return {skin ? "skin" : "body", skin ? "the skin" : "the body",
          frame_box(box_of_motion(world, snapshot), direction, {0, 0, 1}, aspect), true};
}

SurfaceView view_of_camera(const CameraScene& camera) {
  return {camera.name, camera.name, {camera.from, camera.at, camera.up, camera.angle}};
}

}  // namespace

Camera camera_of_both(const Outputs& outputs, const WorldSnapshot& first, const WorldSnapshot& last) {
  const SurfaceView& view = outputs.views.front();
  const OutputScene& output = outputs.scene->output;
  Box box = joined(box_now(first), box_now(last));
  add_surroundings(first, box), add_surroundings(last, box);
  const Camera camera = frame_box(box, view.camera.eye - view.camera.target, view.camera.up,
                                  double(output.width) / output.height);
  return view.colored && output.color != SkinColor::kNone ? beside_legend(camera, outputs) : camera;
}

Result<std::vector<SurfaceView>> make_views(const Scene& scene, const World& world,
                                            const WorldSnapshot& snapshot,
                                            const std::vector<lattice::State>& at_rest) {
  const double aspect = double(scene.output.width) / scene.output.height;
  Vec3d outward = side_of_tools(snapshot).value_or(Vec3d{0, -1, 0});  // default: front of a patient
  std::vector<SurfaceView> cuts;
  for (const Cut& cut : world.cuts) {
    const auto body = std::size_t(cut.body);
    const auto path = lattice::lay_blade(world.lattice_bodies[body].model, at_rest[body], cut.blade);
    if (!path) return path.error();
    if (cuts.empty()) outward = -(world.lattice_bodies[body].model.anatomy.grid.axes * mean_inward(*path));
    cuts.push_back(view_of_cut(world, cut, *path, aspect));
  }
  std::vector<SurfaceView> views{view_of_bodies(world, snapshot, outward, aspect)};
  std::move(cuts.begin(), cuts.end(), std::back_inserter(views));
  for (const CameraScene& camera : scene.cameras) views.push_back(view_of_camera(camera));
  return views;
}

}  // namespace turgor
