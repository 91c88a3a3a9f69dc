#include "turgor/models/lattice/build/cell_laws.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "turgor/core/assert.hpp"
#include "turgor/geometry/distance_transform.hpp"
#include "turgor/models/lattice/mechanics/solid_laws.hpp"

namespace turgor::lattice {

namespace {

/// Depth in bodies without an outside [m].
constexpr float kDeepest = 100;

/// Range of depths [m].
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

bool is_by_depth(const TissueLayer& layer) { return !is_region(layer); }
bool has_depth_layers(const std::vector<TissueLayer>& layers) {
  return std::any_of(layers.begin(), layers.end(), is_by_depth);
}

/// Node or cell with this number, i fastest.
Int3 sample_position(Int3 size, int n) { return {n % size.x, n / size.x % size.y, n / (size.x * size.y)}; }

/// True if a layer sets the modulus of this node: fat and muscle that have no modulus of a label.
bool is_layered(const BodyNodes& nodes, const TissueParams& tissue, std::size_t n) {
  if (nodes.tissue[n] == Tissue::kFat) return nodes.young[n] == float(tissue.fat);
  return nodes.tissue[n] == Tissue::kMuscle && nodes.young[n] == float(tissue.muscle);
}

/// Writes laws of cells, by slot of the lowest node.
struct CellLawWriter {
  Model& model;
  double volume = 0;  // of a cell [m³]
  const TissueParams& tissue = model.params.tissue;

  explicit CellLawWriter(Model& m) : model(m) {
    const Vec3 h = m.anatomy.lattice.spacing;
    volume = double(h.x) * h.y * h.z;
  }

