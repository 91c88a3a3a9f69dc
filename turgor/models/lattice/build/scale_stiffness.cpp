#include "turgor/models/lattice/build/scale_stiffness.hpp"

#include <cmath>

#include "turgor/core/assert.hpp"

namespace turgor::lattice {

void scale_moduli(double factor, Model& model) {
  TURGOR_ASSERT(factor > 0, "a body is stiff");
  const Real root = Real(std::sqrt(factor));
  for (Real& r : model.springs.root_stiffness) r *= root;
  for (Real& young : model.anatomy.cell_young) young *= Real(factor);
}

void scale_stiffness(double factor, Model& model, State& state) {
  scale_moduli(factor, model);
  for (CutCellElement& element : state.cut_elements.cells) element.young *= Real(factor);
  for (SymmetricField& field : state.viscosity.history)
    for (auto* entry : {&field.xx, &field.yy, &field.zz, &field.xy, &field.xz, &field.yz})
      for (Real& h : *entry) h *= Real(factor);
  state.workspace.coarse.reset();  // its operator has the former moduli
  state.sleep = {};                // wakes all rows
}

}  // namespace turgor::lattice
