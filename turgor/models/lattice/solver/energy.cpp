#include "turgor/models/lattice/solver/energy.hpp"

#include <cmath>
#include <vector>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/models/lattice/mechanics/cells.hpp"
#include "turgor/models/lattice/mechanics/point_springs.hpp"
#include "turgor/models/lattice/mechanics/skin_calibration.hpp"
#include "turgor/models/lattice/mechanics/skin_forces.hpp"
#include "turgor/models/lattice/mechanics/skin_queries.hpp"
#include "turgor/models/lattice/mechanics/solid_laws.hpp"
#include "turgor/models/lattice/solver/sweeps.hpp"

namespace turgor::lattice {

namespace {

/// Integral of the amplified force k (1 + β max(0, s/r)) s over the strain s, divided by k. r: rest value.
double amplified(double s, double r, double amplification) {
  return s > 0 ? s * s / 2 + amplification * s * s * s / (3 * r) : s * s / 2;
}

/// Energy of a cell or of a cut-cell element with modulus `young` [J].
double energy_of_cell(const Model& model, std::size_t slot, double young, const Vec3d (&u)[kCellCorners],
                      Vec3d center = {}) {
  const Vec3 spacing = model.anatomy.lattice.spacing;
  const TissueParams& tissue = model.params.tissue;
  const CellLaws& laws = model.anatomy.cell_laws;
  if (laws.shear.empty()) return young * cell_energy(u, spacing, tissue.poisson, center);
  const CellDeformation d = cell_deformation(u, spacing);
  LawModuli m{young * laws.shear[slot], young * laws.bulk[slot], laws.stiffening[slot]};
  if (!laws.fiber.empty()) {
    m.fiber = young * laws.fiber[slot], m.fiber_stiffening = laws.fiber_stiffening[slot];
    m.direction = {laws.fiber_x[slot], laws.fiber_y[slot], laws.fiber_z[slot]};
  }
  const double diagonal2 = dot(Vec3d(spacing), Vec3d(spacing));
  const SolidEnergy energy = laws.energy.empty() ? tissue.energy : SolidEnergy(laws.energy[slot]);
  return law_energy(energy, d.f, m) + m.shear * hourglass_over_shear(energy) / diagonal2 * d.hourglass / 16;
}

struct LayerEnergy {
  const Model& model;
  const State& state;

  Vec3d x(Int3 p) const { return Vec3d(position(model, state.motion, p)); }
  bool is_solid() const { return model.params.tissue.law == TissueLaw::kSolid; }
  double root(Int3 p) const {
    return model.springs.root_stiffness[std::size_t(node_slot(model.anatomy.lattice, p))];
  }
  bool is_cut(Int3 a, Int3 b) const {
    const bool forward = family_of(b - a) >= 0;
    const int slot = node_slot(model.anatomy.lattice, forward ? a : b),
              family = family_of(forward ? b - a : a - b);
    return state.cuts.cut[std::size_t(slot)] >> family & 1;
  }

  double solid(Int3 corner) const {
    if (!is_whole_cell(model, state.cuts, corner)) return 0;
    Vec3d u[kCellCorners];
    for (int n = 0; n < kCellCorners; n++)
      u[n] = Vec3d(state.motion.u[std::size_t(node_slot(model.anatomy.lattice, corner + cell_corner(n)))]);
    const auto slot = std::size_t(node_slot(model.anatomy.lattice, corner));
    const CellCenter center{model.anatomy.cell_center.empty() ? 0 : model.anatomy.cell_center[slot]};
    return energy_of_cell(model, slot, double(model.anatomy.cell_young[slot]), u,
                          Vec3d(center.in_half_cells()));
  }

  double springs(Int3 a) const {
    double sum = 0;
    if (root(a) == 0) return sum;
    for (std::size_t f = 0; f < kFamilyCount; f++) {
      const Int3 b = a + kFamilies[f];
      if (!contains(model.anatomy.lattice, b) || root(b) == 0 || is_cut(a, b)) continue;
      if (is_solid() && is_edge_covered(model, state.cuts, a, kFamilies[f])) continue;
      const double stretch = norm(x(b) - x(a)) - model.springs.rest_length[f];
      sum += 0.5 * model.springs.scale[f] * root(a) * root(b) * stretch * stretch;
    }
    return sum;
  }

