// Elements, virtual nodes and contacts of VBD in device memory.
#pragma once

#include <algorithm>
#include <span>
#include <utility>
#include <vector>

#include "turgor/core/device_arrays.hpp"
#include "turgor/models/lattice/device/device_nodes.hpp"
#include "turgor/models/lattice/solver/vbd_kernels.hpp"

namespace turgor::lattice {

template <class Backend>
struct DeviceVbd {
  template <class T>
  using Array = typename Backend::template Array<T>;
  template <class T>
  using List = DeviceList<Backend, T>;

  Array<Real> young;
  Array<std::uint32_t> center;
  Array<std::uint8_t> row_cut, is_listed;
  ListedNodes listed_nodes;
  List<int> listed;
  Array<int> skin_nodes, corner_begin, row_begin, lanes_begin;
  Array<Vec3> prestress_force;
  Array<SkinCorners> corners;
  Array<SkinPatch> patches;
  Array<PatchCorners> patch_corners;
  SkinParams uploaded_skin;  // skin parameters of the uploaded prestress
  List<CutCellElement> cells;
  List<CutSkinElement> cut_skin_elements;
  List<NodeElementReference> references;
  List<ElementNode> element_nodes, virtual_nodes;
  ColorBegin virtual_nodes_of_color;
  List<VirtualNodeDisplacement> shifts, shifts_before;
  List<NodeContact> contacts;
  List<ResidualSum> residual;

  DeviceVbd(DeviceAllocator<Backend>& allocator, const Model& m)
      : young(allocator.copy(m.anatomy.cell_young)),
        center(allocator.copy(m.anatomy.cell_center)),
        row_cut(allocator.template allocate<std::uint8_t>(m.anatomy.inverse_mass.size() /
                                                          std::size_t(2 * m.anatomy.lattice.half))),
        is_listed(allocator.template allocate<std::uint8_t>(m.anatomy.inverse_mass.size())),
        skin_nodes(allocator.copy(m.anatomy.skin.nodes)),
        corner_begin(allocator.copy(m.vbd.corner_begin)),
        row_begin(allocator.copy(m.anatomy.skin.row_begin)),
        lanes_begin(allocator.copy(m.vbd.lanes_begin)),
        prestress_force(allocator.copy(m.prestress_force)),
        corners(allocator.copy(m.vbd.corners)),
        patches(allocator.copy(m.anatomy.skin.patches)),
        patch_corners(allocator.copy(m.vbd.patch_corners)),
        uploaded_skin(m.params.skin) {}

  void upload_cuts(const Model& model, const Cuts& cuts, const CutElements& elements,
                   std::span<const VirtualNodeDisplacement> virtual_u,
                   std::span<const VirtualNodeDisplacement> virtual_u_before) {
    row_cut.upload(cuts.row_cut);
    upload_listed(list_nodes(model, cuts.row_cut, {}));
    cells.assign(elements.cells), cut_skin_elements.assign(elements.skin),
        references.assign(elements.references);
    upload_element_nodes(model, elements);
    shifts.assign(virtual_u), shifts_before.assign(virtual_u_before);
    shifts_before.resize(virtual_u.size());
  }
  void upload_element_nodes(const Model& model, const CutElements& elements) {
    element_nodes.assign(elements.nodes);
    const VirtualNodeOrdering ordering = virtual_node_ordering(model, elements);
    virtual_nodes.assign(ordering.virtual_nodes), virtual_nodes_of_color = ordering.virtual_nodes_of_color;
  }
  void upload_listed(ListedNodes nodes) {
    listed_nodes = std::move(nodes);
    is_listed.upload(listed_nodes.is_listed), listed.assign(listed_nodes.slots);
  }
  /// Uploads contacts, and lists their nodes.
  void upload_contacts(const Model& model, std::span<const NodeContact> now) {
    contacts.assign(now);
    const auto is_listed_node = [&](const NodeContact& c) {
      return listed_nodes.is_listed[std::size_t(c.slot)] != 0 ||
             !(model.anatomy.inverse_mass[std::size_t(c.slot)] > 0);
    };
    if (std::all_of(now.begin(), now.end(), is_listed_node)) return;
    std::vector<int> in_contact;
    for (const NodeContact& c : now) in_contact.push_back(c.slot);
    std::vector<std::uint8_t> cut(row_cut.size());
    row_cut.download(cut);
    upload_listed(list_nodes(model, cut, in_contact));
  }
  /// Uploads the prestress force again if the skin parameters changed.
  void update_prestress(const Model& model) {
    if (uploaded_skin == model.params.skin) return;
    prestress_force.upload(model.prestress_force);
    uploaded_skin = model.params.skin;
  }
  VbdView view(const Model& model, const DeviceNodes<Backend>& nodes, const Inputs& inputs, double dt) const {
    const FreeNodes body = nodes.view();
    const Vec3 fall = lattice_gravity(model, inputs) * Real(dt * dt);
    return {.rules = vbd_rules(model),
            .body = body,
            .free_groups_of_color = nodes.free_groups_of_color,
            .inertia = Inertia(body, fall, Real(dt)),
            .young = model.params.tissue.law == TissueLaw::kSolid ? young.data() : nullptr,
            .center = center.size() > 0 ? center.data() : nullptr,
            .row_cut = row_cut.data(),
            .is_listed = is_listed.data(),
            .listed = listed.data(),
            .listed_of_color = listed_nodes.of_color,
            .skin = {.nodes = skin_nodes.size() > 0 ? skin_nodes.data() : nullptr,
                     .corner_begin = corner_begin.data(),
                     .row_begin = row_begin.data(),
                     .lanes_begin = lanes_begin.data(),
                     .prestress_force = prestress_force.data(),
                     .corners = corners.data(),
                     .patches = patches.size() > 0 ? patch_corners.data() : nullptr,
                     .skin_cut = nodes.skin_cut.data()},
            .cut_elements = {.nodes = body.nodes,
                             .slots = body.slots,
                             .virtual_nodes = shifts.data(),
                             .cells = cells.data(),
                             .cut_skin_elements = cut_skin_elements.data(),
                             .references = references.data(),
                             .triangles = nodes.triangles.data(),
                             .patches = patches.data(),
                             .center = center.size() > 0 ? center.data() : nullptr,
                             .solid = solid_law(model.anatomy.lattice.spacing, model.params.tissue.poisson),
                             .skin = SkinForces(model)},
            .virtual_nodes_before = shifts_before.data(),
            .element_nodes = element_nodes.data(),
            .virtual_nodes = virtual_nodes.data(),
            .element_node_count = int(element_nodes.count),
            .virtual_node_count = int(shifts.count),
            .virtual_nodes_of_color = virtual_nodes_of_color,
            .contacts = contacts.data(),
            .contact_count = int(contacts.count),
            .residual = nullptr};
  }
};

}  // namespace turgor::lattice
