// Detection of skin: the triangles between tissue and outside air. [STC 4.1, Algorithm 2] Queries on skin are
// in mechanics/skin_queries.hpp.
#pragma once

#include <span>

#include "turgor/models/lattice/build/body_nodes.hpp"

namespace turgor::lattice {

/// Fills Anatomy::skin from the nodes, and the tables of skin for the solver. `lines`: Langer's lines in the
/// patient frame; null uses SkinParams::direction. `join_skin`: BodyNodes.
/// With the fiber law of VBD and partial cells, the skin bears in the cells that contain the surface
/// (Skin::patches).
void detect_skin(const Exec& exec, std::span<const CellSurface> surfaces, const VectorVolume* lines,
                 const JoinSkin& join_skin, Model& model);

/// VBD: Model::prestress_force for the current tension, with which the CT is the rest state of the body [N].
std::vector<Vec3> measure_prestress(const Exec& exec, const Model& model);

}  // namespace turgor::lattice
