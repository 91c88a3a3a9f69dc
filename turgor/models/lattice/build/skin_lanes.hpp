// Layout of the skin for the loops of the solvers: corners by node and half row, packed into lanes.
#pragma once

#include "turgor/models/lattice/model/model.hpp"

namespace turgor::lattice {

/// Fills the nodes and rows of the skin, and the tables of the solver, from its patches if it has some, else
/// from its triangles.
void lay_out_skin(Model& model);

}  // namespace turgor::lattice
