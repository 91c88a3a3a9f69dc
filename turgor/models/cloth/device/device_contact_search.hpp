// Contact search on the device: vertices, obstacles, large triangles and edges, in the order of the host's
// list (contact_find.cpp).
#pragma once

#include <bit>

#include "turgor/models/cloth/contact/contact.hpp"
#include "turgor/models/cloth/contact/contact_kernels.hpp"
#include "turgor/models/cloth/device/device_large_primitives.hpp"
#include "turgor/models/cloth/device/device_obstacles.hpp"
#include "turgor/models/cloth/model/contacts.hpp"

namespace turgor::cloth {

/// Contacts of a vertex with later vertices, then with obstacles. The template parameter saves two thirds of
/// the registers without obstacles.
template <bool kWithObstacles>
struct FindVertexContacts {
  PairsView pairs;
  NearView near;
  Real reach;
  bool self;
  FacingView facing;
  ObstaclesView obstacles;
  ContactOutput output;

  template <class Take>
  TURGOR_HD void visit_pairs(int i, const Take& take) const {
    const Vec3 p = pairs.x[std::size_t(i)];
    const Group mine = pairs.group(i);
    const Vec3 half{near.cell / 2, near.cell / 2, near.cell / 2};
    near.visit(p - half, p + half, [&](int j, Vec3 q) {
      const Vec3 d = q - p;
      if (!(dot(d, d) < reach * reach) || j <= i) return;
      Contact contact;
      if (pairs.touch(i, mine, j, q, ContactPhase::kActual, contact)) take(contact);
    });
  }
  FindVertexContacts<false> without_obstacles() const {
    return {pairs, near, reach, self, facing, obstacles, output};
  }
  TURGOR_HD void operator()(std::size_t i) const {
    output(i, [&](const auto& take) {
      if (self) visit_pairs(int(i), take);
      if constexpr (kWithObstacles) obstacles.visit(facing, int(i), take);
    });
  }
};

template <class Backend>
class DeviceContactSearch {
 public:
  /// Allocates for self-collision; obstacles allocate when they appear.
  DeviceContactSearch(DeviceAllocator<Backend>& allocator, const Model& m)
      : self_(m.params.collision.self),
        vertices_(std::size_t(m.count)),
        excluded_begin_(allocator.copy(m.excluded.begin)),
        excluded_item_(allocator.copy(m.excluded.item)),
        points_(allocator, self_ ? vertices_ : 0),
        large_(allocator, m),
        counts_{allocator.template allocate<int>(self_ ? vertices_ + large_.count() + 1 : 0)} {}

  /// find_contacts into `list`, with `more` appended.
  template <class Run>
  void operator()(const Run& run, const Model& model, const SheetView& sheet, const Int3* triangles,
                  std::span<const Obstacle> obstacles, ContactsView old, Real largest_speed, double dt,
                  std::span<const Contact> more, DeviceList<Backend, Contact>& list) {
    // search distance, as on the host
    const Collision& params = model.params.collision;
    const Real thickness = Real(params.thickness), friction = Real(params.friction), h = Real(dt);
    const Real reach = reach_in_step(thickness, Real(1.1), largest_speed, h);
    const std::size_t all = vertices_ + large_.count();
    counts_.resize(all + 1);
    // kernels
    FindVertexContacts<true> find{
        .pairs = {sheet.x, sheet.v, sheet.change, old, excluded_begin_.data(), excluded_item_.data(),
                  large_.cones(sheet.x), thickness, friction, h},
        .near = {},
        .reach = reach,
        .self = self_,
        .facing = {sheet.x, sheet.v, sheet.free_mass, old, nullptr, triangles, h},
        .obstacles = obstacles_.put(obstacles),
        .output = {counts_.data(), nullptr}};
    // sorted vertices and large primitives
    if (find.obstacles.between) find.facing.triangle_begin = obstacles_.triangle_begin(model);
    if (self_) find.near = points_.sort(run, sheet.x, std::max(Real(2.02) * reach, large_cell(model)));
    const LargeView large{large_.mesh(),
                          large_.cones(sheet.x),
                          sheet.x,
                          sheet.v,
                          sheet.change,
                          sheet.x_rest,
                          old,
                          thickness,
                          friction,
                          reach,
                          h,
                          ContactPhase::kActual};
    large_.update(run, large);
    // first pass counts, second pass writes
    const auto search = [&] {
      if (find.obstacles.count > 0)
        run(vertices_, find);
      else
        run(vertices_, find.without_obstacles());
      large_.find(run, large, find.near, {find.output.count + vertices_, find.output.list});
    };
    search();
    run(1, ClearInts{counts_.data() + all});
    scan_(run, counts_.data(), all + 1);
    const std::size_t found = total(run, all);
    list.resize(found + more.size());
    find.output.list = list.data();
    if (found > 0) search();
    if (!more.empty()) add(found, more, list);
  }

 private:
  static Real large_cell(const Model& model) {
    return model.large.triangles.empty() ? 0 : model.large.longest / 2;
  }
  template <class Run>
  std::size_t total(const Run& run, std::size_t all) {
    int total = 0;
    total_.resize(1);
    run(1, CopyInts{counts_.data() + all, total_.data()});
    total_.array.download({&total, 1});
    return std::size_t(total);
  }
  /// Appends `more` to the list.
  static void add(std::size_t found, std::span<const Contact> more, DeviceList<Backend, Contact>& list) {
    std::vector<Contact> all(found);
    list.array.download(all);
    all.insert(all.end(), more.begin(), more.end());
    list.assign(all);
  }

  bool self_;
  std::size_t vertices_;
  typename Backend::template Array<int> excluded_begin_, excluded_item_;
  DeviceSpatialHash<Backend> points_;
  DeviceLargePrimitives<Backend> large_;
  DeviceObstacles<Backend> obstacles_;
  DeviceList<Backend, int> counts_, total_;
  DeviceScan<Backend> scan_;
};

}  // namespace turgor::cloth
