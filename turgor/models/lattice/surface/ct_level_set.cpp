#include "turgor/models/lattice/surface/ct_level_set.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/models/lattice/build/cell_surface.hpp"

namespace turgor::lattice {

namespace {

/// Kinds of the nodes with nonzero interpolation weight at a point.
struct Support {
  bool body = false, air = false,
       opaque = false;  // gas or removed tissue: a CT does not show its surface

  void add(Support other) { body |= other.body, air |= other.air, opaque |= other.opaque; }
};

}  // namespace

CtLevelSet::CtLevelSet(const Model& model, const Cuts& cuts, const FineLattice& fine, const CtVolume* ct)
    : model_(model), cuts_(cuts), fine_(fine) {
  if (ct == nullptr) return;
  sampler_.emplace(*ct);
  if (has_foreign(model.anatomy.surroundings)) slab_.emplace(*ct);
  first_ = index_at(ct->grid, model.anatomy.grid.origin);
  for (int axis = 0; axis < 3; axis++)
    cell_size_[axis] = model.anatomy.grid.spacing[axis] / ct->grid.spacing[axis];
}

Real CtLevelSet::sample(Vec3d position) const {
  const Vec3d voxel = first_ + hadamard(position, cell_size_);
  if (slab_ && is_near_surroundings(voxel))
    return Real(AirLevel{*slab_, model_.anatomy.surroundings, model_.params.tissue.air_max}.at(
        voxel + Vec3d{0.5, 0.5, 0.5}));
  return (*sampler_)(Vec3(voxel)) - Real(model_.params.tissue.air_max);
}

bool CtLevelSet::is_near_surroundings(Vec3d voxel) const {
  const Int3 last = slab_->whole.size - Int3{1, 1, 1};
  const Int3 low{int(std::floor(voxel.x)), int(std::floor(voxel.y)), int(std::floor(voxel.z))};
  for (int c = 0; c < 8; c++)
    if (model_.anatomy.surroundings.kind(
            min(max(low + Int3{c & 1, c >> 1 & 1, c >> 2}, Int3{0, 0, 0}), last)) != kBodyCell)
      return true;
  return false;
}

CellLevels CtLevelSet::operator()(int slot) const {
  const Int3 cell = slot_node(fine_.cells, slot);
  std::array<Real, 8> level, beyond{};  // level of each node, and its difference from a CT of opposite sign
  std::array<Support, 8> corner;
  Support all;
  // levels of the corners, and corrections where the CT contradicts them
  for (int c = 0; c < 8; c++) {
    const Int3 offset = cell_corner(c);
    const int node = slot + slot_offset(fine_.cells, offset, cell.x & 1);
    const auto n = std::size_t(c), s = std::size_t(node);
    level[n] = node_level(model_, cuts_, node);
    const bool gas =
        is_body(model_.anatomy.tissue[s]) && Real(model_.anatomy.hu[s]) < Real(model_.params.tissue.air_max);
    corner[n] = {level[n] > 0, level[n] <= 0, gas || is_removed_tissue(model_, cuts_, node)};
    all.add(corner[n]);
    if (!sampler_) continue;
    const Real sampled = sample(Vec3d(cell + offset));
    if ((sampled > 0) != (level[n] > 0)) beyond[n] = level[n] - sampled;
  }
  // the CT locates the skin in cells with body and air
  const bool sees_skin = sampler_ && all.body && all.air;
  CellLevels out;
  for_sub_nodes(fine_, [&](Int3 p) {
    const Vec3 at{Real(p.x) / Real(fine_.subdivisions.x), Real(p.y) / Real(fine_.subdivisions.y),
                  Real(p.z) / Real(fine_.subdivisions.z)};
    // trilinear level and correction
    const auto weight = trilinear(at);
    Support support;
    Real value = 0, correction = 0;
    for (std::size_t c = 0; c < 8; c++) {
      if (weight[c] == 0) continue;
      support.add(corner[c]);
      value += weight[c] * level[c], correction += weight[c] * beyond[c];
    }
    // corrected CT level, unless no node at this point has its sign
    if (sees_skin && !support.opaque) {
      const Real seen = sample(Vec3d(cell) + Vec3d(at)) + correction;
      if (seen > 0 ? support.body : support.air) value = seen;
    }
    // keep away from zero
    if (value > -1 && value < 1) value = value < 0 ? Real(-1) : Real(1);
    out.at[std::size_t(sub_index(fine_, p))] = value;
  });
  return out;
}

}  // namespace turgor::lattice
