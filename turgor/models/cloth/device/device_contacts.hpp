// Contacts of a sheet on the device: found in the order of the host's list (device_contact_search.hpp), and
// solved by the same iterations (contact_kernels.hpp).
#pragma once

#include <bit>

#include "turgor/models/cloth/contact/contact.hpp"
#include "turgor/models/cloth/device/device_contact_search.hpp"
#include "turgor/models/cloth/model/contacts.hpp"

namespace turgor::cloth {

/// Vertex of corner n % 4 of contact n / 4.
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

/// Control of iterations without readback. Each iteration stores its largest violation; the first iteration
/// after a small one is the last, or number `most`.
struct Iterations {
  std::uint32_t* largest;  // of iteration 1, 2, …
  Real small;
  int most;

  TURGOR_HD bool has_converged(int n) const {
    return n > 0 && std::bit_cast<Real>(shared_load(largest[n])) < small;
  }
  TURGOR_HD bool any_converged(int up_to) const {
    for (int n = 1; n <= up_to; n++)
      if (has_converged(n)) return true;
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
    if (all.any_converged(n - 2)) return;  // the previous iteration was the last
    const bool is_last = n == all.most || all.has_converged(n - 1);
    const Real violation = update_impulse(list[c], v, dt, is_last ? 0 : overrelaxation(n));
    atomic_max(all.largest[n], magnitude_bits(violation));
  }
};
struct SolvePosition {
  Contact* list;
  ConstVectorsView x;
  Real dt;
  Iterations all;
  int n;

  TURGOR_HD void operator()(std::size_t c) const {
    if (all.any_converged(n - 1)) return;
    atomic_max(all.largest[n], magnitude_bits(update_position_impulse(
                                   list[c], x, dt, n == all.most ? 0 : overrelaxation(n))));
  }
};
/// Applies impulse deltas unless the iterations have ended.
struct ApplyImpulseDelta {
  ImpulseDelta impulse_delta;
  Iterations all;
  int seen;  // number of iterations that must not have converged

  TURGOR_HD void operator()(std::size_t vertex) const {
    if (!all.any_converged(seen)) impulse_delta(vertex);
  }
};
struct SetWarmStart {
  Contact* list;
  const Real* free_mass;
  Real largest_speed_change;

  TURGOR_HD void operator()(std::size_t c) const { set_warm_start(list[c], free_mass, largest_speed_change); }
};

/// Warm start: adds the impulses of the step before to the forces.
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

template <class Backend>
class DeviceContacts {
 public:
  using Run = typename Backend::Run;

  DeviceContacts(DeviceAllocator<Backend>& allocator, const Model& m)
      : vertices_(std::size_t(m.count)), find_(allocator, m) {}

  std::size_t count() const { return list_.count; }
  std::span<const Contact> values() const { return list_.values(); }  // in device memory
  ContactsView view() const {
    return {list_.data(), list_.count > 0 ? of_vertex_.begin.data() : nullptr, of_vertex_.item.data()};
  }
  void upload(const Run& run, const Contacts& contacts) {
    list_.assign(contacts.list);
    if (list_.count > 0) link(run);
  }
  void download(Contacts& contacts) const {
    contacts.list.resize(list_.count);
    list_.array.download(contacts.list);
    contacts.item.clear();
    list_by_vertex(int(vertices_), contacts);
  }
  void clear() { list_.count = 0; }

  void add_impulses(const Run& run, const SheetView& sheet) const {
    if (list_.count > 0) run(vertices_, AddImpulses{view(), sheet.free_mass, sheet.force});
  }

  /// find_contacts with `more` appended. Throws OutOfDeviceMemory; the contacts are those before, then.
  void find(const Run& run, const Model& model, const SheetView& sheet, const Int3* triangles,
            std::span<const Obstacle> obstacles, Real largest_speed, double dt,
            std::span<const Contact> more) {
    largest_.resize(std::size_t(model.params.collision.iterations) + 1);  // of the solver
    find_(run, model, sheet, triangles, obstacles, view(), largest_speed, dt, more, found_);
    if (found_.count > 0) of_vertex_.make(run, vertices_, 4 * found_.count, VertexOf{found_.data()});
    std::swap(list_, found_);
    if (list_.count == 0) return;
    run(list_.count, LinkContact{list_.data(), of_vertex_.begin.data(), sheet.free_mass});
  }

  /// Returns the number of iterations.
  int solve_velocities(const Run& run, const Model& model, const SheetView& sheet, double dt) {
    const Collision& params = model.params.collision;
    if (list_.count == 0) return 0;
    // iterations
    const Iterations all = begin(velocity_tolerance(params, dt), params.iterations);
    for (int n = 1; n <= all.most; n++) {
      run(list_.count, SolveVelocity{list_.data(), sheet.v, Real(dt), all, n});
      run(vertices_, ApplyImpulseDelta{{view(), sheet.free_mass, sheet.v}, all, n - 2});
    }
    // warm start of the next step
    run(list_.count, SetWarmStart{list_.data(), sheet.free_mass, largest_warm_start(params, dt)});
    // number of iterations, which needs a download
    std::vector<std::uint32_t> largest(largest_.count);
    largest_.array.download(largest);
    for (int n = 1; n < all.most; n++)
      if (std::bit_cast<Real>(largest[std::size_t(n)]) < all.small) return n + 1;
    return all.most;
  }
  void solve_positions(const Run& run, const Model& model, const SheetView& sheet, double dt) {
    const Collision& params = model.params.collision;
    if (list_.count == 0) return;
    const Iterations all = begin(position_tolerance(params), params.iterations);
    for (int n = 1; n <= all.most; n++) {
      run(list_.count, SolvePosition{list_.data(), sheet.x, Real(dt), all, n});
      run(vertices_, ApplyImpulseDelta{{view(), sheet.free_mass, sheet.x}, all, n - 1});
    }
  }

 private:
  void link(const Run& run) { of_vertex_.make(run, vertices_, 4 * list_.count, VertexOf{list_.data()}); }
  Iterations begin(Real small, int most) {
    const std::vector<std::uint32_t> none(std::size_t(most) + 1, 0);
    largest_.assign(none);
    return {largest_.data(), small, most};
  }

  std::size_t vertices_;
  DeviceContactSearch<Backend> find_;
  DeviceLists<Backend> of_vertex_;
  DeviceList<Backend, Contact> list_, found_;
  DeviceList<Backend, std::uint32_t> largest_;
};

}  // namespace turgor::cloth
