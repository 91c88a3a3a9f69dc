// Vertex block descent on the lattice (Chen et al. 2024). Each node in turn takes one Newton step on the
// energy of the time step: inertia, springs, volumes or cells, and skin. Nodes of a half row share no edge,
// so a half row is processed at once. Forces and Hessians are gathered into a buffer with SIMD, skin is added
// by node, and the Newton steps use SIMD.
#include <algorithm>
#include <bit>
#include <vector>

#include "turgor/core/assert.hpp"
#include "turgor/models/lattice/mechanics/cells.hpp"
#include "turgor/models/lattice/mechanics/contact_points.hpp"
#include "turgor/models/lattice/mechanics/cut_elements.hpp"
#include "turgor/models/lattice/mechanics/element_energies.hpp"
#include "turgor/models/lattice/mechanics/law_backtracking.hpp"
#include "turgor/models/lattice/mechanics/node_contact.hpp"
#include "turgor/models/lattice/mechanics/node_forces.hpp"
#include "turgor/models/lattice/mechanics/point_springs.hpp"
#include "turgor/models/lattice/mechanics/skin_forces.hpp"
#include "turgor/models/lattice/model/colors.hpp"
#include "turgor/models/lattice/model/neighbors.hpp"
#include "turgor/models/lattice/model/rows.hpp"
#include "turgor/models/lattice/solver/calm_rows.hpp"
#include "turgor/models/lattice/solver/inertia.hpp"
#include "turgor/models/lattice/solver/residual_sum.hpp"
#include "turgor/models/lattice/solver/sleep.hpp"
#include "turgor/models/lattice/solver/sweeps.hpp"

namespace turgor::lattice {

namespace {

/// Factors of springs and tetrahedra around sixteen nodes: 1 = uncut, 0 = cut. All numbers have one size;
/// otherwise loops vectorize only four wide.
struct Uncut {
  Real spring[kNeighborCount][kSpareSlots], tet[24][kSpareSlots];
};
void find_uncut(const NodeArrays& n, const Neighbors& stencil, int slot, bool with_volumes, Uncut& out) {
  for (int e = 0; e < kNeighborCount; e++) {
    const std::uint8_t* cut = n.cut + slot + lower_end(stencil, e);
    for (int i = 0; i < kSpareSlots; i++) out.spring[e][i] = is_cut(cut[i], e / 2) ? 0 : 1;
  }
  for (std::size_t t = 0; t < 24 && with_volumes; t++) {
    int any[kSpareSlots] = {};
    for (const IncidentEdge edge : kIncidentTets[t].edge) {
      const std::uint8_t* cut = n.cut + slot + lower_end(stencil, edge);
      for (int i = 0; i < kSpareSlots; i++) any[i] |= is_cut(cut[i], edge.family);
    }
    for (int i = 0; i < kSpareSlots; i++) out.tet[t][i] = any[i] ? 0 : 1;
  }
}

/// Gathers springs and volumes around the nodes of [slot, slot + kSpareSlots).
template <bool kWithCuts, bool kWithVolumes>
void gather_elements(const NodeArrays& n, const Neighbors& stencil, Real rest_volume, Real volume_scale,
                     int slot, int begin, SystemBuffer& __restrict out) {
  Uncut uncut;
  if constexpr (kWithCuts) find_uncut(n, stencil, slot, kWithVolumes, uncut);
  TURGOR_LANES
  for (int i = 0; i < kSpareSlots; i++) {
    const auto spring = [&](int e) { return kWithCuts ? uncut.spring[e][i] : Real(1); };
    const auto tet = [&](std::size_t t) { return kWithCuts ? uncut.tet[t][i] : Real(1); };
    out.set(begin + i,
            incident_springs<kWithVolumes>(n, stencil, rest_volume, volume_scale, slot + i, spring, tet));
  }
}

/// Gathers forces and Hessians of all elements for nodes of a half row, without inertia.
struct GatherSystems {
  const Model& model;
  const State& state;
  NodeArrays nodes;
  Neighbors neighbors[2];
  SolidRow solid;
  SkinForces skin;
  CutElementForces cut_elements;
  const PointSprings* springs;

  GatherSystems(const Model& m, State& s, const Inputs& inputs)
      : model(m),
        state(s),
        nodes(node_arrays(m, s)),
        neighbors{neighbors_of(m, 0), neighbors_of(m, 1)},
        solid(m, s),
        skin(m),
        cut_elements(m, s),
        springs(inputs.springs) {}

