// Building the model and the first state.
#include <cmath>
#include <string>

#include "turgor/core/assert.hpp"
#include "turgor/models/lattice/build/body_nodes.hpp"
#include "turgor/models/lattice/build/skin.hpp"
#include "turgor/models/lattice/build/springs.hpp"
#include "turgor/models/lattice/mechanics/cells.hpp"

namespace turgor::lattice {

namespace {

/// What the paper takes for stiffness: the density, normalised to [0, 1]. [STC 4.2]
double density_stiffness(double hu, const Params& params) {
  const TissueParams& t = params.tissue;
  return params.solver.pbd_stiffness * std::clamp((hu - t.air_max) / (t.bone_min - t.air_max), 0.05, 1.0);
}

/// One layer of nodes from the plain order into slots.
struct PlaceLayer {
  const BodyNodes& nodes;
  const Params& params;
  Model& model;

  void operator()(std::size_t layer) const {
    const int k = int(layer);
    const bool pbd = params.solver.method == Method::kPbd;
    const double volume = sample_volume(nodes.grid);
    for (int j = 0; j < nodes.grid.size.y; j++)
      for (int i = 0; i < nodes.grid.size.x; i++) {
        const std::size_t n = sample_index(nodes.grid, i, j, k);
        const auto slot = std::size_t(node_slot(model.lattice, i, j, k));
        model.tissue[slot] = nodes.tissue[n];
        model.hu[slot] = nodes.hu[n];
        if (!is_body(nodes.tissue[n])) continue;
        const double density =
            std::max(50.0, 1000.0 + nodes.hu[n]);  // water = 1000; gas keeps a little mass [kg/m³]
        model.inverse_mass[slot] = nodes.fixed[n] ? Real(0) : Real(1 / (density * volume));
        model.root_stiffness[slot] =
            Real(std::sqrt(pbd ? density_stiffness(nodes.hu[n], params) : nodes.young[n]));
      }
  }
};

/// Is the slot's node body, and does it share a cell, whose lowest node it is, with a node that can move?
bool joins_what_moves(const Model& model, int slot) {
  if (!is_body(model.tissue[std::size_t(slot)])) return false;
  const int parity = slot % row_stride(model.lattice) >= model.lattice.half;
  for (int x = 0; x < 2; x++)
    for (int y = 0; y < 2; y++)
      for (int z = 0; z < 2; z++)
        if (model.inverse_mass[std::size_t(slot + slot_offset(model.lattice, {x, y, z}, parity))] > 0)
          return true;
  return false;
}

}  // namespace

Result<Model> assemble(const Exec& exec, const BodyNodes& nodes, const VectorVolume* lines,
                       const Params& params) {
  Model model{.params = params,
              .grid = nodes.grid,
              .lattice = make_lattice(nodes.grid.size, Vec3(nodes.grid.spacing)),
              .owned = nodes.owned.end > 0 ? nodes.owned : Layers{0, nodes.grid.size.z}};
  model.lattice.first = nodes.first;
  const auto slots = std::size_t(slot_count(model.lattice));
  model.inverse_mass.assign(slots, 0);
  model.root_stiffness.assign(slots, 0);
  model.tissue.assign(slots, Tissue::kOutside);
  model.hu.assign(slots, kAirHu);
  parallel_for(exec, std::size_t(nodes.grid.size.z), PlaceLayer{nodes, params, model});

  model.moving =
      find_runs(model.lattice, [&](int slot) { return model.inverse_mass[std::size_t(slot)] > 0; });
  if (params.solver.method == Method::kPbd)
    model.joining = find_runs(model.lattice, [&](int slot) { return joins_what_moves(model, slot); });

  const Vec3 h = model.lattice.step;
  const bool pbd = params.solver.method == Method::kPbd;
  const bool solid = params.tissue.law == TissueLaw::kSolid;
  TURGOR_ASSERT(!(solid && pbd), "projections know springs alone");
  const double volume = solid ? 0 : params.tissue.volume;
  model.spring_scale = calibrate_springs(h, volume);
  for (std::size_t f = 0; f < kFamilyCount; f++) {
    model.rest_length[f] = norm(hadamard(h, Vec3(kFamilies[f])));
    if (pbd) model.spring_scale[f] = 1;
  }
  model.rest_volume = h.x * h.y * h.z / 6;
  model.volume_scale = Real(pbd ? params.solver.pbd_volume : volume);
  if (solid) build_cells(exec, model);

  for (std::size_t n = 0; n < nodes.tissue.size(); n++) {
    model.body_nodes += is_body(nodes.tissue[n]);
    model.free_nodes += is_body(nodes.tissue[n]) && !nodes.fixed[n];
  }
  if (params.skin.enabled) {
    detect_skin(exec, lines, nodes.join_skin, model);
    if (model.skin.triangles.empty() && nodes.owned.end == 0)
      return Error{"the body has no skin: expected a boundary to outside air, found none in " +
                   std::to_string(model.body_nodes) + " body nodes"};
  }
  return model;
}

Result<Model> build(const Exec& exec, const CtVolume& ct, const BodyFields& fields, const Params& params) {
  Result<BodyNodes> nodes = classify(exec, ct, fields.labels, params);
  if (!nodes) return nodes.error();
  return assemble(exec, *nodes, fields.lines, params);
}

State make_state(const Model& model) {
  State state;
  const auto slots = std::size_t(slot_count(model.lattice));
  for (VecField* field : {&state.u, &state.u_before, &state.v}) field->resize(slots);
  state.cut.assign(slots, 0);
  state.removed.assign(slots, 0);
  state.row_cut.assign(slots / std::size_t(row_stride(model.lattice)), 0);
  state.skin_cut.assign(model.skin.triangles.size(), 0);
  return state;
}

}  // namespace turgor::lattice
