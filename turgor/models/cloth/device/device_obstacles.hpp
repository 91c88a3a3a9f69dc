// Obstacles of a sheet on the device. Planes and rigid shapes are uploaded in every step, surfaces only when
// they change.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "turgor/core/device_arrays.hpp"
#include "turgor/models/cloth/contact/obstacle.hpp"
#include "turgor/models/cloth/contact/obstacle_kernels.hpp"
#include "turgor/models/cloth/device/device_found.hpp"

namespace turgor::cloth {

/// Device memory of one obstacle's shape.
template <class Backend>
class DeviceShape {
 public:
  /// Uploads a shape; returns it with device pointers.
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
      nodes_.assign(tree.boxes.nodes), items_.assign(tree.boxes.items);
      vertices_.assign(tree.vertices), triangles_.assign(tree.triangles);
      normals_.assign(moving->normals), velocities_.assign(moving->velocities);
      moving_ = moving;
    }
    shape.boxes.nodes = nodes_.data(), shape.boxes.items = items_.data();
    shape.vertices = vertices_.data(), shape.triangles = triangles_.data();
    shape.normals = normals_.data();
    if (shape.velocities != nullptr) shape.velocities = velocities_.data();
  }
  void put(RigidShape& shape) {
    if (shape.grid.nodes == nullptr) return;
    grid_.assign({shape.grid.nodes, shape.grid.count()});
    tips_.assign({shape.tips, std::size_t(shape.tip_count)});
    shape.grid.nodes = grid_.data(), shape.tips = tips_.data();
  }

  std::shared_ptr<const MovingSurface> moving_;  // surface whose data are uploaded
  DeviceList<Backend, BoxTree::Node> nodes_;
  DeviceList<Backend, int> items_;
  DeviceList<Backend, Vec3d> vertices_, tips_;
  DeviceList<Backend, Int3> triangles_;
  DeviceList<Backend, Vec3> normals_, velocities_;
  DeviceList<Backend, DistanceNode> grid_;
};

/// Obstacles of a step.
struct ObstaclesView {
  const ObstacleView* list;
  int count;
  bool between;  // any may pass between vertices

  template <class Take>
  TURGOR_HD void visit(const FacingView& facing, int i, const Take& take) const {
    const auto obstacle = [&](int o) -> const ObstacleView& { return list[o]; };
    facing.visit(i, count, obstacle, take);
    if (between) facing.visit_between(i, count, obstacle, take);
  }
};

template <class Backend>
class DeviceObstacles {
 public:
  ObstaclesView put(std::span<const Obstacle> obstacles) {
    shapes_.resize(obstacles.size());
    views_.clear();
    for (std::size_t o = 0; o < obstacles.size(); o++) {
      views_.push_back(obstacles[o]);
      views_.back().shape = shapes_[o].put(obstacles[o]);
    }
    list_.assign(views_);
    return {list_.data(), int(views_.size()), any_between(obstacles)};
  }
  /// Model::triangle_begin on the device, needed by obstacles that may pass between vertices.
  const int* triangle_begin(const Model& model) {
    if (triangle_begin_.count == 0) triangle_begin_.assign(model.triangle_begin);
    return triangle_begin_.data();
  }

 private:
  std::vector<DeviceShape<Backend>> shapes_;  // one per obstacle
  std::vector<ObstacleView> views_;
  DeviceList<Backend, ObstacleView> list_;
  DeviceList<Backend, int> triangle_begin_;
};

}  // namespace turgor::cloth
