// Cells with laws of their own in cut bodies.
#include "turgor/models/lattice/mechanics/law_cells.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/models/lattice/wounded_block.hpp"
#include "turgor/models/lattice/mechanics/cut_elements.hpp"

namespace turgor::lattice {
namespace {

const Exec kBothCores(2);

/// Layers that stiffen, under tense skin.
Params layered_params(double stiffening) {
  Params params = solid_params(10, 4, 45);
  params.tissue.energy = SolidEnergy::kExponential;
  params.tissue.stiffening = stiffening;
  params.tissue.layers = {{"upper", 0.006, {}, 9e3, 0.3, stiffening}, {"lower", 0, {}, 4e3, 0.4, 0}};
  return params;
}

// The force on a virtual node of cut cells in layers is the negative gradient of the body's energy.
TEST(LatticeLawCells, CutCellsKeepTheirLayer) {
  Params params = layered_params(6);
  params.tissue.muscle = 5e3;  // modulus of the block
  Wounded body(0.3, 0.2, 20, params);
  scatter(body.model, body.state, 4e-4);
  const CutElementForces forces(body.model, body.state);
  std::size_t checked = 0;
  for (std::size_t n = 0; n < body.state.cut_elements.virtual_nodes.size(); n += 23) {
    const ElementNode& node = body.state.cut_elements.virtual_nodes[n];
    const Vec3d found(forces.gather(node).f);
    const auto at = std::size_t(node.corner - slot_count(body.model.anatomy.lattice));
    for (int axis = 0; axis < 3; axis++) {
      const auto energy_at = [&](Real shift) {
        State moved = body.state;
        VirtualNodeDisplacement& u = moved.motion.virtual_u[at];
        u.move(Vec3{axis == 0 ? shift : 0, axis == 1 ? shift : 0, axis == 2 ? shift : 0});
        return energy(kBothCores, body.model, moved);
      };
      EXPECT_NEAR(found[axis], -(energy_at(1e-5f) - energy_at(-1e-5f)) / 2e-5, 0.01 * norm(found) + 1e-5)
          << "virtual node " << n;
    }
    checked++;
  }
  EXPECT_GT(checked, 2u);
}

}  // namespace
}  // namespace turgor::lattice
