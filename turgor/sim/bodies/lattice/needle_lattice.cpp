#include "turgor/sim/bodies/lattice/needle_lattice.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "turgor/core/assert.hpp"
#include "turgor/models/lattice/cutting/fragments.hpp"
#include "turgor/sim/bodies/lattice/lattice_body.hpp"

namespace turgor {

namespace {

/// CT value at a rest position, interpolated between nodes of the body; that of the nearest one outside [HU].
double hu_at(const lattice::Model& model, Vec3d rest) {
  const Lattice& lattice = model.anatomy.lattice;
  const Vec3d spacing(lattice.spacing);
  const Vec3d at{rest.x / spacing.x, rest.y / spacing.y, rest.z / spacing.z - lattice.first};
  const Int3 low{int(std::floor(at.x)), int(std::floor(at.y)), int(std::floor(at.z))};
  double sum = 0, weight = 0;
  for (int c = 0; c < 8; c++) {
    const Int3 node = low + Int3{c & 1, c >> 1 & 1, c >> 2};
    if (!contains(lattice, node)) continue;
    const auto slot = std::size_t(node_slot(lattice, node));
    if (!lattice::is_body(model.anatomy.tissue[slot])) continue;
    double w = 1;
    for (int axis = 0; axis < 3; axis++) w *= 1 - std::min(1.0, std::abs(at[axis] - node[axis]));
    w = std::max(w, 1e-9);
    sum += w * model.anatomy.hu[slot], weight += w;
  }
  return weight > 0 ? sum / weight : kAirHu;
}

/// Label of the voxel at a position in the patient frame; 0 outside of the segmentation.
int label_at(const LabelVolume& labels, Vec3d position) {
  if (labels.samples.empty()) return 0;
  const Vec3d v = inverse(labels.grid.axes) * (position - labels.grid.origin);
  const Int3 voxel{int(std::lround(v.x / labels.grid.spacing.x)),
                   int(std::lround(v.y / labels.grid.spacing.y)),
                   int(std::lround(v.z / labels.grid.spacing.z))};
  for (int axis = 0; axis < 3; axis++)
    if (voxel[axis] < 0 || voxel[axis] >= labels.grid.size[axis]) return 0;
  return labels.at(voxel.x, voxel.y, voxel.z);
}

/// Index of the thinnest layer by depth that contains this depth; -1 = none. `of_layers`: NeedleLayerScene's.
int layer_of_depth(const std::vector<NeedleLayerScene>& layers, double depth, bool of_layers) {
  int found = -1;
  for (std::size_t i = 0; i < layers.size(); i++)
    if (layers[i].is_of_layers == of_layers && depth < layers[i].depth &&
        (found < 0 || layers[i].depth < layers[std::size_t(found)].depth))
      found = int(i);
  return found;
}

/// Index of the layer at a rest position, lattice frame; -1 = none. The thinnest layer by depth comes first,
/// then labels, HU, and tissue that layers of the law give by depth.
int layer_at(const LatticeBody& body, Vec3d rest, double hu) {
  const std::vector<NeedleLayerScene>& layers = body.layers.layers;
  const Grid& grid = body.model.anatomy.grid;
  const Vec3d position = grid.origin + grid.axes * rest;
  // layers by depth
  const bool has_depth =
      std::any_of(layers.begin(), layers.end(), [](const NeedleLayerScene& l) { return l.depth > 0; });
  const double depth = has_depth && body.rest_skin.at ? -body.rest_skin.at(position) : 0;
  if (const int found = layer_of_depth(layers, depth, false); found >= 0) return found;
  // labels, then HU
  const int label = label_at(body.layers.labels, position);
  for (std::size_t i = 0; i < layers.size(); i++)
    if (label > 0 && layers[i].label == label) return int(i);
  for (std::size_t i = 0; i < layers.size(); i++)
    if (layers[i].hu && hu >= (*layers[i].hu)[0] && hu <= (*layers[i].hu)[1]) return int(i);
  return hu < body.model.params.tissue.bone_min ? layer_of_depth(layers, depth, true) : -1;
}

/// Slots of each layer.
std::vector<std::vector<int>> nodes_of_layers(const LatticeBody& body) {
  const Lattice& lattice = body.model.anatomy.lattice;
  std::vector<std::vector<int>> nodes(body.layers.layers.size());
  if (nodes.empty()) return nodes;
  for (int k = 0; k < lattice.size.z; k++)
    for (int j = 0; j < lattice.size.y; j++)
      for (int i = 0; i < lattice.size.x; i++) {
        const int slot = node_slot(lattice, {i, j, k});
        if (!lattice::is_body(body.model.anatomy.tissue[std::size_t(slot)])) continue;
        const int layer = layer_at(body, Vec3d(rest_position(lattice, {i, j, k})),
                                   body.model.anatomy.hu[std::size_t(slot)]);
        if (layer >= 0) nodes[std::size_t(layer)].push_back(slot);
      }
  for (std::vector<int>& slots : nodes) std::sort(slots.begin(), slots.end());
  return nodes;
}

}  // namespace

contact::NeedleTissue needle_tissue(const LatticeBody& body, Vec3d rest) {
  const double hu = hu_at(body.model, rest);
  if (const int layer = layer_at(body, rest, hu); layer >= 0) {
    const NeedleLayerScene& l = body.layers.layers[std::size_t(layer)];
    return {layer + 1, l.toughness, l.friction};
  }
  if (hu >= body.model.params.tissue.bone_min) return {.toughness = std::numeric_limits<double>::infinity()};
  return {};
}

bool has_needles(const LatticeBody& body) {
  return std::any_of(body.tools.begin(), body.tools.end(),
                     [](const contact::Tool& tool) { return tool.needle.has_value(); });
}

void begin_needles(LatticeBody& body) {
  if (!has_needles(body)) return;
  body.needles.assign(body.tools.size(), contact::make_lattice_needle());
  body.layers.nodes = nodes_of_layers(body);
  body.layers.before.resize(body.layers.layers.size());
  body.layers.motion.resize(body.layers.layers.size());
}

NeedleSprings::NeedleSprings(LatticeBody& of, lattice::PointSprings* sutures) : body(of), stitches(sutures) {
  if (body.needles.empty()) return;
  before = body.needles;
  fragments = lattice::fragments_of(body.model, body.state.cuts());
  // needles at their present poses
  for (std::size_t t = 0; t < body.tools.size(); t++)
    if (const std::optional<contact::Needle>& needle = body.tools[t].needle)
      contact::begin_needle_step(surroundings(), *needle, body.poses[t].pose, body.needles[t]);
  // their springs, after those of the sutures
  if (stitches) springs.all = stitches->all;
  const std::size_t first = springs.all.size();
  springs.settled = !stitches || stitches->settled;
  for (const contact::LatticeNeedle& needle : body.needles) {
    contact::append_needle_springs(needle, springs.all);
    springs.settled = springs.settled && needle.settled;
  }
  if (springs.all.size() == first) springs.all.clear();
  if (springs.all.empty()) return;
  make_terms(springs);
  springs.refresh = [this](const lattice::State& state) { refresh(state); };
}

lattice::PointSprings* NeedleSprings::input() { return springs.all.empty() ? stitches : &springs; }

contact::NeedleSurroundings NeedleSprings::surroundings() const {
  return {body.model, body.state.host(), body.surface, *fragments,
          [this](Vec3d rest) { return needle_tissue(body, rest); }};
}

void NeedleSprings::refresh(const lattice::State& state) {
  std::size_t next = 0;
  if (stitches) {
    if (stitches->refresh) stitches->refresh(state);
    std::copy(stitches->all.begin(), stitches->all.end(), springs.all.begin());
    next = stitches->all.size();
  }
  for (std::size_t t = 0; t < body.tools.size(); t++)
    if (const std::optional<contact::Needle>& needle = body.tools[t].needle)
      next += contact::update_needle_springs(body.model, state.motion, *needle, body.needles[t],
                                             std::span(springs.all).subspan(next));
  TURGOR_CHECK(next == springs.all.size(), "every spring has a stitch or a needle");
}

void NeedleSprings::finish(bool is_finite) {
  if (body.needles.empty()) return;
  if (!is_finite) {
    body.needles = before;
    return;
  }
  for (std::size_t t = 0; t < body.tools.size(); t++)
    if (const std::optional<contact::Needle>& needle = body.tools[t].needle)
      contact::finish_needle_step(surroundings(), *needle, body.needles[t]);
}

void read_needle_forces(LatticeBody& body) {
  for (std::size_t t = 0; t < body.needles.size(); t++) {
    if (!body.tools[t].needle) continue;
    const contact::LatticeNeedle& needle = body.needles[t];
    body.forces[t] = {.force = needle.force, .torque = needle.torque, .contacts = bearing_points(needle)};
  }
}

void measure_targets(LatticeBody& body) {
  if (body.needles.empty() || body.layers.layers.empty()) return;
  const bool is_out = std::all_of(body.needles.begin(), body.needles.end(), [](const auto& needle) {
    return needle.phase == contact::NeedlePhase::kOutside;
  });
  const lattice::VecField& u = body.state->motion.u;
  for (std::size_t l = 0; l < body.layers.layers.size(); l++) {
    Vec3d sum;
    for (const int slot : body.layers.nodes[l]) sum += Vec3d(u[std::size_t(slot)]);
    const Vec3d mean = sum / double(std::max<std::size_t>(1, body.layers.nodes[l].size()));
    if (is_out)
      body.layers.before[l] = mean;
    else
      body.layers.motion[l] = std::max(body.layers.motion[l], norm(mean - body.layers.before[l]));
  }
}

void add_needle(const LatticeBody& body, std::size_t t, ForceSample& sample, TouchingTool& tool) {
  if (!body.tools[t].needle) return;
  const contact::LatticeNeedle& needle = body.needles[t];
  sample.depth = contact::needle_depth(body.model, needle);
  sample.needle = needle.reading;
  tool.needle_work = needle.work, tool.punctures = needle.punctures, tool.entry_force = needle.entry_force;
}

}  // namespace turgor
