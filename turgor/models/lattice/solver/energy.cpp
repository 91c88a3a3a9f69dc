// Energies, in double precision and straight from their definitions: what the sweeps are tested against.
#include <cmath>
#include <vector>

#include "turgor/models/lattice/build/skin.hpp"
#include "turgor/models/lattice/mechanics/cells.hpp"
#include "turgor/models/lattice/solver/sweeps.hpp"

namespace turgor::lattice {

namespace {

/// ∫ k (1 + β max(0, s/r)) s ds from 0: what the amplified force k (1 + β s/r) s has stored at strain s over
/// rest r.
double amplified(double s, double r, double amplification) {
  return s > 0 ? s * s / 2 + amplification * s * s * s / (3 * r) : s * s / 2;
}

struct LayerEnergy {
  const Model& model;
  const State& state;

  Vec3d x(Int3 p) const { return Vec3d(position(model, state, p)); }
  bool is_solid() const { return model.params.tissue.law == TissueLaw::kSolid; }
  double root(Int3 p) const { return model.root_stiffness[std::size_t(node_slot(model.lattice, p))]; }
  bool is_cut(Int3 a, Int3 b) const {
    const bool forward = family_of(b - a) >= 0;
    const int slot = node_slot(model.lattice, forward ? a : b), family = family_of(forward ? b - a : a - b);
    return state.cut[std::size_t(slot)] >> family & 1;
  }

  double solid(Int3 corner) const {
    if (!is_whole_now(model, state, corner)) return 0;
    Vec3d u[kCellCorners];
    for (int n = 0; n < kCellCorners; n++)
      u[n] = Vec3d(state.u[std::size_t(node_slot(model.lattice, corner + cell_corner(n)))]);
    return double(model.cell_young[std::size_t(node_slot(model.lattice, corner))]) *
           cell_energy(u, model.lattice.step, model.params.tissue.poisson);
  }

  double springs(Int3 a) const {
    double sum = 0;
    for (std::size_t f = 0; f < kFamilyCount; f++) {
      const Int3 b = a + kFamilies[f];
      if (!contains(model.lattice, b) || is_cut(a, b)) continue;
      if (is_solid() && is_held_now(model, state, a, kFamilies[f])) continue;
      const double stretch = norm(x(b) - x(a)) - model.rest_length[f];
      sum += 0.5 * model.spring_scale[f] * root(a) * root(b) * stretch * stretch;
    }
    return sum;
  }

  double volumes(Int3 corner) const {
    double sum = 0;
    if (!contains(model.lattice, corner + Int3{1, 1, 1})) return 0;
    for (const auto& tet : kKuhnTets) {
      Int3 p[4];
      for (std::size_t c = 0; c < 4; c++) p[c] = corner + tet[c];
      bool cut = false;
      for (int a = 0; a < 4; a++)
        for (int b = a + 1; b < 4; b++) cut |= is_cut(p[a], p[b]);
      if (cut) continue;
      const double volume = dot(x(p[1]) - x(p[0]), cross(x(p[2]) - x(p[0]), x(p[3]) - x(p[0]))) / 6;
      const double change = volume - model.rest_volume;
      const double k = root(p[1]) > 0 && root(p[2]) > 0 ? model.volume_scale * root(p[0]) * root(p[3]) : 0;
      sum += 0.5 * k * change * change / model.rest_volume;
    }
    return sum;
  }

