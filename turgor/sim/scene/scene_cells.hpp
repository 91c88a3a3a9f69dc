// Cells at the surface of a lattice body: partial cells where its laws support them, else whole cells
// (docs/models/partial-cells.md), and combinations of tissue, solver and device that a lattice supports.
#pragma once

#include <string>

#include "turgor/sim/scene/scene.hpp"
#include "turgor/sim/scene/scene_table.hpp"

namespace turgor {

/// Refuses solid tissue with a solver that cannot step it.
void check_solid(SceneTable& body, const lattice::Params& params);
/// Refuses parameters that the GPU backend does not support.
void check_gpu(SceneTable& body, const lattice::Params& params);

/// Sets partial cells, or whole ones with a reason, unless the scene chooses. Partial cells need solid tissue
/// of one neo-Hookean law, and skin of law "fiber" or none. The device makes no difference. A table of
/// viscosity or of a permanent set means whole cells even if its shares are 0, since a person may change them
/// in a running world.
void choose_cells(SceneTable& body, LatticeScene& scene);

/// Sets whole cells for lattices with a needle, and for those on a GPU that tools touch, unless the scene
/// chooses (docs/models/partial-cells.md, Limits).
void use_whole_cells_under_tools(Scene& scene);

/// Sets the cells that a recording has.
void set_recorded_cells(LatticeScene& scene, bool partial);
/// Sets whole cells where the scene does not choose. They are the default of recordings that store no cells.
void use_whole_cells(LatticeScene& scene);
/// The same for all lattices, also after later changes of the scene (Scene::has_whole_cells).
void use_whole_cells(Scene& scene);

/// Cells at the surface and why, for the report: "whole, since it has layers".
std::string cells_text(const LatticeScene& scene);

}  // namespace turgor