  template <bool kWithCuts>
  void edges(int parity, int slot, int count, SystemBuffer& out) const {
    const auto elements =
        model.springs.volume_scale > 0 ? gather_elements<kWithCuts, true> : gather_elements<kWithCuts, false>;
    for (int begin = 0; begin < count; begin += kSpareSlots)
      elements(nodes, neighbors[parity], model.springs.rest_volume, model.springs.volume_scale, slot + begin,
               begin, out);
  }

  void add_skin(int slot, int count, SystemBuffer& out) const {
    for_skin_nodes(
        model, state.cuts, nodes, skin, slot, count, [&](int at) { return out.get(at - slot); },
        [&](int at, const NodeSystem& s) { out.set(at - slot, s); });
  }

  void operator()(int parity, int slot, int count, SystemBuffer& out) const {
    // springs or cells
    if (model.params.tissue.law == TissueLaw::kSolid)
      solid.gather(parity, slot, count, out);
    else if (state.cuts.row_cut[std::size_t(slot / row_stride(model.anatomy.lattice))])
      edges<true>(parity, slot, count, out);
    else
      edges<false>(parity, slot, count, out);
    // skin
    if (!model.anatomy.skin.triangles.empty()) add_skin(slot, count, out);
    // cut elements
    for (const ElementNode& node : cut_elements.nodes_of(slot, count)) {
      NodeSystem s = out.get(node.slot - slot);
      add(s, cut_elements.gather(node));
      out.set(node.slot - slot, s);
    }
    // springs at points
    const std::span<const PointSpringTerm> terms = terms_of(springs, slot, count);
    const auto u = [this](int corner) { return cut_elements.view.u(corner); };
    for (std::size_t n = 0; n < terms.size(); n++) {
      NodeSystem s = out.get(terms[n].corner - slot);
      add_point_springs(s, *springs, terms.subspan(n, 1), u);
      out.set(terms[n].corner - slot, s);
    }
  }

  /// Force and Hessian of the elements and springs at a virtual node.
  NodeSystem virtual_node(const ElementNode& node) const {
    NodeSystem s = cut_elements.gather(node);
    const auto u = [this](int corner) { return cut_elements.view.u(corner); };
    if (springs) add_point_springs(s, *springs, terms_of(springs, node.corner, 1), u);
    return s;
  }
};

/// Moves the nodes and virtual nodes of a layer or half row.
struct VbdSweep {
  const GatherSystems& gather;
  const Inertia& inertia;
  std::span<NodeContact> contacts;
  const ContactPoints* points;                     // of the contacts; null: they act on nodes
  std::span<const ContactForce> forces_at_points;  // before the sweep
  Order order;
  Sleep& sleep;
  Real wake_distance2;  // squared displacement per step above which a row wakes its neighbors [m²]; negative:
                        // no sleep
  CalmRows* calm = nullptr;  // null: sweeps all rows that are awake

  bool sleeps() const { return wake_distance2 >= 0; }
  const std::vector<std::uint8_t>& swept() const { return calm ? calm->swept : sleep.awake; }

  void operator()(int k) const {
    SystemBuffer buffer;
    const std::span<const ElementNode> virtual_nodes = gather.cut_elements.virtual_nodes_of(k);
    if (order == Order::kBackward) solve_virtual_nodes(virtual_nodes);
    for_each_chunk(
        gather.model, sleeps() ? swept().data() : nullptr, k,
        [&](int parity, int slot, int count) { update_nodes(parity, slot, count, buffer); }, order);
    if (order == Order::kForward) solve_virtual_nodes(virtual_nodes);
  }

  /// Not inlined: every run then has the same bits. In a second copy of this code, the compiler may fuse
  /// other products with their sums.
  [[gnu::noinline]] void operator()(HalfRow row) const {
    const Lattice& l = gather.model.anatomy.lattice;
    const int first = row_slot(l, row.j, row.k) + row.parity * l.half;
    if (sleeps() && !swept()[std::size_t(row_of(gather.model, first))]) return;
    SystemBuffer buffer;
    for_each_chunk_of_half_row(gather.model, row.parity, row.j, row.k, [&](int parity, int slot, int count) {
      update_nodes(parity, slot, count, buffer);
    });
    solve_virtual_nodes(gather.cut_elements.virtual_nodes_of(first, l.half));
  }

