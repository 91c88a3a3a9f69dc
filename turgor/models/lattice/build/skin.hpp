// Finding the skin of a body: the triangles between tissue and the outside. [STC 4.1, Algorithm 2]
#pragma once

#include <span>

#include "turgor/models/lattice/build/body_nodes.hpp"

namespace turgor::lattice {

/// Fills model.skin from model.lattice, tissue and hu. `lines` = Langer's lines in the patient frame, or null
/// for model.params.skin.direction; `join_skin`: of a part of a body (BodyNodes).
void detect_skin(const Exec& exec, const VectorVolume* lines, const JoinSkin& join_skin, Model& model);

/// Descent: fills `skin.pull` for the tension that the model's parameters ask for, so that the body lies in
/// the CT as before.
void measure_pull(const Exec& exec, const Model& model, Skin& skin);

/// The lowest node of a cell that a triangle of the skin lies in, given by its three slots.
Int3 cell_of(const Lattice& lattice, Int3 triangle);

/// The triangles in layers of cells.
std::span<const SkinTriangle> skin_of_cells(const Model& model, Layers layers);

/// Family and lower end of the edge between two slots that are neighbours.
struct Edge {
  int slot = 0;
  int family = -1;  // -1: not neighbours
};
Edge edge_between(const Lattice& lattice, int a, int b);

/// Marks the triangles that lost an edge to a cut.
void cut_skin(const Model& model, State& state);

}  // namespace turgor::lattice