  void set(std::size_t slot, SolidEnergy energy, double poisson, double stiffening) const {
    const LawRatios ratios = law_ratios(energy, poisson);
    CellLaws& laws = model.anatomy.cell_laws;
    if (!laws.energy.empty()) laws.energy[slot] = std::uint8_t(energy);
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
  /// Law, modulus and relaxation of a cell of layers.
  void set_mean(std::size_t slot, const LayerMean& mean) const {
    model.anatomy.cell_young[slot] = Real(mean.young);
    set(slot, mean.energy, mean.poisson, mean.stiffening);
    set_fiber(slot, mean.young, mean.fiber);
    aligned_vector<std::uint8_t>& relaxation = model.anatomy.cell_laws.relaxation;
    if (!relaxation.empty()) relaxation[slot] = pairs_of(mean.softest);
  }
  /// Entry of CellLaws::relaxation for a layer of the body; null: of none.
  std::uint8_t pairs_of(const TissueLayer* layer) const {
    for (std::size_t n = 0; n < tissue.layers.size(); n++)
      if (layer == &tissue.layers[n] && layer->prony) return std::uint8_t(n + 1);
    return 0;
  }
  /// All cells get the law of the body.
  void set_body() const {
    CellLaws& laws = model.anatomy.cell_laws;
    const std::size_t slots = model.anatomy.cell_young.size();
    for (auto* array : {&laws.shear, &laws.bulk, &laws.stiffening}) array->assign(slots, 0);
    if (has_mixed_laws(tissue)) laws.energy.assign(slots, 0);
    const auto has_pairs = [](const TissueLayer& layer) { return layer.prony.has_value(); };
    if (std::any_of(tissue.layers.begin(), tissue.layers.end(), has_pairs)) laws.relaxation.assign(slots, 0);
    for (std::size_t slot = 0; slot < slots; slot++)
      set(slot, tissue.energy, tissue.poisson, tissue.stiffening);
    if (!has_fibers(tissue)) return;
    for (auto* array : {&laws.fiber, &laws.fiber_stiffening, &laws.fiber_x, &laws.fiber_y, &laws.fiber_z})
      array->assign(slots, 0);
    for (std::size_t slot = 0; slot < slots; slot++)
      set_fiber(slot, double(model.anatomy.cell_young[slot]), tissue.fiber);
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

/// Layers by depth: depths of the nodes, and the nodes whose modulus layers set. Empty without such layers.
struct DepthLayers {
  const BodyNodes& nodes;
  const Model& model;
  std::vector<float> depth;
  std::vector<std::uint8_t> layered;

  DepthLayers(const Exec& exec, const BodyNodes& of, const Model& m) : nodes(of), model(m) {
    if (!has_depth_layers(m.params.tissue.layers)) return;
    depth = node_depths(exec, nodes);
    layered.resize(nodes.tissue.size());
    for (std::size_t n = 0; n < layered.size(); n++) layered[n] = is_layered(nodes, m.params.tissue, n);
  }
  /// Mean of the layers in a cell; empty for a cell that they do not set.
  std::optional<LayerMean> mean_of(Int3 cell) const {
    if (layered.empty() || !is_layered_cell(nodes, layered, cell)) return std::nullopt;
    const LayerSpan span = cell_depths(nodes.grid, depth, cell);
    return mean_of_layers(model.params.tissue.layers, span.begin, span.end, model.params.tissue.energy);
  }
};

void set_depth_layers(const Exec& exec, const BodyNodes& nodes, const DepthLayers& layers,
                      const CellLawWriter& write) {
  Model& model = write.model;
  const Lattice& l = model.anatomy.lattice;
  // nodes of layers, for the edges that are springs
  for_each_of(exec, nodes.grid.size, [&](Int3 p) {
    const std::size_t n = sample_index(nodes.grid, p.x, p.y, p.z);
    if (!layers.layered[n]) return;
    const double depth = double(layers.depth[n]);
    const double young = mean_of_layers(write.tissue.layers, depth, depth).young;
    model.springs.root_stiffness[std::size_t(node_slot(l, p))] = Real(std::sqrt(young));
  });
  // cells of layers
  for_each_of(exec, nodes.grid.size - Int3{1, 1, 1}, [&](Int3 cell) {
    const auto slot = std::size_t(node_slot(l, cell));
    if (!(model.anatomy.cell_young[slot] > 0)) return;
    if (const std::optional<LayerMean> mean = layers.mean_of(cell)) write.set_mean(slot, *mean);
  });
}

/// Sets the moduli of nodes in regions, for the edges that are springs: those that lie mostly in one region.
void set_nodes_of_regions(const BodyNodes& nodes, const CellLawWriter& write) {
  // shares of the eight cells around a node
  const Int3 size = nodes.grid.size;
  std::map<std::size_t, std::vector<double>> shares;
  for (const RegionShare& one : nodes.regions)
    for (int c = 0; c < kCellCorners; c++) {
      const Int3 p = sample_position(size, one.cell) + cell_corner(c);
      std::vector<double>& of = shares[sample_index(nodes.grid, p.x, p.y, p.z)];
      of.resize(write.tissue.layers.size());
      of[std::size_t(one.layer)] += double(one.share) / kCellCorners;
    }
  for (const auto& [n, of] : shares) {
    const auto most = std::max_element(of.begin(), of.end());
    if (*most < 0.5 || !is_body(nodes.tissue[n])) continue;
    const double young = write.tissue.layers[std::size_t(most - of.begin())].young;
    write.model.springs
        .root_stiffness[std::size_t(node_slot(write.model.anatomy.lattice, sample_position(size, int(n))))] =
        Real(std::sqrt(young));
  }
}

/// Sets the cells of regions. The rest of a cell has the law that the cell has without regions.
void set_regions(const BodyNodes& nodes, const DepthLayers& layers, const CellLawWriter& write) {
  const TissueParams& tissue = write.tissue;
  const std::vector<RegionShare>& regions = nodes.regions;
  std::vector<SharedLayer> shared;
  for (std::size_t begin = 0, end = 0; begin < regions.size(); begin = end) {
    // regions of a cell
    shared.clear();
    double rest = 1;
    for (; end < regions.size() && regions[end].cell == regions[begin].cell; end++) {
      shared.push_back({&tissue.layers[std::size_t(regions[end].layer)], double(regions[end].share)});
      rest -= double(regions[end].share);
    }
    const Int3 cell = sample_position(nodes.grid.size, regions[begin].cell);
    const auto slot = std::size_t(node_slot(write.model.anatomy.lattice, cell));
    const double young = double(write.model.anatomy.cell_young[slot]);
    if (!(young > 0)) continue;
    // the rest
    const LayerMean other = layers.mean_of(cell).value_or(
        LayerMean{young, tissue.poisson, tissue.stiffening, tissue.energy, tissue.fiber, nullptr});
    const TissueLayer rest_layer{.energy = other.energy,
                                 .young = other.young,
                                 .poisson = other.poisson,
                                 .stiffening = other.stiffening,
                                 .fiber = other.fiber};
    if (rest > 1e-3) shared.push_back({&rest_layer, rest});
    LayerMean mean = mean_in_series(shared, tissue.energy);
    if (mean.softest == &rest_layer) mean.softest = other.softest;
    write.set_mean(slot, mean);
  }
  set_nodes_of_regions(nodes, write);
}

}  // namespace

namespace {

/// Stiffening with which a law of this energy answers as a layer does; empty if it has none.
std::optional<double> stiffening_in(const TissueLayer& layer, SolidEnergy of_body, SolidEnergy energy) {
  const SolidEnergy own = layer.energy.value_or(of_body);
  if (own == energy) return layer.stiffening;
  if (own == SolidEnergy::kNeoHookean) return energy == SolidEnergy::kOgden ? 2 : 0;
  return std::nullopt;
}
/// Mean by the layers' shares of the shear strain.
double mean_stiffening(std::span<const SharedLayer> shared, SolidEnergy of_body, SolidEnergy energy) {
  double sum = 0, all = 0;
  for (const auto& [layer, inside] : shared) {
    const double soft = inside / (layer->slide * shear_modulus(layer->young, layer->poisson));
    if (const std::optional<double> one = stiffening_in(*layer, of_body, energy))
      sum += soft * *one, all += soft;
  }
  return sum / all;
}

}  // namespace

bool has_cell_laws(const TissueParams& tissue) {
  return tissue.law == TissueLaw::kSolid &&
         (tissue.energy != SolidEnergy::kNeoHookean || !tissue.layers.empty() || most_pairs(tissue) > 0 ||
          has_set(tissue.set) || has_fibers(tissue));
}

LayerMean mean_in_series(std::span<const SharedLayer> shared, SolidEnergy of_body) {
  double all = 0, shear = 0, confined = 0, stiffest = 0, softest = 0;
  LayerMean mean{};
  for (const auto& [layer, inside] : shared) {
    // compliances in series, under shear and under a press of a wide slab [Backus 1962]
    const double soft = inside / (layer->slide * shear_modulus(layer->young, layer->poisson));
    all += inside, shear += soft, confined += inside / confined_modulus(layer->young, layer->poisson);
    const double share = inside * layer->fiber.stiffness;
    mean.fiber.stiffness += share, mean.fiber.stiffening += share * layer->fiber.stiffening;
    if (share > stiffest) stiffest = share, mean.fiber.direction = layer->fiber.direction;
    if (soft > softest) softest = soft, mean.softest = layer;
  }
  TURGOR_CHECK(all > 0, "a mean is over at least one layer");
  if (mean.fiber.stiffness > 0) mean.fiber.stiffening /= mean.fiber.stiffness, mean.fiber.stiffness /= all;
  const double g = all / shear, m = all / confined;
  mean.young = g * (3 * m - 4 * g) / (m - g);
  mean.poisson = std::clamp((m - 2 * g) / (2 * (m - g)), 0.0, 0.4999);
  mean.energy = mean.softest->energy.value_or(of_body);
  mean.stiffening = mean_stiffening(shared, of_body, mean.energy);
  return mean;
}

LayerMean mean_of_layers(const std::vector<TissueLayer>& layers, double begin, double end,
                         SolidEnergy of_body) {
  TURGOR_CHECK(has_depth_layers(layers) && end >= begin, "layers have an order");
  std::vector<SharedLayer> shared;
  const auto last = std::find_if(layers.rbegin(), layers.rend(), is_by_depth);
  double top = 0;
  for (const TissueLayer& layer : layers) {
    if (is_region(layer)) continue;
    // thickness of the layer in the cell; a cell without extent takes the layer at its depth
    const bool is_first = top == 0;
    const double bottom = &layer == &*last ? std::numeric_limits<double>::max() : top + layer.thickness;
    double inside = std::min(end, bottom) - (is_first ? begin : std::max(begin, top));
    if (end == begin) inside = (is_first || begin >= top) && begin < bottom ? 1 : 0;
    top = bottom;
    if (inside > 0) shared.push_back({&layer, inside});
  }
  return mean_in_series(shared, of_body);
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
  model.anatomy.cell_laws = {};
  if (!has_cell_laws(tissue)) return;
  TURGOR_ASSERT(nodes.owned.end == 0 && !tissue.partial_cells,
                "laws by cell need a whole body without partial cells");
  const CellLawWriter write(model);
  write.set_body();
  if (tissue.layers.empty()) return;
  const DepthLayers layers(exec, nodes, model);
  if (has_depth_layers(tissue.layers)) set_depth_layers(exec, nodes, layers, write);
  set_regions(nodes, layers, write);
}

}  // namespace turgor::lattice
