#include "turgor/models/lattice/build/cell_laws.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "turgor/core/assert.hpp"
#include "turgor/geometry/distance_transform.hpp"
#include "turgor/models/lattice/mechanics/solid_laws.hpp"

namespace turgor::lattice {

namespace {

/// Depth in bodies without an outside [m].
constexpr float kDeepest = 100;

/// Lowest depth of layer n, and that of the next one [m].
struct LayerSpan {
  double begin, end;
};

/// Calls visit(p) for all p below `count`, in parallel by layers.
template <class Visit>
void for_each_of(const Exec& exec, Int3 count, const Visit& visit) {
  parallel_for(exec, std::size_t(count.z), [&](std::size_t k) {
    for (int j = 0; j < count.y; j++)
      for (int i = 0; i < count.x; i++) visit(Int3{i, j, int(k)});
  });
}

/// Modulus under a press of a wide slab over that of shear, both per Young's modulus.
double confined_modulus(double young, double poisson) {
  return young * (1 - poisson) / ((1 + poisson) * (1 - 2 * poisson));
}
double shear_modulus(double young, double poisson) { return 0.5 * young / (1 + poisson); }

/// True if a layer sets the modulus of this node: fat and muscle that have no modulus of a label.
bool is_layered(const BodyNodes& nodes, const TissueParams& tissue, std::size_t n) {
  if (nodes.tissue[n] == Tissue::kFat) return nodes.young[n] == float(tissue.fat);
  return nodes.tissue[n] == Tissue::kMuscle && nodes.young[n] == float(tissue.muscle);
}

/// Law of a cell with this Young's modulus.
struct CellLawWriter {
  Model& model;
  double volume;

