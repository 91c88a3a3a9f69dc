#include "turgor/sim/scene/scene_cells.hpp"

#include <variant>

#include <fmt/format.h>

#include "turgor/core/invariants.hpp"
#include "turgor/models/lattice/build/cell_laws.hpp"

namespace turgor {

namespace {

using lattice::Method, lattice::Ordering;
using lattice::SkinLaw, lattice::TissueLaw;

/// Reason why the body cannot have partial cells; empty if it can.
std::string reason_for_whole_cells(const SceneTable& body, const lattice::Params& params) {
  const lattice::TissueParams& tissue = params.tissue;
  if (tissue.law != TissueLaw::kSolid) return "its springs join whole nodes";
  if (!tissue.layers.empty()) return "it has layers";
  if (body.has("viscosity")) return "its tissue relaxes";
  if (body.has("permanent_set")) return "its tissue keeps a permanent set";
  if (lattice::has_cell_laws(tissue)) return "its tissue stiffens";
  if (params.skin.enabled && params.skin.law == SkinLaw::kExponential) return "its skin stiffens";
  if (params.skin.enabled && params.skin.law == SkinLaw::kArea) return "its skin has the law \"area\"";
  return {};
}

}  // namespace

void check_solid(SceneTable& body, const lattice::Params& params) {
  if (params.tissue.law != TissueLaw::kSolid) return;
  if (params.solver.method == Method::kPbd)
    body.fail("tissue",
              "solver.method = \"pbd\" projects springs only (a projection has no modulus in Pa); "
              "set tissue.law = \"springs\" or solver.method = \"vbd\"");
  if (params.solver.sweeps < 2)
    body.fail("solver",
              "solid tissue runs half of its sweeps forward and half backward: expected at least 2 sweeps");
}

void check_gpu(SceneTable& body, const lattice::Params& params) {
  const lattice::SolverParams& solver = params.solver;
  if (lattice::has_cell_laws(params.tissue))
    body.fail(params.tissue.layers.empty() ? "tissue" : "layers",
              "world.device = \"gpu\" steps cells of law = \"solid\" without layers, viscosity and permanent "
              "set only; set "
              "that law, or "
              "world.device = \"cpu\"");
  if (solver.ordering != Ordering::kColors)
    body.fail(
        "solver",
        "world.device = \"gpu\" needs solver.ordering = \"colors\"; remove ordering, or set world.device "
        "= \"cpu\"");
}

void choose_cells(SceneTable& body, LatticeScene& scene) {
  scene.chooses_cells = body.table_or_text("tissue").has("partial_cells");
  if (scene.chooses_cells) return;
  scene.whole_cells_reason = reason_for_whole_cells(body, scene.params);
  scene.params.tissue.partial_cells = scene.whole_cells_reason.empty();
}

void use_whole_cells_under_tools(Scene& scene) {
  const auto use_whole = [&scene](BodyId id, std::string reason) {
    if (id.kind != BodyKind::kLattice || !is_index(id.index, scene.lattice_bodies.size())) return;
    LatticeScene& lattice = scene.lattice_bodies[std::size_t(id.index)];
    if (lattice.chooses_cells || !lattice.params.tissue.partial_cells) return;
    lattice.params.tissue.partial_cells = false;
    lattice.whole_cells_reason = std::move(reason);
  };
  for (const ToolScene& tool : scene.tools) {
    if (scene.device == Device::kGpu)
      use_whole(tool.body, fmt::format("tool.{} touches it on a GPU", tool.name));
    else if (std::holds_alternative<NeedleTool>(tool.shape))
      use_whole(tool.body, fmt::format("tool.{} is a needle", tool.name));
  }
}

void set_recorded_cells(LatticeScene& scene, bool partial) {
  if (scene.params.tissue.partial_cells == partial) return;
  scene.params.tissue.partial_cells = partial, scene.chooses_cells = false;
  scene.whole_cells_reason = partial ? "" : "its recording has them";
}

void use_whole_cells(LatticeScene& scene) {
  if (!scene.chooses_cells) set_recorded_cells(scene, false);
}

void use_whole_cells(Scene& scene) {
  scene.has_whole_cells = true;
  for (LatticeScene& lattice : scene.lattice_bodies) use_whole_cells(lattice);
}

std::string cells_text(const LatticeScene& scene) {
  const std::string cells = scene.params.tissue.partial_cells ? "partial" : "whole";
  if (scene.chooses_cells) return cells + ", as the scene says";
  if (scene.params.tissue.partial_cells) return cells;
  return fmt::format("{}, since {}", cells, scene.whole_cells_reason);
}

}  // namespace turgor
