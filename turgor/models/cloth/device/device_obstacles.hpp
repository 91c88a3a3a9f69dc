// Obstacles of a sheet on one side of a bus or the other: planes and rigid shapes go over in every step,
// surfaces when they are others than in the step before.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "turgor/core/device_arrays.hpp"
#include "turgor/models/cloth/contact/obstacle.hpp"
#include "turgor/models/cloth/contact/obstacle_kernels.hpp"
#include "turgor/models/cloth/device/device_found.hpp"

namespace turgor::cloth {

/// What an obstacle points to, there.
template <class Side>
class DeviceShape {
 public:
  /// The same shape with pointers of that side.
  ObstacleShape put(const Obstacle& obstacle) {
    ObstacleShape shape = obstacle.shape;
    if (shape.kind == ObstacleShape::Kind::kSurface) put(obstacle.moving, shape.surface);
    if (shape.kind == ObstacleShape::Kind::kRigid) put(shape.rigid);
    return shape;
  }

 private:
  void put(const std::shared_ptr<const MovingSurface>& moving, SurfaceShape& shape) {
    if (moving != moving_) {
      const TriangleTree& tree = moving->tree;
      nodes_.put(tree.boxes.nodes), items_.put(tree.boxes.items);
      vertices_.put(tree.vertices), triangles_.put(tree.triangles);
      normals_.put(moving->normals), velocities_.put(moving->velocities);
      moving_ = moving;
    }
    shape.boxes.nodes = nodes_.data(), shape.boxes.items = items_.data();
    shape.vertices = vertices_.data(), shape.triangles = triangles_.data();
    shape.normals = normals_.data();
    if (shape.velocities != nullptr) shape.velocities = velocities_.data();
  }
  void put(RigidShape& shape) {
    if (shape.grid.nodes == nullptr) return;
    grid_.put({shape.grid.nodes, shape.grid.count()});
    tips_.put({shape.tips, std::size_t(shape.tip_count)});
    shape.grid.nodes = grid_.data(), shape.tips = tips_.data();
  }

  std::shared_ptr<const MovingSurface> moving_;  // whose these are
  DeviceList<Side, BoxTree::Node> nodes_;
  DeviceList<Side, int> items_;
  DeviceList<Side, Vec3d> vertices_, tips_;
  DeviceList<Side, Int3> triangles_;
  DeviceList<Side, Vec3> normals_, velocities_;
  DeviceList<Side, DistanceNode> grid_;
};

/// Those of a step.
struct ObstaclesView {
  const ObstacleView* list;
  int count;
  bool between;  // may any pass between vertices?

  template <class Take>
  TURGOR_HD void visit(const FacingView& facing, int i, const Take& take) const {
    const auto obstacle = [&](int o) -> const ObstacleView& { return list[o]; };
    facing.visit(i, count, obstacle, take);
    if (between) facing.visit_between(i, count, obstacle, take);
  }
};

template <class Side>
class DeviceObstacles {
 public:
  ObstaclesView put(std::span<const Obstacle> obstacles) {
    shapes_.resize(obstacles.size());
    views_.clear();
    for (std::size_t o = 0; o < obstacles.size(); o++) {
      views_.push_back(obstacles[o]);
      views_.back().shape = shapes_[o].put(obstacles[o]);
    }
    list_.put(views_);
    return {list_.data(), int(views_.size()), any_between(obstacles)};
  }
  /// Model::triangle_begin, for what may pass between vertices.
  const int* triangle_begin(const Model& model) {
    if (triangle_begin_.count == 0) triangle_begin_.put(model.triangle_begin);
    return triangle_begin_.data();
  }

 private:
  std::vector<DeviceShape<Side>> shapes_;  // of each
  std::vector<ObstacleView> views_;
  DeviceList<Side, ObstacleView> list_;
  DeviceList<Side, int> triangle_begin_;
};

}  // namespace turgor::cloth