  void update_nodes(int parity, int slot, int count, SystemBuffer& buffer) const {
    // forces and Hessians
    gather(parity, slot, count, buffer);
    // contacts
    const std::span<NodeContact> node_contacts =
        points ? std::span<NodeContact>() : contacts_of(contacts, slot, count);
    if (!node_contacts.empty()) add_contacts_of_nodes(node_contacts, slot, buffer);
    const std::span<const ContactTerm> terms =
        points ? terms_of(*points, slot, count) : std::span<const ContactTerm>();
    if (!terms.empty()) add_contacts_at_points(terms, slot, buffer);
    // Newton steps
    ChunkBefore before;
    if (calm) before.copy(gather.nodes, slot, count);
    if (gather.skin.law == SkinLaw::kExponential) shorten_steps_of_skin(slot, count, buffer);
    ChunkBefore removed;
    const bool any_removed = has_removed(slot, count);
    if (any_removed) removed.copy(gather.nodes, slot, count);
    if (gather.solid.laws)
      solve_with_laws(slot, count, buffer);
    else
      solve(slot, count, buffer);
    if (any_removed) restore_removed(removed, slot, count);
    // contact forces
    update_forces(node_contacts, gather.nodes);
    // wake neighbors
    const auto row = std::size_t(row_of(gather.model, slot));
    if (calm && before.has_moved(gather.nodes, slot, count, wake_distance2 * Real(kCalmShare * kCalmShare)))
      calm->stirred[row] = 1;
    if (sleeps() && has_moved(slot, count)) sleep.moved[row] = 1;
  }

  bool has_removed(int slot, int count) const {
    int any = 0;
    for (int s = slot; s < slot + count; s++) any |= inertia.removed[s];
    return any != 0;
  }
  /// Restores displacements of removed nodes. A test in the loops that move the nodes would change how the
  /// compiler fuses products and sums there.
  void restore_removed(const ChunkBefore& before, int slot, int count) const {
    for (int i = 0; i < count; i++)
      if (inertia.removed[slot + i]) {
        gather.nodes.ux[slot + i] = before.x[i];
        gather.nodes.uy[slot + i] = before.y[i];
        gather.nodes.uz[slot + i] = before.z[i];
      }
  }

  /// Virtual nodes follow the nodes of their layer, or precede them in a backward sweep. Those of other slabs
  /// of the phase do not change meanwhile.
  void solve_virtual_nodes(std::span<const ElementNode> virtual_nodes) const {
    for (std::size_t n = 0; n < virtual_nodes.size(); n++) {
      const ElementNode& virtual_node =
          virtual_nodes[order == Order::kForward ? n : virtual_nodes.size() - 1 - n];
      if (!sleeps() || swept()[std::size_t(row_of(gather.model, virtual_node.slot))])
        solve_virtual_node(virtual_node);
    }
  }

  void solve_virtual_node(const ElementNode& node) const {
    const CutElementView& view = gather.cut_elements.view;
    const std::span<const ContactTerm> terms =
        points ? terms_of(*points, node.corner, 1) : std::span<const ContactTerm>();
    const bool is_loaded = !terms.empty() || !terms_of(gather.springs, node.corner, 1).empty();
    if (!is_loaded || !(gather.nodes.w[node.slot] > 0)) return gather.cut_elements.solve(node);
    // springs and contacts
    NodeSystem system = gather.virtual_node(node);
    add_contacts(terms, contacts, forces_at_points, system);
    view.move(node, system);
  }

  /// Adds contacts to the systems of their nodes.
  void add_contacts_of_nodes(std::span<NodeContact> node_contacts, int slot, SystemBuffer& buffer) const {
    for (std::size_t begin = 0, end = 0; begin < node_contacts.size(); begin = end) {
      while (end < node_contacts.size() && node_contacts[end].slot == node_contacts[begin].slot) end++;
      const int at = node_contacts[begin].slot - slot;
      NodeSystem system = buffer.get(at);
      const int node = node_contacts[begin].slot;
      add_contacts(node_contacts.subspan(begin, end - begin), gather.nodes,
                   inertia(node) - gather.nodes.u(node), inertia.dt * inertia.dt * gather.nodes.w[node],
                   system);
      buffer.set(at, system);
    }
  }