  void set(std::size_t slot, double poisson, double stiffening) const {
    const LawRatios ratios = law_ratios(model.params.tissue.energy, poisson);
    CellLaws& laws = model.anatomy.cell_laws;
    laws.shear[slot] = Real(volume * ratios.shear), laws.bulk[slot] = Real(volume * ratios.bulk);
    laws.stiffening[slot] = Real(stiffening);
  }
  /// Fibers of a cell with this Young's modulus.
  void set_fiber(std::size_t slot, double young, const FiberParams& fiber) const {
    CellLaws& laws = model.anatomy.cell_laws;
    if (laws.fiber.empty() || !(young > 0)) return;
    const Vec3d a = normalized(inverse(model.anatomy.grid.axes) * fiber.direction);
    laws.fiber[slot] = Real(volume * fiber.stiffness / young);
    laws.fiber_stiffening[slot] = Real(fiber.stiffening);
    laws.fiber_x[slot] = Real(a.x), laws.fiber_y[slot] = Real(a.y), laws.fiber_z[slot] = Real(a.z);
  }
};

/// True if all free corners of a cell are of layers.
bool is_layered_cell(const BodyNodes& nodes, const std::vector<std::uint8_t>& layered, Int3 cell) {
  int count = 0;
  for (int c = 0; c < kCellCorners; c++) {
    const Int3 p = cell + cell_corner(c);
    const std::size_t n = sample_index(nodes.grid, p.x, p.y, p.z);
    if (nodes.fixed[n]) continue;
    if (!layered[n]) return false;
    count++;
  }
  return count > 0;
}

/// Depths of a cell: its mean, and half its extent along the depth.
LayerSpan cell_depths(const Grid& grid, const std::vector<float>& depth, Int3 cell) {
  double mean = 0, least = std::numeric_limits<double>::max(), most = 0;
  for (int c = 0; c < kCellCorners; c++) {
    const Int3 p = cell + cell_corner(c);
    const double d = double(depth[sample_index(grid, p.x, p.y, p.z)]);
    mean += d / kCellCorners, least = std::min(least, d), most = std::max(most, d);
  }
  // an oblique cell has corners at many depths; a slab of the same volume is as thick as the spacing
  const double half =
      0.5 * std::min(most - least, std::max({grid.spacing.x, grid.spacing.y, grid.spacing.z}));
  return {mean - half, mean + half};
}

}  // namespace

bool has_cell_laws(const TissueParams& tissue) {
  return tissue.law == TissueLaw::kSolid &&
         (tissue.energy != SolidEnergy::kNeoHookean || !tissue.layers.empty() ||
          pair_count(tissue.prony) > 0 || has_set(tissue.set) || has_fibers(tissue));
}

LayerMean mean_of_layers(const std::vector<TissueLayer>& layers, double begin, double end) {
  TURGOR_CHECK(!layers.empty() && end >= begin, "layers have an order");
  double all = 0, shear = 0, confined = 0, stiffening = 0, top = 0, stiffest = 0;
  FiberParams fiber;
  for (std::size_t n = 0; n < layers.size(); n++) {
    // thickness of the layer in the cell; a cell without extent takes the layer at its depth
    const TissueLayer& layer = layers[n];
    const bool is_last = n + 1 == layers.size();
    const double bottom = is_last ? std::numeric_limits<double>::max() : top + layer.thickness;
    double inside =
        std::min(end, bottom) - std::max(n == 0 ? begin : std::max(begin, top), n == 0 ? begin : top);
    if (end == begin) inside = (n == 0 || begin >= top) && begin < bottom ? 1 : 0;
    top = bottom;
    if (!(inside > 0)) continue;
    // compliances in series, under shear and under a press of a wide slab [Backus 1962]
    const double soft = inside / (layer.slide * shear_modulus(layer.young, layer.poisson));
    all += inside, shear += soft, confined += inside / confined_modulus(layer.young, layer.poisson);
    stiffening += soft * layer.stiffening;
    const double share = inside * layer.fiber.stiffness;
    fiber.stiffness += share, fiber.stiffening += share * layer.fiber.stiffening;
    if (share > stiffest) stiffest = share, fiber.direction = layer.fiber.direction;
  }
  if (fiber.stiffness > 0) fiber.stiffening /= fiber.stiffness, fiber.stiffness /= all;
  const double g = all / shear, m = all / confined;
  return {.young = g * (3 * m - 4 * g) / (m - g),
          .poisson = std::clamp((m - 2 * g) / (2 * (m - g)), 0.0, 0.4999),
          .stiffening = stiffening / shear,
          .fiber = fiber};
}

std::vector<float> node_depths(const Exec& exec, const BodyNodes& nodes) {
  const Int3 size = nodes.grid.size;
  std::vector<std::uint8_t> at_surface(nodes.tissue.size());
  const auto is_outside = [&](Int3 p) {
    return nodes.tissue[sample_index(nodes.grid, p.x, p.y, p.z)] == Tissue::kOutside;
  };
  for_each_of(exec, size, [&](Int3 p) {
    if (is_outside(p)) return;
    bool found = false;
    for (int axis = 0; axis < 3; axis++) {
      Int3 before = p, after = p;
      before[axis]--, after[axis]++;
      found |= (p[axis] > 0 && is_outside(before)) || (after[axis] < size[axis] && is_outside(after));
    }
    at_surface[sample_index(nodes.grid, p.x, p.y, p.z)] = found;
  });
  std::vector<float> depth = distance_transform(exec, nodes.grid, at_surface);
  for (float& d : depth) d = std::min(d, kDeepest);
  return depth;
}

void set_cell_laws(const Exec& exec, const BodyNodes& nodes, Model& model) {
  const TissueParams& tissue = model.params.tissue;
  if (!has_cell_laws(tissue)) return;
  TURGOR_ASSERT(nodes.owned.end == 0 && !tissue.partial_cells,
                "laws by cell need a whole body without partial cells");
  // law of the body
  Anatomy& anatomy = model.anatomy;
  const Vec3 h = anatomy.lattice.spacing;
  const CellLawWriter write{model, double(h.x) * h.y * h.z};
  for (auto* array : {&anatomy.cell_laws.shear, &anatomy.cell_laws.bulk, &anatomy.cell_laws.stiffening})
    array->assign(anatomy.cell_young.size(), 0);
  for (std::size_t slot = 0; slot < anatomy.cell_young.size(); slot++)
    write.set(slot, tissue.poisson, tissue.stiffening);
  if (has_fibers(tissue)) {
    CellLaws& laws = anatomy.cell_laws;
    for (auto* array : {&laws.fiber, &laws.fiber_stiffening, &laws.fiber_x, &laws.fiber_y, &laws.fiber_z})
      array->assign(anatomy.cell_young.size(), 0);
    for (std::size_t slot = 0; slot < anatomy.cell_young.size(); slot++)
      write.set_fiber(slot, double(anatomy.cell_young[slot]), tissue.fiber);
  }
  if (tissue.layers.empty()) return;

  // nodes of layers, for the edges that are springs
  const std::vector<float> depth = node_depths(exec, nodes);
  std::vector<std::uint8_t> layered(nodes.tissue.size());
  const Int3 size = nodes.grid.size;
  for_each_of(exec, size, [&](Int3 p) {
    const std::size_t n = sample_index(nodes.grid, p.x, p.y, p.z);
    layered[n] = is_layered(nodes, tissue, n);
    if (!layered[n]) return;
    const double young = mean_of_layers(tissue.layers, double(depth[n]), double(depth[n])).young;
    model.springs.root_stiffness[std::size_t(node_slot(anatomy.lattice, p))] = Real(std::sqrt(young));
  });
  // cells of layers
  for_each_of(exec, size - Int3{1, 1, 1}, [&](Int3 cell) {
    const auto slot = std::size_t(node_slot(anatomy.lattice, cell));
    if (!(anatomy.cell_young[slot] > 0) || !is_layered_cell(nodes, layered, cell)) return;
    const LayerSpan span = cell_depths(nodes.grid, depth, cell);
    const LayerMean mean = mean_of_layers(tissue.layers, span.begin, span.end);
    anatomy.cell_young[slot] = Real(mean.young);
    write.set(slot, mean.poisson, mean.stiffening);
    write.set_fiber(slot, mean.young, mean.fiber);
  });
}

}  // namespace turgor::lattice
