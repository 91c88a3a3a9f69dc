// Validation of the sfem model against known answers. The paper's plate against an independent program,
// Hertz's contact against its formula, a thin layer against Hayes's equation. Local against global
// refinement, element types on organs, and a hard nodule below soft tissue. Each experiment is a function;
// the command prints and draws the results.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/core/progress.hpp"
#include "turgor/core/result.hpp"

namespace turgor {

/// The plate of theory and paper: reaction at its displaced center.
struct PlateRow {
  std::string mesh;
  int local_nodes = 0;
  double expected = 0, found = 0;  // vertical force [N]
};
Result<std::vector<PlateRow>> validate_plate(const Exec& exec);

/// A rigid sphere pressed into a block that is at least 20 contact radii wide and deep.
struct HertzRow {
  double depth = 0;                              // [m]
  double hertz = 0, patched = 0, unpatched = 0;  // [N]
};
struct HertzResult {
  double radius = 0, young = 0, poisson = 0;  // [m] [Pa] [1]
  int nodes = 0, local_nodes = 0;
  std::vector<HertzRow> rows;
};
Result<HertzResult> validate_hertz(const Exec& exec);

/// A rigid indenter on a layer that is bonded to its base.
struct LayerRow {
  std::string indenter;
  double ratio = 0;             // contact radius over layer thickness [1]
  double poisson = 0;           // [1]
  int points = 0;               // surface points below the indenter
  double hayes = 0, found = 0;  // [N]
};
/// `quick`: one radius instead of three.
Result<std::vector<LayerRow>> validate_layer(const Exec& exec, bool quick, const Progress& progress);

/// One refinement: force at the deepest press, and its cost.
struct RefinementRow {
  std::string mesh;
  bool global = true;     // true: the whole body is refined; false: a superposed patch
  int nodes = 0;          // of the body
  int local_nodes = 0;    // of the patch
  double precompute = 0;  // time of Green's functions [s]
  double rebuild = 0;     // time of the patch [s]
  std::vector<std::pair<double, double>> force_of_depth;  // [m] [N]
};
/// Coarse to fine; the last global row is the reference. `fine` = false skips the finest meshes.
Result<std::vector<RefinementRow>> validate_refinement(const Exec& exec, bool fine, const Progress& progress);

/// Force at equal depth over a field of points above a hard nodule.
struct NoduleMap {
  std::string mesh;
  int nodes = 0;
  std::vector<double> force;  // columns · rows, x fastest [N]
};
struct NoduleResult {
  int columns = 0, rows = 0;
  double low = 0, high = 0;                                  // ends of the field along x and y [m]
  double center_x = 0, center_y = 0, radius = 0, depth = 0;  // of the nodule below the surface [m]
  std::vector<NoduleMap> maps;                               // coarse, superposed, fine
};
/// `width` of the block [m]; the cells of its coarse mesh are 5 mm.
Result<NoduleResult> validate_nodule(const Exec& exec, int columns, double width, const Progress& progress);

/// Force of an element type on the mesh of an organ, and the cost of its precomputation.
struct ElementsRow {
  std::string organ, elements, reference;
  bool to_patch = false;  // the reference has a patch itself
  bool quadratic = false;
  int refinement = 1;
  double poisson = 0;
  int tetrahedra = 0, nodes = 0;  // of the organ's mesh; free nodes of the elements
  double flops = 0, store_bytes = 0, factor_bytes = 0;
  double worst = 0, mean = 0;  // relative error of the force over the press points
  double expected_error = 0;   // relative error expected by the report [1]
};
/// Presses balls on a tongue, and without `quick` on a liver and a block, on meshes of the size that scenes
/// have. The reference is the last row of each organ: quadratic elements on the same body, with every
/// tetrahedron cut in eight.
Result<std::vector<ElementsRow>> validate_elements(const Exec& exec, bool quick, const Progress& progress);

}  // namespace turgor