  /// Adds contacts at points to the systems of their corners.
  void add_contacts_at_points(std::span<const ContactTerm> terms, int slot, SystemBuffer& buffer) const {
    for (std::size_t begin = 0, end = 0; begin < terms.size(); begin = end) {
      const int node = terms[begin].corner;
      while (end < terms.size() && terms[end].corner == node) end++;
      NodeSystem system = buffer.get(node - slot);
      add_contacts(terms.subspan(begin, end - begin), contacts, forces_at_points, system);
      buffer.set(node - slot, system);
    }
  }

  /// Stiffens the systems of nodes whose Newton step would end where skin is stiff beyond measure.
  void shorten_steps_of_skin(int slot, int count, SystemBuffer& buffer) const {
    const Anatomy& anatomy = gather.model.anatomy;
    if (anatomy.skin.triangles.empty()) return;
    const auto shorten = [&](int node, const auto& growth_of) {
      const Real c = inertia.dt * inertia.dt * gather.nodes.w[node];
      NodeSystem s = buffer.get(node - slot);
      const Vec3 d = newton_step(s, inertia(node) - gather.nodes.u(node), c);
      const Real growth = growth_of(d);
      if (!(growth > kCheckedGrowth) || c == 0) return;
      shorten_step(s, skin_step_share(growth), c);
      buffer.set(node - slot, s);
    };
    // whole triangles
    const SkinView skin = skin_view(gather.model, gather.state.cuts);
    const int row = slot / anatomy.lattice.half;
    const int* end = skin.nodes + skin.row_begin[row + 1];
    const int* node = std::lower_bound(skin.nodes + skin.row_begin[row], end, slot);
    for (; node != end && *node < slot + count; node++)
      shorten(*node, [&](Vec3 d) {
        return largest_growth(skin, gather.skin, gather.nodes, row, int(node - skin.nodes), d);
      });
    // cut ones
    for (const ElementNode& cut : gather.cut_elements.nodes_of(slot, count))
      shorten(cut.slot, [&](Vec3 d) { return gather.cut_elements.view.largest_growth(cut, d); });
  }

  void solve(int slot, int count, const SystemBuffer& buffer) const {
    int begin = 0;
    for (; begin + 2 * kGroup <= count; begin += 2 * kGroup) solve_lanes<2 * kGroup>(slot, begin, buffer);
    if (begin < count) solve_lanes<kGroup>(slot, begin, buffer);
  }

  /// The same between cells that stiffen: long steps are shortened (law_backtracking.hpp).
  void solve_with_laws(int slot, int count, const SystemBuffer& buffer) const {
    const NodeArrays& n = gather.nodes;
    Real* __restrict ux = n.ux + slot, * __restrict uy = n.uy + slot, * __restrict uz = n.uz + slot;
    const Inertia y = inertia;  // local copy, so that stores cannot alias it
    Real moves[kLanes], dx[kLanes], dy[kLanes], dz[kLanes], length2[kLanes];
    for (int i = 0; i < count; i++) moves[i] = y.moves(slot + i);
    // Newton steps
    TURGOR_LANES
    for (int i = 0; i < count; i++) {
      const Vec3 to_inertial = y.at(slot + i, moves[i]) - Vec3{ux[i], uy[i], uz[i]};
      const Vec3 change = newton_step(buffer.get(i), to_inertial, y.dt * y.dt * y.w[slot + i]);
      dx[i] = change.x, dy[i] = change.y, dz[i] = change.z, length2[i] = dot(change, change);
    }
    // long ones; no other node of the half row shares their cells
    const Vec3 h = gather.model.anatomy.lattice.spacing;
    const Real longest = kCheckedStep * std::min({h.x, h.y, h.z}), limit = longest * longest;
    int has_long = 0;
    for (int i = 0; i < count; i++) has_long |= int(length2[i] > limit) & int(moves[i] != 0);
    for (int i = 0; has_long != 0 && i < count; i++) {
      if (!(length2[i] > limit) || moves[i] == 0) continue;
      const Real share = law_step_share(gather.model, gather.state, *gather.solid.laws, slot + i,
                                        {buffer.get(i), y(slot + i) - n.u(slot + i),
                                         y.dt * y.dt * y.w[slot + i], Vec3{dx[i], dy[i], dz[i]}});
      dx[i] *= share, dy[i] *= share, dz[i] *= share;
    }
    TURGOR_LANES
    for (int i = 0; i < count; i++) ux[i] += dx[i], uy[i] += dy[i], uz[i] += dz[i];
  }

