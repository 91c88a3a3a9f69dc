// The contacts that the velocities of a step make, found on one side of a bus or the other: of vertices with
// each other and with obstacles, and of large triangles and edges, in the order of the CPU's list
// (contact_find.cpp).
#pragma once

#include <bit>

#include "turgor/models/cloth/contact/contact_kernels.hpp"
#include "turgor/models/cloth/device/device_large_primitives.hpp"
#include "turgor/models/cloth/device/device_obstacles.hpp"

namespace turgor::cloth {

/// Of a vertex with later ones, then with obstacles. Whether there are any is a constant: what looks for them
/// takes three times the registers.
template <bool kWithObstacles>
struct FindOfVertex {
  PairsView pairs;
  NearView near;
  Real reach;
  bool self;
  FacingView facing;
  ObstaclesView obstacles;
  Found found;

  template <class Take>
  TURGOR_HD void visit_pairs(int i, const Take& take) const {
    const Vec3 p = pairs.x[std::size_t(i)];
    const Group mine = pairs.group(i);
    const Vec3 half{near.cell / 2, near.cell / 2, near.cell / 2};
    near.visit(p - half, p + half, [&](int j, Vec3 q) {
      const Vec3 d = q - p;
      if (!(dot(d, d) < reach * reach) || j <= i) return;
      Contact contact;
      if (pairs.touch(i, mine, j, q, Look::kActual, contact)) take(contact);
    });
  }
  FindOfVertex<false> without_obstacles() const {
    return {pairs, near, reach, self, facing, obstacles, found};
  }
  TURGOR_HD void operator()(std::size_t i) const {
    found(i, [&](const auto& take) {
      if (self) visit_pairs(int(i), take);
      if constexpr (kWithObstacles) obstacles.visit(facing, int(i), take);
    });
  }
};

template <class Side>
class DeviceContactSearch {
 public:
  /// What a model with self-collision needs; obstacles get their room when they are there.
  DeviceContactSearch(DeviceAllocator<Side>& rooms, const Model& m)
      : self_(m.params.collision.self),
        vertices_(std::size_t(m.count)),
        near_begin_(rooms.copy(m.near.begin)),
        near_item_(rooms.copy(m.near.item)),
        points_(rooms, self_ ? vertices_ : 0),
        coarse_(rooms, m),
        counts_{rooms.template room<int>(self_ ? vertices_ + coarse_.count() + 1 : 0)} {}

  /// find_contacts into `list`, with `more` behind what is found there.
  template <class Run>
  void operator()(const Run& run, const Model& model, const SheetView& sheet, const Int3* triangles,
                  std::span<const Obstacle> obstacles, ContactsView old, Real largest_speed, double dt,
                  std::span<const Contact> more, DeviceList<Side, Contact>& list) {
    const Collision& params = model.params.collision;
    const Real thickness = Real(params.thickness), friction = Real(params.friction), h = Real(dt);
    const Real reach = reach_in_step(thickness, Real(1.1), largest_speed, h);
    const std::size_t all = vertices_ + coarse_.count();
    counts_.fit(all + 1);
    FindOfVertex<true> find{.pairs = {sheet.x, sheet.v, sheet.change, old, near_begin_.data(),
                                      near_item_.data(), thickness, friction, h},
                            .near = {},
                            .reach = reach,
                            .self = self_,
                            .facing = {sheet.x, sheet.v, sheet.free_mass, old, nullptr, triangles, h},
                            .obstacles = obstacles_.put(obstacles),
                            .found = {counts_.data(), nullptr}};
    if (find.obstacles.between) find.facing.triangle_begin = obstacles_.triangle_begin(model);
    if (self_) find.near = points_.sort(run, sheet.x, std::max(Real(2.02) * reach, coarse_cell(model)));
    const CoarseView coarse{sheet.x, sheet.v, sheet.change, sheet.x_rest, old, thickness, friction,
                            reach,   h,       Look::kActual};
    coarse_.place(run, coarse);
    const auto look = [&] {
      if (find.obstacles.count > 0)
        run(vertices_, find);
      else
        run(vertices_, find.without_obstacles());
      coarse_.find(run, coarse, find.near, {find.found.count + vertices_, find.found.list});
    };
    look();
    run(1, ClearNumbers{counts_.data() + all});
    scan_(run, counts_.data(), all + 1);
    const std::size_t found = total(run, all);
    list.fit(found + more.size());
    find.found.list = list.data();
    if (found > 0) look();
    if (!more.empty()) add(found, more, list);
  }

 private:
  static Real coarse_cell(const Model& model) {
    return model.coarse.triangles.empty() ? 0 : model.coarse.longest / 2;
  }
  template <class Run>
  std::size_t total(const Run& run, std::size_t all) {
    int total = 0;
    total_.fit(1);
    run(1, CopyNumbers{counts_.data() + all, total_.data()});
    total_.room.download({&total, 1});
    return std::size_t(total);
  }
  /// Behind what was found there.
  static void add(std::size_t found, std::span<const Contact> more, DeviceList<Side, Contact>& list) {
    std::vector<Contact> all(found);
    list.room.download(all);
    all.insert(all.end(), more.begin(), more.end());
    list.put(all);
  }

  bool self_;
  std::size_t vertices_;
  typename Side::template Array<int> near_begin_, near_item_;
  DeviceSpatialHash<Side> points_;
  DeviceCoarse<Side> coarse_;
  DeviceObstacles<Side> obstacles_;
  DeviceList<Side, int> counts_, total_;
  DeviceScan<Side> scan_;
};

}  // namespace turgor::cloth
