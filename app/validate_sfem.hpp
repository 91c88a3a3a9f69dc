// What the sfem model answers where the right answer is known: the paper's plate against an independent
// program, Hertz's contact against its formula, a thin layer against Hayes's equation, local against global
// refinement, kinds of elements on organs, and a hard nodule felt through soft tissue. Each experiment is a
// function; the command prints and draws them.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/core/progress.hpp"
#include "turgor/core/result.hpp"

namespace turgor {

/// The plate of theory and paper: reaction at its displaced centre.
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
  double ratio = 0;             // of the contact's radius to the layer's thickness [1]
  double poisson = 0;           // [1]
  int points = 0;               // of the surface below
  double hayes = 0, found = 0;  // [N]
};
/// `quick`: of one radius instead of three.
Result<std::vector<LayerRow>> validate_layer(const Exec& exec, bool quick, const Progress& progress);

/// One way to refine: the force at the deepest press, and what it cost.
struct RefinementRow {
  std::string mesh;
  bool global = true;                                     // the whole body, or a superposed patch
  int nodes = 0;                                          // of the body
  int local_nodes = 0;                                    // of the patch
  double precompute = 0;                                  // of Green's functions [s]
  double rebuild = 0;                                     // of the patch [s]
  std::vector<std::pair<double, double>> force_of_depth;  // [m] [N]
};
/// Coarse to fine; the last global row is the reference. `fine` = false leaves out the finest ones.
Result<std::vector<RefinementRow>> validate_refinement(const Exec& exec, bool fine, const Progress& progress);

/// Force at equal depth over a field of places above a hard nodule.
struct NoduleMap {
  std::string mesh;
  int nodes = 0;
  std::vector<double> force;  // columns · rows, along x first [N]
};
struct NoduleResult {
  int columns = 0, rows = 0;
  double low = 0, high = 0;                                  // ends of the field along x and y [m]
  double center_x = 0, center_y = 0, radius = 0, depth = 0;  // of the nodule below the surface [m]
  std::vector<NoduleMap> maps;                               // coarse, superposed, fine
};
/// `width` of the block [m], 5 mm the cells of its coarse mesh.
Result<NoduleResult> validate_nodule(const Exec& exec, int columns, double width, const Progress& progress);

/// What a kind of elements answers on an organ's mesh, and what it costs beforehand.
struct ElementsRow {
  std::string organ, elements, reference;
  bool to_patch = false;  // the reference has a patch itself
  bool quadratic = false;
  int refinement = 1;
  double poisson = 0;
  int tetrahedra = 0, nodes = 0;  // of the organ's mesh; free ones of the elements
  double flops = 0, store_bytes = 0, factor_bytes = 0;
  double worst = 0, mean = 0;  // of the force's relative error over the places pressed
  double said = 0;             // how far off a report says that the force may be
};
/// Balls on a tongue, and without `quick` on a liver and a block, on meshes of the size that scenes have. The
/// reference, each time the last, is quadratic on the same body, every tetrahedron cut in eight.
Result<std::vector<ElementsRow>> validate_elements(const Exec& exec, bool quick, const Progress& progress);

}  // namespace turgor
