// Residual forces of a step, cell by cell.
#include <algorithm>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/models/lattice/coarse/coarse_correction.hpp"
#include "turgor/models/lattice/coarse/coarse_levels.hpp"
#include "turgor/models/lattice/coarse/contact_columns.hpp"
#include "turgor/models/lattice/mechanics/cells.hpp"
#include "turgor/models/lattice/mechanics/contact_points.hpp"
#include "turgor/models/lattice/mechanics/cut_elements.hpp"
#include "turgor/models/lattice/mechanics/law_cells.hpp"
#include "turgor/models/lattice/mechanics/node_forces.hpp"
#include "turgor/models/lattice/mechanics/point_springs.hpp"
#include "turgor/models/lattice/mechanics/skin_queries.hpp"
#include "turgor/models/lattice/solver/inertia.hpp"

namespace turgor::lattice {

namespace {

/// Force field of two consecutive layers of nodes; the even layer is stored first.
struct TwoLayers {
  const Lattice& lattice;
  VecField& field;

  /// Offset from slots of a layer to entries of the field.
  int shift(int k) const { return (k & 1) * layer_stride(lattice) - row_slot(lattice, -1, k); }
  void add(int slot, int k, Vec3 f) const {
    const auto at = std::size_t(slot + shift(k));
    field.set(at, field[at] + f);
  }
};

/// Adds the forces of the cells with lowest nodes [slot, slot + kWidth) to their corners.
struct CellForces {
  const Model& model;
  const State& state;
  NodeArrays nodes;
  SolidLaw law;
  CellLawView laws;
  TwoLayers out;

  /// Moduli of the whole cells; 0 for cut cells.
  template <int kWidth>
  void find_young(const NodeBlock& block, int slot, Real (&young)[kWidth]) const {
    for (int i = 0; i < kWidth; i++) young[i] = model.anatomy.cell_young[std::size_t(slot + i)];
    if (!state.cuts.row_cut[std::size_t(slot / row_stride(model.anatomy.lattice))]) return;
    for (int i = 0; i < kWidth; i++)
      young[i] =
          cell_modulus(young[i], cut_edges_of_cell(nodes.cut, block, slot + i, 0), nodes.cut[slot + i]).young;
  }

  /// True if the filled part of one of the cells has its center elsewhere.
  bool has_partial_cell(int slot, int width) const {
    if (model.anatomy.cell_center.empty()) return false;
    std::uint32_t any = 0;
    for (int i = 0; i < width; i++) any |= model.anatomy.cell_center[std::size_t(slot + i)];
    return any != 0;
  }

  /// The same for cells with laws of their own.
  template <int kWidth>
  void add_law_cells(const NodeBlock& block, int slot, int k) const {
    Real young[kWidth];
    find_young<kWidth>(block, slot, young);
    LawCornerForces<kWidth> f;
    law_corner_forces(nodes, laws, block, young, slot, f);
    for (int c = 0; c < kCellCorners; c++)
      for (int i = 0; i < kWidth; i++) {
        const auto at = std::size_t(corner_slot(block, slot, 0, c) + out.shift(k + cell_corner(c).z) + i);
        out.field.x[at] += f.x[c][i], out.field.y[at] += f.y[c][i], out.field.z[at] += f.z[c][i];
      }
  }

  template <int kWidth>
  void add_any(const NodeBlock& block, int slot, int k) const {
    if (laws.has_laws())
      add_law_cells<kWidth>(block, slot, k);
    else
      add<kWidth>(block, slot, k);
  }

  template <int kWidth>
  void add(const NodeBlock& block, int slot, int k) const {
    if (has_partial_cell(slot, kWidth))
      add_cells<kWidth, true>(block, slot, k);
    else
      add_cells<kWidth, false>(block, slot, k);
  }

