// Assembly of a model from its nodes: storage, springs or cells, skin.
#include <cmath>
#include <string>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/models/lattice/build/body_nodes.hpp"
#include "turgor/models/lattice/build/cell_laws.hpp"
#include "turgor/models/lattice/build/partial_cells.hpp"
#include "turgor/models/lattice/build/skin.hpp"
#include "turgor/models/lattice/build/springs.hpp"
#include "turgor/models/lattice/mechanics/cells.hpp"

namespace turgor::lattice {

namespace {

/// Stiffness of the paper: the density, normalized to [0, 1]. [STC 4.2]
double density_stiffness(double hu, const Params& params) {
  const TissueParams& t = params.tissue;
  return params.solver.pbd_stiffness * std::clamp((hu - t.air_max) / (t.bone_min - t.air_max), 0.05, 1.0);
}

/// Copies one layer of nodes to its slots.
struct StoreLayer {
  const BodyNodes& nodes;
  const std::vector<std::uint8_t>& fixed;
  const Params& params;
  Model& model;

  void operator()(std::size_t layer) const {
    const int k = int(layer);
    const bool pbd = params.solver.method == Method::kPbd;
    const double volume = sample_volume(nodes.grid);
    for (int j = 0; j < nodes.grid.size.y; j++)
      for (int i = 0; i < nodes.grid.size.x; i++) {
        const std::size_t n = sample_index(nodes.grid, i, j, k);
        const auto slot = std::size_t(node_slot(model.anatomy.lattice, i, j, k));
        model.anatomy.tissue[slot] = nodes.tissue[n];
        model.anatomy.hu[slot] = nodes.hu[n];
        if (!nodes.label.empty()) model.anatomy.label[slot] = nodes.label[n];
        const bool is_rim = !is_body(nodes.tissue[n]) && nodes.young[n] > 0;
        if (!is_body(nodes.tissue[n]) && !is_rim) continue;
        // water = 1000; gas keeps a small mass, a rim node that of the body in its block or of air [kg/m³]
        const double density = std::max(is_rim ? 1.0 : 50.0, 1000.0 + nodes.hu[n]);
        model.anatomy.inverse_mass[slot] = fixed[n] ? Real(0) : Real(1 / (density * volume));
        if (!is_rim)
          model.springs.root_stiffness[slot] =
              Real(std::sqrt(pbd ? density_stiffness(nodes.hu[n], params) : nodes.young[n]));
      }
  }
};

/// True if the node of a slot is body, and its cell (as lowest node) contains a free node.
bool shares_cell_with_free_node(const Model& model, int slot) {
  if (!is_body(model.anatomy.tissue[std::size_t(slot)])) return false;
  const int parity = slot % row_stride(model.anatomy.lattice) >= model.anatomy.lattice.half;
  for (int x = 0; x < 2; x++)
    for (int y = 0; y < 2; y++)
      for (int z = 0; z < 2; z++)
        if (model.anatomy
                .inverse_mass[std::size_t(slot + slot_offset(model.anatomy.lattice, {x, y, z}, parity))] > 0)
          return true;
  return false;
}

}  // namespace

Result<Model> assemble(const Exec& exec, const BodyNodes& nodes, const VectorVolume* lines,
                       const Params& params) {
  TURGOR_ASSERT(nodes.tissue.size() == sample_count(nodes.grid) && nodes.hu.size() == nodes.tissue.size(),
                "every node has a tissue and a CT value");
  TURGOR_ASSERT(nodes.young.size() == nodes.tissue.size() && nodes.fixed.size() == nodes.tissue.size(),
                "every node has a modulus and a mark");
  // storage
  Model model{.params = params,
              .anatomy = {.grid = nodes.grid,
                          .lattice = make_lattice(nodes.grid.size, Vec3(nodes.grid.spacing)),
                          .owned = nodes.owned.end > 0 ? nodes.owned : Layers{0, nodes.grid.size.z}}};
  model.anatomy.lattice.first = nodes.first;
  const auto slots = std::size_t(slot_count(model.anatomy.lattice));
  model.anatomy.inverse_mass.assign(slots, 0);
  model.springs.root_stiffness.assign(slots, 0);
  model.anatomy.tissue.assign(slots, Tissue::kOutside);
  model.anatomy.hu.assign(slots, kAirHu);
  model.anatomy.regions = nodes.regions, model.anatomy.surroundings = nodes.surroundings;
  if (!nodes.label.empty()) model.anatomy.label.assign(slots, 0);
  const std::vector<std::uint8_t> fixed = fixed_with_rim(exec, nodes);
  parallel_for(exec, std::size_t(nodes.grid.size.z), StoreLayer{nodes, fixed, params, model});

  TURGOR_CHECK(all_finite(model.anatomy.inverse_mass) && all_finite(model.springs.root_stiffness),
               "masses and moduli are finite");
  // free nodes and active constraints
  model.anatomy.free_runs = find_runs(
      model.anatomy.lattice, [&](int slot) { return model.anatomy.inverse_mass[std::size_t(slot)] > 0; });
  if (params.solver.method == Method::kPbd)
    model.pbd.constraint_runs =
        find_runs(model.anatomy.lattice, [&](int slot) { return shares_cell_with_free_node(model, slot); });

  // springs, volumes or cells
  const Vec3 h = model.anatomy.lattice.spacing;
  const bool pbd = params.solver.method == Method::kPbd;
  const bool solid = params.tissue.law == TissueLaw::kSolid;
  TURGOR_ASSERT(!(solid && pbd), "PBD supports only springs");
  const double volume = solid ? 0 : params.tissue.volume;
  model.springs.scale = calibrate_springs(h, volume);
  for (std::size_t f = 0; f < kFamilyCount; f++) {
    model.springs.rest_length[f] = norm(hadamard(h, Vec3(kFamilies[f])));
    if (pbd) model.springs.scale[f] = 1;
  }
  model.springs.rest_volume = h.x * h.y * h.z / 6;
  model.springs.volume_scale = Real(pbd ? params.solver.pbd_volume : volume);
  if (solid) build_cells(exec, nodes.fill, model);
  set_cell_laws(exec, nodes, model);

  // counts
  for (std::size_t n = 0; n < nodes.tissue.size(); n++) {
    model.anatomy.body_nodes += is_body(nodes.tissue[n]);
    model.anatomy.free_nodes += is_body(nodes.tissue[n]) && !nodes.fixed[n];
  }
  // skin
  if (params.skin.enabled) {
    detect_skin(exec, nodes.surface, lines, nodes.join_skin, model);
    if (model.anatomy.skin.triangles.empty() && nodes.owned.end == 0)
      return Error{"the body has no skin: expected a boundary to outside air, found none in " +
                   std::to_string(model.anatomy.body_nodes) + " body nodes"};
  }
  return model;
}

}  // namespace turgor::lattice
