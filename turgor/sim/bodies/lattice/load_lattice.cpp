// Loads a lattice body: CT and labels, crop to one label, model and state; uploads it if it steps on a GPU.
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "turgor/core/assert.hpp"
#include "turgor/core/timing.hpp"
#include "turgor/geometry/long_axis.hpp"
#include "turgor/geometry/reorient.hpp"
#include "turgor/io/ct.hpp"
#include "turgor/models/lattice/build/body_nodes.hpp"
#include "turgor/models/lattice/build/fiber_lines.hpp"
#include "turgor/models/lattice/build/scale_stiffness.hpp"
#include "turgor/sim/bodies/lattice/crop_to_label.hpp"
#include "turgor/sim/bodies/lattice/cut.hpp"
#include "turgor/sim/bodies/lattice/lattice_body.hpp"
#include "turgor/sim/bodies/lattice/load_ct.hpp"
#include "turgor/sim/bodies/lattice/upload_lattice.hpp"
#include "turgor/sim/bodies/lattice/wall_layers.hpp"
#include "turgor/sim/bodies/sfem/make_body.hpp"

namespace turgor {

namespace {

/// Additional volumes of the same patient.
struct ReadFields {
  std::optional<LabelVolume> labels;
  std::optional<VectorVolume> lines, fibers;
};
Result<ReadFields> read_fields(const LatticeScene& scene, const Grid& ct,
                               std::optional<LabelVolume> phantom_labels) {
  ReadFields fields{std::move(phantom_labels), std::nullopt, std::nullopt};
  if (scene.given_labels) {
    fields.labels = on_grid(*scene.given_labels, ct);
    if (!fields.labels)
      return Error{"labels: expected a segmentation on the grid of the CT, found another grid"};
  } else if (!scene.labels.empty()) {
    Result<LabelFile> read = read_labels_of(scene.labels, ct);
    if (!read) return read.error();
    fields.labels = std::move(read->labels);
  }
  if (!scene.direction_field.empty()) {
    Result<VectorVolume> read = read_vectors(scene.direction_field);
    if (!read) return read.error();
    fields.lines = std::move(*read);
  }
  if (!scene.fiber_field.empty()) {
    Result<VectorVolume> read = read_vectors(scene.fiber_field);
    if (!read) return read.error();
    fields.fibers = std::move(*read);
  }
  return fields;
}

/// Fixes the held nodes of the body.
Status fix_nodes(const HeldBy& held, lattice::BodyNodes& nodes) {
  // nodes of the body
  std::vector<Vec3d> points;
  std::vector<std::size_t> indices;
  for (int k = 0; k < nodes.grid.size.z; k++)
    for (int j = 0; j < nodes.grid.size.y; j++)
      for (int i = 0; i < nodes.grid.size.x; i++) {
        const std::size_t n = sample_index(nodes.grid, i, j, k);
        if (!lattice::is_body(nodes.tissue[n])) continue;
        points.push_back(point_at(nodes.grid, Vec3d(Int3{i, j, k})));
        indices.push_back(n);
      }

  // fix those in the region
  const std::vector<std::uint8_t> fixed = held_points(points, held);
  TURGOR_CHECK(fixed.size() == points.size(), "every node has a mark");
  for (std::size_t p = 0; p < points.size(); p++) nodes.fixed[indices[p]] |= fixed[p];
  return check_held(points, held, fixed);
}

/// Turns the fibers of layers whose direction is zero along the long axis of their label.
void find_long_axes(const std::optional<LabelVolume>& labels, std::vector<lattice::TissueLayer>& layers) {
  for (lattice::TissueLayer& layer : layers) {
    Vec3d& direction = layer.fiber.direction;
    if (norm(direction) > 0) continue;
    if (labels) direction = long_axis(*labels, layer.label);
    if (norm(direction) == 0) direction = {1, 0, 0};  // an empty label, which is noted
  }
}

/// Classifies the CT's nodes, fixes the held ones, and assembles the model.
Result<lattice::Model> build_model(const Exec& exec, const LatticeScene& scene, Int3 block,
                                   const CtVolume& ct, const ReadFields& fields) {
  lattice::Params params = scene.params;
  params.block = block;
  find_long_axes(fields.labels, params.tissue.layers);
  Result<lattice::BodyNodes> nodes =
      lattice::classify(exec, ct, fields.labels ? &*fields.labels : nullptr, params);
  if (!nodes) return nodes.error();
  if (scene.held)
    if (const Status held = fix_nodes(*scene.held, *nodes); !held) return held.error();
  return lattice::assemble(exec, *nodes, fields.lines ? &*fields.lines : nullptr, params);
}

/// Note on a block in voxels that makes the lattice of a fine CT large; empty for others.
std::string note_on_block(const LatticeScene& scene, Int3 block, const lattice::Model& model) {
  constexpr double kFine = 0.002;     // spacing of a lattice [m]
  constexpr int kManyNodes = 300000;  // the default incision.toml has 180 000
  const Vec3d spacing(model.anatomy.lattice.spacing);
  const double finest = std::min({spacing.x, spacing.y, spacing.z});
  if (scene.spacing > 0 || finest >= kFine || model.anatomy.body_nodes < kManyNodes) return {};
  return fmt::format(
      "block = [{}, {}, {}] voxels makes a lattice of {:.2g} mm and {} nodes on this CT, which is fine: "
      "spacing = 0.004 (in meters, instead of block) suits every CT",
      block.x, block.y, block.z, 1e3 * finest, model.anatomy.body_nodes);
}

/// Notes on regions that contain no tissue of the body.
void note_empty_regions(const lattice::Model& model, std::vector<std::string>& notes) {
  const std::vector<lattice::TissueLayer>& layers = model.params.tissue.layers;
  for (std::size_t n = 0; n < layers.size(); n++) {
    const auto is_of_layer = [n](const lattice::RegionShare& share) { return share.layer == int(n); };
    const auto& regions = model.anatomy.regions;
    if (!is_region(layers[n]) || std::any_of(regions.begin(), regions.end(), is_of_layer)) continue;
    notes.push_back(
        layers[n].label > 0
            ? fmt::format("layer {} is empty: no voxel has the label {}", layers[n].name, layers[n].label)
            : fmt::format("layer {} is empty: no voxel has a CT value from {} to {} HU", layers[n].name,
                          (*layers[n].hu)[0], (*layers[n].hu)[1]));
  }
}

/// Body without tools, on the host.
Result<LatticeBody> load(const Exec& exec, const LatticeScene& scene, const Progress& progress) {
  LatticeBody body;
  body.name = scene.name;
  body.has_gravity = scene.has_gravity;

  // CT and labels
  const Timer reading;
  Result<LoadedCt> ct = load_ct(exec, scene.ct, progress);
  if (!ct) return ct.error();
  body.ct = std::move(ct->volume);
  body.notes = std::move(ct->notes);
  body.ct_origin = std::move(ct->origin), body.ct_series = std::move(ct->series);
  if (!scene.label_note.empty()) body.notes.push_back(scene.label_note);
  const Result<ReadFields> fields = read_fields(scene, body.ct.grid, std::move(ct->labels));
  if (!fields) return fields.error();
  const Int3 block = block_of(scene, body.ct.grid);

  // tissues with a resistance of their own to needles, and colors of layers
  body.layers.layers = scene.inside, body.layer_colors = scene.layer_colors;
  const auto has_label = [](const auto& layer) { return layer.label > 0; };
  const std::vector<lattice::TissueLayer>& layers = scene.params.tissue.layers;
  const bool needs_labels = std::any_of(scene.inside.begin(), scene.inside.end(), has_label) ||
                            (has_layer_colors(body) && std::any_of(layers.begin(), layers.end(), has_label));
  if (needs_labels && fields->labels) body.layers.labels = *fields->labels;

  // crop to one label
  if (scene.only > 0) {
    const Int3 margin{2 * block.x, 2 * block.y, 2 * block.z};  // air around the surface
    const Status kept = crop_to_label(exec, *fields->labels, scene.only, margin, body.ct, body.notes);
    if (!kept) return kept.error();
  }
  body.ct_hash = content_hash(body.ct);
  body.read_seconds = reading.seconds();

  // model and state
  const Timer building;
  Result<lattice::Model> model = build_model(exec, scene, block, body.ct, *fields);
  if (!model) return model.error();
  body.model = std::move(*model);
  if (fields->fibers) {
    body.fiber_lines = lattice::fiber_lines(*fields->fibers, body.model);
    if (body.fiber_lines.empty())
      return Error{fmt::format(
          "{}: expected directions of fibers in the body, found none in its cells: is it the same "
          "patient?",
          scene.fiber_field.string())};
    lattice::set_fiber_lines(body.fiber_lines, body.model);
  }
  if (std::string note = note_on_block(scene, block, body.model); !note.empty())
    body.notes.push_back(std::move(note));
  note_empty_regions(body.model, body.notes);
  lattice::State state = lattice::make_state(body.model);
  if (scene.stiffness_scale != 1) lattice::scale_stiffness(scene.stiffness_scale, body.model, state);
  body.stiffness_scale = scene.stiffness_scale;
  body.state = std::move(state);
  body.build_seconds = building.seconds();
  body.box = body_box(body.model);
  body.typical_force = scene.params.tissue.muscle * 1e-4;
  return body;
}

}  // namespace

Int3 block_of(const LatticeScene& scene, const Grid& ct) {
  if (!(scene.spacing > 0)) return scene.params.block;
  const auto voxels = [&scene](double spacing) {
    return int(std::clamp(std::round(scene.spacing / spacing), 1.0, 64.0));
  };
  return {voxels(ct.spacing.x), voxels(ct.spacing.y), voxels(ct.spacing.z)};
}

Result<LatticeBody> load_body(const Loading& loading, const LatticeScene& scene, const World&) {
  Result<LatticeBody> body = load(loading.exec, scene, begin_work(loading.begin, "reading"));
  if (!body) return Error{fmt::format("{}: {}", scene.source_location, body.error().message)};
  if (scene.device == Device::kGpu && loading.purpose == Purpose::kSimulate)
    if (const Status backend = upload_to_gpu(*body); !backend)
      return Error{fmt::format("{}: {}", scene.source_location, backend.error().message)};
  return body;
}

}  // namespace turgor
