// Detection of skin: the triangles between tissue and outside air. [STC 4.1, Algorithm 2] Queries on skin are
// in mechanics/skin_queries.hpp.
#pragma once

#include "turgor/models/lattice/build/body_nodes.hpp"

namespace turgor::lattice {

/// Fills model.skin from model.lattice, tissue and hu. `lines`: Langer's lines in the patient frame; null
/// uses model.params.skin.direction. `join_skin`: BodyNodes.
void detect_skin(const Exec& exec, const VectorVolume* lines, const JoinSkin& join_skin, Model& model);

/// VBD: computes skin.prestress_force for the current tension, so that the CT stays the rest state of the
/// body.
void measure_prestress(const Exec& exec, const Model& model, Skin& skin);

}  // namespace turgor::lattice