  double operator()(int k) const {
    double sum = 0;
    for (int j = 0; j < model.lattice.size.y; j++)
      for (int i = 0; i < model.lattice.size.x; i++)
        sum += springs({i, j, k}) + (model.volume_scale > 0 ? volumes({i, j, k}) : 0) +
               (is_solid() ? solid({i, j, k}) : 0);
    return sum;
  }
};

/// A triangle whose corners have moved by u.
double skin_energy(const Model& model, const SkinTriangle& t, const Vec3d (&u)[3]) {
  const SkinParams& p = model.params.skin;
  const Vec3d x[3] = {u[0], Vec3d(t.edge1) + u[1], Vec3d(t.edge2) + u[2]};
  if (p.law == SkinLaw::kArea) {
    const double area = 0.5 * norm(cross(x[1] - x[0], x[2] - x[0])),
                 rest = double(rest_area_ratio(p)) * t.area;
    return p.stiffness / rest * amplified(area - rest, rest, p.amplification);
  }
  const FiberLaw law = fiber_law(p);
  Vec3d along, across;
  for (int c = 0; c < 3; c++) along += x[c] * double(t.along[c]), across += x[c] * double(t.across[c]);
  const double shear = dot(along, across);
  return t.area *
         (p.stiffness * (amplified(norm(along) - law.rest_along, law.rest_along, p.amplification) +
                         amplified(norm(across) - law.rest_across, law.rest_across, p.amplification)) +
          0.5 * p.shear * shear * shear);
}

/// Of what blades parted, and of the skin's pull on it.
double part_energy(const Model& model, const State& state) {
  const int slots = slot_count(model.lattice);
  const auto u = [&](int corner) {
    if (corner < slots) return Vec3d(state.u[std::size_t(corner)]);
    const VirtualNodeShift& c = state.virtual_nodes[std::size_t(corner - slots)];
    return Vec3d{c.x, c.y, c.z};
  };
  double sum = 0;
  for (const CutCellElement& part : state.parts.cells) {
    Vec3d corner[kCellCorners];
    for (std::size_t n = 0; n < kCellCorners; n++) corner[n] = u(part.corner[n]);
    sum += double(part.young) * cell_energy(corner, model.lattice.step, model.params.tissue.poisson);
  }
  for (const CutSkinElement& part : state.parts.skin)
    sum += double(part.share) * skin_energy(model, model.skin.triangles[std::size_t(part.triangle)],
                                            {u(part.corner.x), u(part.corner.y), u(part.corner.z)});
  for (const auto* list : {&state.parts.nodes, &state.parts.virtual_nodes})
    for (const ElementNode& node : *list) sum += dot(Vec3d(node.pull), u(node.corner));
  return sum;
}

}  // namespace

double energy(const Exec& exec, const Model& model, const State& state) {
  std::vector<double> layers(std::size_t(model.lattice.size.z));
  const LayerEnergy layer_energy{model, state};
  parallel_for(exec, layers.size(), [&](std::size_t k) { layers[k] = layer_energy(int(k)); });
  double sum = 0;
  for (const double layer : layers) sum += layer;
  for (std::size_t t = 0; t < model.skin.triangles.size(); t++) {
    if (state.skin_cut[t]) continue;
    const Int3 v = model.skin.triangles[t].vertex;
    sum += skin_energy(model, model.skin.triangles[t],
                       {Vec3d(state.u[std::size_t(v.x)]), Vec3d(state.u[std::size_t(v.y)]),
                        Vec3d(state.u[std::size_t(v.z)])});
  }
  sum += part_energy(model, state);
  for (std::size_t at = 0; at < model.skin.pull.size(); at++)
    sum += dot(Vec3d(model.skin.pull[at]), Vec3d(state.u[std::size_t(model.skin.nodes[at])]));
  return sum;
}

double step_energy(const Exec& exec, const Model& model, const State& state, const Inputs& inputs,
                   double dt) {
  double sum = energy(exec, model, state);
  const Vec3d gravity(lattice_gravity(model, inputs));
  for (std::size_t s = 0; s < model.inverse_mass.size(); s++) {
    if (model.inverse_mass[s] == 0 || state.removed[s]) continue;
    const Vec3d y = Vec3d(state.u_before[s]) + Vec3d(state.v[s]) * dt + gravity * (dt * dt);
    const Vec3d lack = Vec3d(state.u[s]) - y;
    sum += 0.5 * dot(lack, lack) / (double(model.inverse_mass[s]) * dt * dt);
  }
  return sum;
}

}  // namespace turgor::lattice