  template <int kWidth, bool kPartial>
  void add_cells(const NodeBlock& block, int slot, int k) const {
    // moduli
    Real young[kWidth];
    find_young<kWidth>(block, slot, young);
    // forces on the corners of each cell
    [[maybe_unused]] const std::uint32_t* center = model.anatomy.cell_center.data();
    const SolidLaw by = law;
    const NodeArrays n = nodes;
    Real *fx = out.field.x.data(), *fy = out.field.y.data(), *fz = out.field.z.data();
    int corner[kCellCorners];
    for (int c = 0; c < kCellCorners; c++) corner[c] = corner_slot(block, 0, 0, c);
    Real px[kCellCorners][kWidth], py[kCellCorners][kWidth], pz[kCellCorners][kWidth];
    TURGOR_LANES
    for (int i = 0; i < kWidth; i++) {
      const int a = slot + i;
      Vec3 d[kCellCorners];
#pragma GCC unroll 8
      for (int c = 0; c < kCellCorners; c++) d[c] = n.u(a + corner[c]) - n.u(a);
      [[maybe_unused]] Vec3 point;
      CellStress stress;
      if constexpr (kPartial) {
        point = CellCenter{center[a]}.in_half_cells();
        stress = cell_stress_at(d, by, young[i], point);
      } else {
        stress = cell_stress(d, by, young[i]);
      }
#pragma GCC unroll 8
      for (int c = 0; c < kCellCorners; c++) {
        Vec3 f;
        if constexpr (kPartial)
          f = corner_force_at(stress, d[c], c, point);
        else
          f = corner_force(stress, d[c], c);
        px[c][i] = f.x, py[c][i] = f.y, pz[c][i] = f.z;
      }
    }
    // add to the nodes
    for (int c = 0; c < kCellCorners; c++)
      for (int i = 0; i < kWidth; i++) {
        const int at = slot + corner[c] + out.shift(k + cell_corner(c).z) + i;
        fx[at] += px[c][i], fy[at] += py[c][i], fz[at] += pz[c][i];
      }
  }