  double volumes(Int3 corner) const {
    double sum = 0;
    if (!contains(model.anatomy.lattice, corner + Int3{1, 1, 1})) return 0;
    for (const auto& tet : kKuhnTets) {
      Int3 p[4];
      for (std::size_t c = 0; c < 4; c++) p[c] = corner + tet[c];
      // skip cut tetrahedra
      bool cut = false;
      for (int a = 0; a < 4; a++)
        for (int b = a + 1; b < 4; b++) cut |= is_cut(p[a], p[b]);
      if (cut) continue;
      // energy of the volume
      const double volume = dot(x(p[1]) - x(p[0]), cross(x(p[2]) - x(p[0]), x(p[3]) - x(p[0]))) / 6;
      const double change = volume - model.springs.rest_volume;
      const double k =
          root(p[1]) > 0 && root(p[2]) > 0 ? model.springs.volume_scale * root(p[0]) * root(p[3]) : 0;
      sum += 0.5 * k * change * change / model.springs.rest_volume;
    }
    return sum;
  }

  double operator()(int k) const {
    double sum = 0;
    for (int j = 0; j < model.anatomy.lattice.size.y; j++)
      for (int i = 0; i < model.anatomy.lattice.size.x; i++)
        sum += springs({i, j, k}) + (model.springs.volume_scale > 0 ? volumes({i, j, k}) : 0) +
               (is_solid() ? solid({i, j, k}) : 0);
    return sum;
  }
};

/// Energy of the fiber law per area for the images of both unit vectors [J/m²].
double fiber_energy(const SkinParams& p, const FiberLaw& law, Vec3d along, Vec3d across) {
  const double shear = dot(along, across);
  return p.stiffness * (amplified(norm(along) - law.rest_along, law.rest_along, p.amplification) +
                        amplified(norm(across) - law.rest_across, law.rest_across, p.amplification)) +
         0.5 * p.shear * shear * shear;
}

/// Energy of a skin triangle whose corners have the displacements u. Laws: add_skin_area, add_skin_fiber and
/// add_skin_exponential, whose constants are `rest`.
double skin_energy(const Model& model, const ExponentialSkin& rest, const SkinTriangle& t,
                   const Vec3d (&u)[3]) {
  const SkinParams& p = model.params.skin;
  const Vec3d x[3] = {u[0], Vec3d(t.edge1) + u[1], Vec3d(t.edge2) + u[2]};
  // area law
  if (p.law == SkinLaw::kArea) {
    const double area = 0.5 * norm(cross(x[1] - x[0], x[2] - x[0])),
                 rest_area = double(rest_area_ratio(p)) * t.area;
    return p.stiffness / rest_area * amplified(area - rest_area, rest_area, p.amplification);
  }
  Vec3d along, across;
  for (int c = 0; c < 3; c++) along += x[c] * double(t.along[c]), across += x[c] * double(t.across[c]);
  // exponential law
  if (p.law == SkinLaw::kExponential) {
    return double(t.area) * double(rest.rest_share) *
           exponential_skin_energy(p, along * double(rest.along), across * double(rest.across));
  }
  // fiber law
  return t.area * fiber_energy(p, fiber_law(p), along, across);
}

/// Energy of a patch whose cell has corners with the displacements u. Law: add_skin_fibers.
double patch_energy(const Model& model, const SkinPatch& patch, const Vec3d (&u)[kCellCorners]) {
  const SkinParams& p = model.params.skin;
  const FiberLaw law = fiber_law(p);
  const Vec3 slope = solid_law(model.anatomy.lattice.spacing, 0).slope;
  double sum = 0;
  for (int n = 0; n < kPatchPoints; n++) {
    Vec3d along(patch.along), across(patch.across);
    for (int c = 0; c < kCellCorners; c++) {
      const Vec3d g(shape_gradient(c, slope, patch_point(patch, n)));
      along += u[c] * dot(g, Vec3d(patch.along)), across += u[c] * dot(g, Vec3d(patch.across));
    }
    sum += patch.area / kPatchPoints * fiber_energy(p, law, along, across);
  }
  return sum;
}

/// Energy of cut elements and of the prestress at their nodes.
double cut_element_energy(const Model& model, const ExponentialSkin& rest, const State& state) {
  const int slots = slot_count(model.anatomy.lattice);
  const auto u = [&](int corner) {
    TURGOR_CHECK(is_index(corner, std::size_t(slots) + state.motion.virtual_u.size()),
                 "a corner is a node or a virtual node");
    if (corner < slots) return Vec3d(state.motion.u[std::size_t(corner)]);
    const VirtualNodeDisplacement& c = state.motion.virtual_u[std::size_t(corner - slots)];
    return Vec3d{c.x, c.y, c.z};
  };
  double sum = 0;
  // cells
  for (const CutCellElement& element : state.cut_elements.cells) {
    Vec3d corner[kCellCorners];
    for (std::size_t n = 0; n < kCellCorners; n++) corner[n] = u(element.corner[n]);
    const auto slot = std::size_t(element.slot);
    const CellCenter center{model.anatomy.cell_center.empty() ? 0 : model.anatomy.cell_center[slot]};
    sum += energy_of_cell(model, slot, double(element.young), corner, Vec3d(center.in_half_cells()));
    if (element.patch >= 0)
      sum += double(element.skin_share) *
             patch_energy(model, model.anatomy.skin.patches[std::size_t(element.patch)], corner);
  }
  // skin
  for (const CutSkinElement& element : state.cut_elements.skin)
    sum += double(element.share) *
           skin_energy(model, rest, model.anatomy.skin.triangles[std::size_t(element.triangle)],
                       {u(element.corner.x), u(element.corner.y), u(element.corner.z)});
  // prestress
  for (const auto* list : {&state.cut_elements.nodes, &state.cut_elements.virtual_nodes})
    for (const ElementNode& node : *list) sum += dot(Vec3d(node.prestress_force), u(node.corner));
  return sum;
}

}  // namespace

double energy(const Exec& exec, const Model& model, const State& state) {
  TURGOR_CHECK(state.motion.u.x.size() >= std::size_t(slot_count(model.anatomy.lattice)),
               "positions are on the host");
  TURGOR_CHECK(state.cuts.skin_cut.size() >= skin_element_count(model.anatomy.skin),
               "every skin element has a mark");
  // springs, volumes and cells
  std::vector<double> layers(std::size_t(model.anatomy.lattice.size.z));
  const LayerEnergy layer_energy{model, state};
  parallel_for(exec, layers.size(), [&](std::size_t k) { layers[k] = layer_energy(int(k)); });
  double sum = 0;
  for (const double layer : layers) sum += layer;
  // skin
  const ExponentialSkin rest = exponential_skin(model.params.skin);
  const Skin& skin = model.anatomy.skin;
  const CellOffsets offset(model.anatomy.lattice);
  for (std::size_t p = 0; p < skin.patches.size(); p++) {
    if (state.cuts.skin_cut[p]) continue;
    Vec3d u[kCellCorners];
    const int slot = skin.patches[p].cell, parity = slot_node(model.anatomy.lattice, slot).x & 1;
    for (int c = 0; c < kCellCorners; c++)
      u[c] = Vec3d(state.motion.u[std::size_t(slot + offset.of[parity][c])]);
    sum += patch_energy(model, skin.patches[p], u);
  }
  for (std::size_t t = 0; t < skin.triangles.size() && skin.patches.empty(); t++) {
    if (state.cuts.skin_cut[t]) continue;
    const Int3 v = model.anatomy.skin.triangles[t].vertex;
    sum += skin_energy(model, rest, model.anatomy.skin.triangles[t],
                       {Vec3d(state.motion.u[std::size_t(v.x)]), Vec3d(state.motion.u[std::size_t(v.y)]),
                        Vec3d(state.motion.u[std::size_t(v.z)])});
  }
  // cut elements and prestress
  sum += cut_element_energy(model, rest, state);
  for (std::size_t at = 0; at < model.prestress_force.size(); at++)
    sum += dot(Vec3d(model.prestress_force[at]),
               Vec3d(state.motion.u[std::size_t(model.anatomy.skin.nodes[at])]));
  return sum;
}

double step_energy(const Exec& exec, const Model& model, const State& state, const Inputs& inputs,
                   double dt) {
  TURGOR_CHECK(is_step_length(dt), "a step has a positive length");
  double sum = energy(exec, model, state);
  if (inputs.springs)
    for (const PointSpring& spring : inputs.springs->all)
      sum += spring_energy(spring, displacement(spring.at, state.motion));
  const Vec3d gravity(lattice_gravity(model, inputs));
  for (std::size_t s = 0; s < model.anatomy.inverse_mass.size(); s++) {
    if (model.anatomy.inverse_mass[s] == 0 || state.cuts.removed[s]) continue;
    const Vec3d y = Vec3d(state.motion.u_before[s]) + Vec3d(state.motion.v[s]) * dt + gravity * (dt * dt);
    const Vec3d inertial_offset = Vec3d(state.motion.u[s]) - y;
    sum += 0.5 * dot(inertial_offset, inertial_offset) / (double(model.anatomy.inverse_mass[s]) * dt * dt);
  }
  return sum;
}

}  // namespace turgor::lattice