  template <int kWidth>
  void solve_lanes(int first, int begin, const SystemBuffer& buffer) const {
    const NodeArrays& n = gather.nodes;
    const int slot = first + begin;
    Real* __restrict ux = n.ux + slot, * __restrict uy = n.uy + slot, * __restrict uz = n.uz + slot;
    const Inertia y = inertia;  // local copy, so that stores cannot alias it
    Real moves[kWidth];
    for (int i = 0; i < kWidth; i++) moves[i] = y.moves(slot + i);
    TURGOR_LANES
    for (int i = 0; i < kWidth; i++) {
      const Vec3 to_inertial = y.at(slot + i, moves[i]) - Vec3{ux[i], uy[i], uz[i]};
      const Vec3 change = newton_step(buffer.get(begin + i), to_inertial, y.dt * y.dt * y.w[slot + i]);
      ux[i] += change.x, uy[i] += change.y, uz[i] += change.z;
    }
  }

  /// True if a node of the body moved farther than the wake distance (sleep.hpp). Bit patterns of positive
  /// numbers are ordered, and NaN is the largest.
  bool has_moved(int slot, int count) const {
    const NodeArrays& n = gather.nodes;
    const Tissue* __restrict tissue = gather.model.anatomy.tissue.data();
    std::uint32_t found = 0;
    for (int begin = slot; begin < slot + count; begin += kGroup)
      for (int s = begin; s < begin + kGroup; s++) {
        const Real x = n.ux[s] - inertia.bx[s], y = n.uy[s] - inertia.by[s], z = n.uz[s] - inertia.bz[s];
        const Real own = is_body(tissue[s]) ? Real(1) : Real(0);
        const std::uint32_t bits = magnitude_bits(own * (x * x + y * y + z * z));
        found = bits > found ? bits : found;
      }
    return found > std::bit_cast<std::uint32_t>(wake_distance2);
  }
};

/// Stiffness of a corner of a slot with its inertia [N/m].
Real stiffness_of_corner(const GatherSystems& gather, const Inertia& inertia, int corner, int slot) {
  const auto with_inertia = [](const NodeSystem& s, Real mobility) {
    return (s.xx + s.yy + s.zz) / 3 + 1 / mobility;
  };
  if (corner != slot) {
    for (const ElementNode& node : gather.cut_elements.virtual_nodes_of(slot, 1))
      if (node.corner == corner) {
        const NodeSystem system = gather.virtual_node(node);
        return with_inertia(system, weightless_mobility(system));
      }
    return 0;  // a virtual node without elements
  }
  SystemBuffer buffer;
  gather(slot / gather.model.anatomy.lattice.half & 1, slot - slot % kGroup, kGroup, buffer);
  return with_inertia(buffer.get(slot % kGroup), inertia.dt * inertia.dt * gather.nodes.w[slot]);
}

/// Sets the penalties of contacts at points in the first sweep of a step.
void set_penalties(const GatherSystems& gather, const Inertia& inertia, const PointContacts& at_points) {
  for (std::size_t c = 0; c < at_points.contacts.size(); c++)
    if (NodeContact& contact = at_points.contacts[c]; contact.stiffness == 0)
      contact.stiffness = at_points.penalty(
          c, stiffness_of_corner(gather, inertia, at_points.points.leader[c], contact.slot));
}

/// Calls sweep(rows) with the kernel of a sweep, and handles contacts at points and sleep.
template <class Sweep>
void with_vbd_sweep(const Model& model, State& state, const Inputs& inputs, double dt, Order order,
                    CalmRows* calm, const Sweep& sweep) {
  const GatherSystems gather(model, state, inputs);
  const Inertia inertia(model, state, inputs, dt);
  // tests and benches sweep outside of steps, before wake_rows
  const bool sleeps = can_sleep(model) && !state.sleep.awake.empty();
  const Real wake_distance = Real(model.params.solver.sleep_speed * dt);
  if (sleeps && calm) choose_swept_rows(model, state, inputs, *calm);
  // rows that are not swept keep their marks
  if (sleeps)
    for (std::size_t row = 0; row < state.sleep.moved.size(); row++)
      if (!calm || calm->swept[row]) state.sleep.moved[row] = 0;
  VbdSweep rows{gather,
                inertia,
                inputs.contacts,
                inputs.points,
                {},
                order,
                state.sleep,
                sleeps ? wake_distance * wake_distance : Real(-1),
                sleeps ? calm : nullptr};
  if (inputs.points) {
    const PointContacts at_points{inputs.contacts, *inputs.points, gather.cut_elements.view};
    set_penalties(gather, inertia, at_points);
    const std::vector<ContactForce> forces = at_points.forces();
    rows.forces_at_points = forces;
    sweep(rows);
    at_points.update_forces();
  } else {
    sweep(rows);
  }
  if (sleeps) wake_neighbors(model, state);
}

}  // namespace

template <class Run>
void sweep_vbd_by_colors(const Run& run, const Model& model, State& state, const Inputs& inputs, double dt,
                         Order order, CalmRows* calm) {
  with_vbd_sweep(model, state, inputs, dt, order, calm, [&](const VbdSweep& rows) {
    for (int pass = 0; pass < kColorCount; pass++)
      run_half_rows(run, model.anatomy.lattice.size,
                    order == Order::kBackward ? kColorCount - 1 - pass : pass, rows);
  });
}
template void sweep_vbd_by_colors(const CpuRun&, const Model&, State&, const Inputs&, double, Order,
                                  CalmRows*);
template void sweep_vbd_by_colors(const ShuffledRun&, const Model&, State&, const Inputs&, double, Order,
                                  CalmRows*);

void sweep_vbd(const Exec& exec, const Model& model, State& state, const Inputs& inputs, double dt,
               Order order, CalmRows* calm) {
  if (model.params.solver.ordering == Ordering::kColors)
    return sweep_vbd_by_colors(CpuRun{exec}, model, state, inputs, dt, order, calm);
  with_vbd_sweep(model, state, inputs, dt, order, calm, [&](const VbdSweep& rows) {
    sweep_slabs(exec, model.anatomy.owned, rows, order, inputs.halo);
  });
}

Residual measure_residual(const Exec& exec, const Model& model, const State& state, const Inputs& inputs,
                          double dt) {
  TURGOR_ASSERT(model.params.solver.method == Method::kVbd, "only VBD has a residual");
  const GatherSystems gather(model,
                             const_cast<State&>(state),  // node_arrays has one type for reading and writing
                             inputs);
  const Inertia inertia(model, state, inputs, dt);
  std::vector<double> layers(
      2 * std::size_t(model.anatomy.owned.end - model.anatomy.owned.begin));  // ResidualSum by layer
  for_layers(exec, model.anatomy.owned, [&](std::size_t k) {
    SystemBuffer buffer;
    ResidualSum sum;
    // virtual nodes
    for (const ElementNode& virtual_node : gather.cut_elements.virtual_nodes_of(int(k)))
      if (gather.nodes.w[virtual_node.slot] > 0) {
        Vec3 force = gather.virtual_node(virtual_node).f;
        if (inputs.points)
          for (const ContactTerm& t : terms_of(*inputs.points, virtual_node.corner, 1))
            force += inputs.contacts[std::size_t(t.contact)].force * t.weight;
        sum.add(Vec3d(force));
      }
    // elements, contacts and inertia of nodes
    for_each_chunk(model, nullptr, int(k), [&](int parity, int slot, int count) {
      gather(parity, slot, count, buffer);
      const auto add_force = [&](int node, Vec3 force) {
        NodeSystem s = buffer.get(node - slot);
        s.f += force;
        buffer.set(node - slot, s);
      };
      if (inputs.points == nullptr)
        for (const NodeContact& c : contacts_of(inputs.contacts, slot, count)) add_force(c.slot, c.force);
      else
        for (const ContactTerm& t : terms_of(*inputs.points, slot, count))
          add_force(t.corner, inputs.contacts[std::size_t(t.contact)].force * t.weight);
      TURGOR_LANES
      for (int i = 0; i < count; i++) {
        const Real w = gather.nodes.w[slot + i];
        if (w == 0 || state.cuts.removed[std::size_t(slot + i)]) continue;
        sum.add(residual_force(buffer.get(i).f, inertia(slot + i) - gather.nodes.u(slot + i), w, dt));
      }
    });
    double* layer = &layers[2 * (k - std::size_t(model.anatomy.owned.begin))];
    layer[0] = sum.largest2, layer[1] = sum.sum2;
  });
  // sum over layers and processes
  if (inputs.halo) inputs.halo->join_numbers(layers);
  ResidualSum all;
  for (std::size_t n = 0; n < layers.size(); n += 2) all.add({layers[n], layers[n + 1]});
  return {.largest = all.largest(), .rms = all.rms(model.anatomy.free_nodes)};
}

}  // namespace turgor::lattice