  void operator()(const Runs& cells, int k) const {
    const Lattice& l = model.anatomy.lattice;
    for (int parity = 0; parity < 2; parity++) {
      const NodeBlock block = node_block(l, parity);
      for (int j = 0; j + 1 < l.size.y; j++)
        for (const Run run : cells.of_half_row(row_slot(l, j, k) / l.half + parity)) {
          int begin = 0;
          for (; begin + 2 * kGroup <= run.count; begin += 2 * kGroup)
            add_any<2 * kGroup>(block, run.begin + begin, k);
          if (begin < run.count) add_any<kGroup>(block, run.begin + begin, k);
        }
    }
  }
};

/// Initializes a layer with inertial forces m (y − u)/h²; 0 at fixed nodes.
void begin_layer(const Model& model, const Inertia& inertia, const Motion& motion, int k, TwoLayers out) {
  const Lattice& l = model.anatomy.lattice;
  const int shift = out.shift(k);
  for (auto* axis : {&out.field.x, &out.field.y, &out.field.z})
    std::fill_n(axis->begin() + shift + row_slot(l, -1, k), layer_stride(l), Real(0));
  const auto begin_group = [&](int slot) {
    Real *fx = out.field.x.data(), *fy = out.field.y.data(), *fz = out.field.z.data();
    const Real *ux = motion.u.x.data(), *uy = motion.u.y.data(), *uz = motion.u.z.data();
    const Inertia y = inertia;
    TURGOR_LANES
    for (int s = slot; s < slot + kGroup; s++) {
      const Vec3 f = y.force(s, {ux[s], uy[s], uz[s]});
      fx[s + shift] = f.x, fy[s + shift] = f.y, fz[s + shift] = f.z;
    }
  };
  for_each_chunk(model, nullptr, k, [&](int, int slot, int count) {
    for (int begin = 0; begin < count; begin += kGroup) begin_group(slot + begin);
  });
}

/// Adds the patches of the cells between layers k and k + 1.
void add_patches(const Model& model, const Cuts& cuts, const NodeArrays& nodes, const SkinForces& skin, int k,
                 TwoLayers out) {
  const Lattice& l = model.anatomy.lattice;
  const std::span<const SkinPatch> patches = patches_of_cells(model, {k, k + 1});
  const std::uint8_t* cut = cuts.skin_cut.data() + (patches.data() - model.anatomy.skin.patches.data());
  PatchForces forces;
  for (std::size_t first = 0; first < patches.size(); first += kSkinLanes) {
    const std::size_t count = std::min(patches.size() - first, std::size_t(kSkinLanes));
    skin.compute_forces(patches.subspan(first, count), l, nodes, forces);
    for (std::size_t i = 0; i < count; i++) {
      if (cut[first + i]) continue;
      const int cell = patches[first + i].cell, parity = slot_node(l, cell).x & 1;
      for (int c = 0; c < kCellCorners; c++)
        out.add(cell + skin.offset.of[parity][c], k + cell_corner(c).z, forces.get(c, int(i)));
    }
  }
}

/// Adds skin of the cells between layers k and k + 1.
void add_skin(const Model& model, const Cuts& cuts, const NodeArrays& nodes, const SkinForces& skin, int k,
              TwoLayers out) {
  const int above = row_slot(model.anatomy.lattice, -1, k + 1);
  if (!model.anatomy.skin.patches.empty()) return add_patches(model, cuts, nodes, skin, k, out);
  const std::span<const SkinTriangle> triangles = skin_of_cells(model, {k, k + 1});
  const std::uint8_t* cut = cuts.skin_cut.data() + (triangles.data() - model.anatomy.skin.triangles.data());
  TURGOR_CHECK(cuts.skin_cut.size() == model.anatomy.skin.triangles.size(), "every skin triangle has a mark");
  TriangleForces forces;
  for (std::size_t first = 0; first < triangles.size(); first += kSkinLanes) {
    const std::size_t count = std::min(std::size_t(kSkinLanes), triangles.size() - first);
    skin.compute_forces(triangles.subspan(first, count), nodes, forces);
    for (std::size_t i = 0; i < count; i++)
      for (int c = 0; c < 3 && !cut[first + i]; c++) {
        const int slot = triangles[first + i].vertex[c];
        out.add(slot, slot < above ? k : k + 1, forces.get(c, int(i)));
      }
  }
}

/// Adds prestress of the skin and forces of cut elements.
void add_prestress_and_cut_elements(const Model& model, const CutElementForces& cut_elements, int k,
                                    TwoLayers out, std::vector<VirtualNodeDisplacement>& virtual_nodes) {
  const Lattice& l = model.anatomy.lattice;
  const int begin = row_slot(l, -1, k), end = begin + layer_stride(l);
  const Skin& skin = model.anatomy.skin;
  if (!skin.triangles.empty())
    for (int n = skin.row_begin[std::size_t(begin / l.half)]; n < skin.row_begin[std::size_t(end / l.half)];
         n++)
      out.add(skin.nodes[std::size_t(n)], k, -model.prestress_force[std::size_t(n)]);
  for (const ElementNode& node : cut_elements.nodes_of(begin, end - begin))
    out.add(node.slot, k, cut_elements.gather(node).f);
  for (const ElementNode& virtual_node : cut_elements.virtual_nodes_of(k)) {
    TURGOR_CHECK(is_index(virtual_node.corner - slot_count(l), virtual_nodes.size()),
                 "a virtual node has a residual");
    const Vec3 f = cut_elements.gather(virtual_node).f;
    virtual_nodes[std::size_t(virtual_node.corner - slot_count(l))] = {f.x, f.y, f.z};
  }
}

/// Adds springs at points.
void add_springs_at_points(const Model& model, const CutElementForces& cut_elements,
                           const PointSprings* springs, int k, TwoLayers out,
                           std::vector<VirtualNodeDisplacement>& virtual_nodes) {
  if (springs == nullptr) return;
  const Lattice& l = model.anatomy.lattice;
  const int begin = row_slot(l, -1, k);
  const auto u = [&](int corner) { return cut_elements.view.u(corner); };
  const auto force = [&](std::span<const PointSpringTerm> terms) {
    NodeSystem s;
    add_point_springs(s, *springs, terms, u);
    return s.f;
  };
  const std::span<const PointSpringTerm> terms = terms_of(springs, begin, layer_stride(l));
  for (std::size_t n = 0; n < terms.size(); n++)
    if (cut_elements.nodes.w[terms[n].corner] > 0) out.add(terms[n].corner, k, force(terms.subspan(n, 1)));
  for (const ElementNode& node : cut_elements.virtual_nodes_of(k))
    virtual_nodes[std::size_t(node.corner - slot_count(l))].move(force(terms_of(springs, node.corner, 1)));
}

/// Adds contacts.
void add_contacts(const Model& model, const CutElementForces& cut_elements, const Inputs& inputs,
                  std::span<const ContactForce> forces, int k, TwoLayers out,
                  std::vector<VirtualNodeDisplacement>& virtual_nodes) {
  const Lattice& l = model.anatomy.lattice;
  const int begin = row_slot(l, -1, k);
  if (inputs.points == nullptr) {
    for (const NodeContact& c : contacts_of(inputs.contacts, begin, layer_stride(l)))
      out.add(c.slot, k, forces[std::size_t(&c - inputs.contacts.data())].force);
    return;
  }
  for (const ContactTerm& t : terms_of(*inputs.points, begin, layer_stride(l)))
    out.add(t.corner, k, forces[std::size_t(t.contact)].force * t.weight);
  for (const ElementNode& node : cut_elements.virtual_nodes_of(k))
    for (const ContactTerm& t : terms_of(*inputs.points, node.corner, 1))
      virtual_nodes[std::size_t(node.corner - slot_count(l))].move(forces[std::size_t(t.contact)].force *
                                                                   t.weight);
}

/// Adds loose edges that begin in a layer. Slots ascend with layers.
void add_loose_edges(const Model& model, const Motion& motion, const CoarseSpace& space, int k,
                     TwoLayers out) {
  const Lattice& l = model.anatomy.lattice;
  const auto root = [&](int slot) { return model.springs.root_stiffness[std::size_t(slot)]; };
  const auto first = [&](int layer) {
    return std::partition_point(space.loose.begin(), space.loose.end(),
                                [&](const UncoveredEdge& e) { return e.slot < row_slot(l, -1, layer); });
  };
  for (auto edge = first(k); edge != first(k + 1); ++edge) {
    const int other = end_of(l, *edge), above = k + kFamilies[std::size_t(edge->family)].z;
    const auto a = std::size_t(edge->slot), b = std::size_t(other), family = std::size_t(edge->family);
    NodeSystem s;
    const Vec3 d = hadamard(l.spacing, Vec3(kFamilies[family])) + (motion.u[b] - motion.u[a]);
    add_spring(s, d, model.springs.rest_length[family],
               model.springs.scale[family] * root(edge->slot) * root(other));
    out.add(edge->slot, k, s.f), out.add(other, above, -s.f);
  }
}

}  // namespace

void visit_residual_forces(const Exec& exec, const Model& model, State& state, const CoarseSpace& space,
                           const Inputs& inputs, double dt, ResidualWorkspace& workspace,
                           const std::function<void(int, int, LayerForces)>& visit) {
  // elements of the body
  workspace.virtual_nodes.assign(state.motion.virtual_u.size(), {});
  TURGOR_CHECK(is_step_length(dt), "a step has a positive length");
  TURGOR_CHECK(space.runs_begin.size() == std::size_t(model.anatomy.lattice.size.z) + 1,
               "the coarse space has runs for every layer");
  workspace.layers.resize(kLayerChunks);
  const Inertia inertia(model, state, inputs, dt);
  const SolidLaw law = solid_law(model.anatomy.lattice.spacing, model.params.tissue.poisson);
  const CellLawView laws = cell_law_view(model, state);
  const SkinForces skin(model);
  const CutElementForces cut_elements(model, state);
  const std::vector<ContactForce> contacts = contact_forces(model, state, inputs);
  const int layers = model.anatomy.lattice.size.z;
  // chunks of layers in parallel
  parallel_for(exec, kLayerChunks, [&](std::size_t chunk) {
    VecField& field = workspace.layers[chunk];
    const auto slots = std::size_t(2 * layer_stride(model.anatomy.lattice) + kSpareSlots);
    if (field.x.size() != slots) field.resize(slots);
    const TwoLayers out{model.anatomy.lattice, field};
    const CellForces cells{model, state, node_arrays(model, state), law, laws, out};
    const auto add_cells = [&](int k) {
      if (k < 0 || k + 1 >= layers) return;
      cells(space.cells, k);
      add_loose_edges(model, state.motion, space, k, out);
      if (!model.anatomy.skin.triangles.empty()) add_skin(model, state.cuts, cells.nodes, skin, k, out);
    };
    // layer below the chunk: its cells also act on the first layer
    const int begin = layers * int(chunk) / kLayerChunks, end = layers * int(chunk + 1) / kLayerChunks;
    if (begin == end) return;
    for (int k = std::max(0, begin - 1); k <= begin; k++) begin_layer(model, inertia, state.motion, k, out);
    add_cells(begin - 1);
    // layers of the chunk
    for (int k = begin; k < end; k++) {
      if (k + 1 < layers) begin_layer(model, inertia, state.motion, k + 1, out);
      add_cells(k);
      add_prestress_and_cut_elements(model, cut_elements, k, out, workspace.virtual_nodes);
      add_springs_at_points(model, cut_elements, inputs.springs, k, out, workspace.virtual_nodes);
      if (!contacts.empty())
        add_contacts(model, cut_elements, inputs, contacts, k, out, workspace.virtual_nodes);
      visit(int(chunk), k, {field, out.shift(k)});
    }
  });
}

}  // namespace turgor::lattice
