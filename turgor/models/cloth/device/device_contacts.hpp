// Contacts of a sheet on one side of a bus or the other: found in the order of the CPU's list
// (device_contact_search.hpp), and solved by the same iterations (contact_kernels.hpp).
#pragma once

#include <bit>

#include "turgor/models/cloth/device/device_contact_search.hpp"

namespace turgor::cloth {

/// The vertex of corner n % 4 of contact n / 4.
struct VertexOf {
  const Contact* list;

  TURGOR_HD int operator()(std::size_t n) const { return list[n / 4].vertex[n % 4]; }
};

struct LinkContact {
  Contact* list;
  const int* begin;
  const Real* free_mass;

  TURGOR_HD void operator()(std::size_t c) const {
    list[c].mass = contact_mass(list[c], begin, free_mass);
    start_impulse(list[c]);
  }
};

/// Iterations without looking at what they found from the other side of the bus: each leaves the largest of
/// what was lacking, and the last is the one after which it is small, or `most`.
struct Iterations {
  std::uint32_t* largest;  // of iteration 1, 2, …
  Real small;
  int most;

  TURGOR_HD bool was_near(int n) const {
    return n > 0 && std::bit_cast<Real>(shared_load(largest[n])) < small;
  }
  TURGOR_HD bool was_any_near(int up_to) const {
    for (int n = 1; n <= up_to; n++)
      if (was_near(n)) return true;
    return false;
  }
};
struct SolveVelocity {
  Contact* list;
  ConstVectorsView v;
  Real dt;
  Iterations all;
  int n;

  TURGOR_HD void operator()(std::size_t c) const {
    if (all.was_any_near(n - 2)) return;  // the one before was the last
    const bool is_last = n == all.most || all.was_near(n - 1);
    const Real far = update_impulse(list[c], v, dt, is_last ? 0 : beyond_of(n));
    atomic_max(all.largest[n], magnitude_bits(far));
  }
};
struct SolvePlace {
  Contact* list;
  ConstVectorsView x;
  Real dt;
  Iterations all;
  int n;

  TURGOR_HD void operator()(std::size_t c) const {
    if (all.was_any_near(n - 1)) return;
    atomic_max(all.largest[n],
               magnitude_bits(update_place(list[c], x, dt, n == all.most ? 0 : beyond_of(n))));
  }
};
/// As long as iterations go on.
struct ApplyImpulseDelta {
  ImpulseDelta impulse_delta;
  Iterations all;
  int seen;  // iterations of which none was near

  TURGOR_HD void operator()(std::size_t vertex) const {
    if (!all.was_any_near(seen)) impulse_delta(vertex);
  }
};
struct CarryContact {
  Contact* list;
  const Real* free_mass;
  Real largest_change;

  TURGOR_HD void operator()(std::size_t c) const { set_carry(list[c], free_mass, largest_change); }
};

/// Impulses of the step before are among the forces of this one.
struct AddImpulses {
  ContactsView contacts;
  const Real* free_mass;
  VectorsView force;

  TURGOR_HD void operator()(std::size_t v) const {
    if (!(free_mass[v] > 0)) return;
    for (int n = contacts.begin[v]; n < contacts.begin[v + 1]; n++) {
      const auto item = std::size_t(contacts.item[n]);
      const Contact& c = contacts.list[item / 4];
      if (c.impulse > 0)
        force.add(v, (c.normal * c.impulse + c.friction_impulse) * (c.warm_start * c.weight[item % 4]));
    }
  }
};

template <class Side>
class DeviceContacts {
 public:
  using Run = typename Side::Run;

  DeviceContacts(DeviceAllocator<Side>& rooms, const Model& m)
      : vertices_(std::size_t(m.count)), find_(rooms, m) {}

  std::size_t count() const { return list_.count; }
  ContactsView view() const {
    return {list_.data(), list_.count > 0 ? of_vertex_.begin.data() : nullptr, of_vertex_.item.data()};
  }
  void put(const Run& run, const Contacts& contacts) {
    list_.put(contacts.list);
    if (list_.count > 0) link(run);
  }
  void get(Contacts& contacts) const {
    contacts.list.resize(list_.count);
    list_.room.download(contacts.list);
    contacts.begin.clear(), contacts.item.clear(), contacts.touched.clear();
    if (list_.count == 0) return;
    contacts.begin.resize(vertices_ + 1);
    of_vertex_.begin.room.download(contacts.begin);
    contacts.item.resize(std::size_t(contacts.begin.back()));
    of_vertex_.item.room.download(contacts.item);
    for (std::size_t v = 0; v < vertices_; v++)
      if (contacts.begin[v] < contacts.begin[v + 1]) contacts.touched.push_back(int(v));
  }
  void forget() { list_.count = 0; }

  void add_impulses(const Run& run, const SheetView& sheet) const {
    if (list_.count > 0) run(vertices_, AddImpulses{view(), sheet.free_mass, sheet.force});
  }

  /// find_contacts, with `more` behind what is found there.
  void find(const Run& run, const Model& model, const SheetView& sheet, const Int3* triangles,
            std::span<const Obstacle> obstacles, Real largest_speed, double dt,
            std::span<const Contact> more) {
    find_(run, model, sheet, triangles, obstacles, view(), largest_speed, dt, more, found_);
    std::swap(list_, found_);
    if (list_.count == 0) return;
    link(run);
    run(list_.count, LinkContact{list_.data(), of_vertex_.begin.data(), sheet.free_mass});
  }

  /// Returns the iterations it took.
  int solve_velocities(const Run& run, const Model& model, const SheetView& sheet, double dt) {
    const Collision& params = model.params.collision;
    if (list_.count == 0) return 0;
    const Iterations all = begin(small_speed(params, dt), params.iterations);
    for (int n = 1; n <= all.most; n++) {
      run(list_.count, SolveVelocity{list_.data(), sheet.v, Real(dt), all, n});
      run(vertices_, ApplyImpulseDelta{{view(), sheet.free_mass, sheet.v}, all, n - 2});
    }
    run(list_.count, CarryContact{list_.data(), sheet.free_mass, largest_carried(params, dt)});
    std::vector<std::uint32_t> largest(largest_.count);
    largest_.room.download(largest);
    for (int n = 1; n < all.most; n++)
      if (std::bit_cast<Real>(largest[std::size_t(n)]) < all.small) return n + 1;
    return all.most;
  }
  void solve_places(const Run& run, const Model& model, const SheetView& sheet, double dt) {
    const Collision& params = model.params.collision;
    if (list_.count == 0) return;
    const Iterations all = begin(small_way(params), params.iterations);
    for (int n = 1; n <= all.most; n++) {
      run(list_.count, SolvePlace{list_.data(), sheet.x, Real(dt), all, n});
      run(vertices_, ApplyImpulseDelta{{view(), sheet.free_mass, sheet.x}, all, n - 1});
    }
  }

 private:
  void link(const Run& run) { of_vertex_.make(run, vertices_, 4 * list_.count, VertexOf{list_.data()}); }
  Iterations begin(Real small, int most) {
    const std::vector<std::uint32_t> none(std::size_t(most) + 1, 0);
    largest_.put(none);
    return {largest_.data(), small, most};
  }

  std::size_t vertices_;
  DeviceContactSearch<Side> find_;
  DeviceLists<Side> of_vertex_;
  DeviceList<Side, Contact> list_, found_;
  DeviceList<Side, std::uint32_t> largest_;
};

}  // namespace turgor::cloth
