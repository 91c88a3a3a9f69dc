// Resampled CT and voxel fields in device memory (device_body.hpp). Their arrays are allocated on first use.
#pragma once

#include <optional>
#include <utility>

#include "turgor/core/device_arrays.hpp"
#include "turgor/models/lattice/device/device_state.hpp"
#include "turgor/models/lattice/resample/deformed_fields.hpp"
#include "turgor/models/lattice/resample/partial_volume.hpp"
#include "turgor/models/lattice/resample/partial_volume_kernels.hpp"
#include "turgor/models/lattice/resample/rest_mass.hpp"

namespace turgor::lattice {

/// Body in device memory.
struct BodyToResample {
  NodeArrays nodes;
  const std::uint8_t* removed;
  const VirtualNodeDisplacement* shifts;  // Motion::virtual_u
  std::size_t shift_count;
};

/// Fragments of a cut body, as of its last cut.
template <class Backend>
struct DeviceFragments {
  template <class T>
  using List = DeviceList<Backend, T>;

  FineLattice fine{};
  bool is_current = false;
  List<CutCell> cells;
  List<Fragment> all;
  List<VirtualNode> virtual_nodes;
  List<FitTerm> fit_terms;
  List<GhostFragment> ghosts;
  List<std::int16_t> label;
  List<KeyEntry> edge_index;
  List<CutEdge> edges;
  List<SpecialCell> special;
  List<std::uint8_t> is_special;  // by slot

  bool upload(const Model& model, const Cuts& cuts) {
    const std::shared_ptr<const Fragments> stored = fragments_of(model, cuts);
    const Fragments& now = *stored;
    fine = now.fine;
    const std::vector<SpecialCell> cells_now = special_cells(model, cuts, now);
    is_current = cells.try_assign(now.cells) && all.try_assign(now.all) &&
                 virtual_nodes.try_assign(now.virtual_nodes) && fit_terms.try_assign(now.fit_terms) &&
                 ghosts.try_assign(now.ghosts) && label.try_assign(now.label) &&
                 edge_index.try_assign(now.edge_index.entries()) && edges.try_assign(cuts.edges) &&
                 special.try_assign(cells_now) &&
                 is_special.try_resize(cells_now.empty() ? 0 : model.anatomy.tissue.size());
    return is_current;
  }
  ResampleCuts view(const Cuts& cuts, const BodyToResample& body) const {
    return {.fragments = {.fine = fine,
                          .cells = cells.data(),
                          .all = all.data(),
                          .virtual_nodes = virtual_nodes.data(),
                          .fit_terms = fit_terms.data(),
                          .ghosts = ghosts.data(),
                          .first_ghost_position = slot_count(fine.cells) + int(virtual_nodes.count),
                          .label = label.data(),
                          .edge_index = {edge_index.data(), edge_index.count},
                          .edges = edges.data(),
                          .shifts = body.shift_count == virtual_nodes.count ? body.shifts : nullptr},
            .virtual_node_count = int(virtual_nodes.count),
            .ghost_count = int(ghosts.count),
            .special = special.data(),
            .special_count = int(special.count),
            .is_special = special.count > 0 ? is_special.data() : nullptr,
            .removed = cuts.removed_nodes > 0 ? body.removed : nullptr};
  }
};

/// Surroundings of the body in the CT, and the rest body on a grid.
template <class Backend>
struct DeviceSurroundings {
  template <class T>
  using List = DeviceList<Backend, T>;

  List<std::uint8_t> marks, mask, row_mask;  // of RestBody; of Surroundings
  Int3 cell, size;                           // of Surroundings
  List<std::uint8_t> rest, near_rest;        // by voxel
  Grid marked_grid;                          // grid of these voxels

  bool upload(const Exec& exec, const Model& model, const CtVolume& ct) {
    if (marks.count > 0) return true;
    const RestFrame frame = rest_frame(model, ct.grid);
    const Surroundings& surroundings = model.anatomy.surroundings;
    cell = surroundings.cell, size = surroundings.size;
    return mask.try_assign(surroundings.mask) && row_mask.try_assign(surroundings.row_mask) &&
           marks.try_assign(RestBody(exec, model, frame.first_node, frame.cell_size).marks());
  }
  bool resize(std::size_t voxels) { return rest.try_resize(voxels) && near_rest.try_resize(voxels); }
  PartialVolumeView view(const Model& model, const ResampleView& body, const CtVolume& ct,
                         const Grid& grid) const {
    const RestFrame frame = rest_frame(model, ct.grid);
    const Vec3d side = frame.cell_size;
    const RestBodyView at_rest{.lattice = model.anatomy.lattice,
                               .first_node = frame.first_node,
                               .per_cell = {1 / side.x, 1 / side.y, 1 / side.z},
                               .marks = marks.data()};
    PartialVolumeView f{.v = body,
                        .value = outside_voxel(ct, model.params.tissue.air_max, grid, at_rest,
                                               {cell, size, mask.data(), row_mask.data()}),
                        .rest = rest.data(),
                        .near_rest = near_rest.data(),
                        .reach = blur_reach(grid, ct.grid)};
    f.value.sample = body.sample;
    return f;
  }
  /// True if the marks are those of this grid.
  bool is_marked_for(const Grid& grid) const {
    return marked_grid.size == grid.size && marked_grid.spacing == grid.spacing &&
           marked_grid.origin == grid.origin && marked_grid.axes == grid.axes;
  }
};

template <class Backend>
struct DeviceSampleArray final : DeviceSamples {
  typename Backend::template Array<std::int16_t> array;

  explicit DeviceSampleArray(std::size_t count) : array(count) {}
  const std::int16_t* data() const override { return array.data(); }
  void download(std::span<std::int16_t> samples) const override { array.download(samples); }
};

template <class Backend>
class DeviceResampling {
 public:
  /// Marks the fragments and the rest mass as outdated.
  void forget_cuts() { fragments_.is_current = is_mass_current_ = false; }

  /// resample_ct on the device. Of `cuts` only the cut topology is read, not positions. Empty if device
  /// memory is short, or if the body has no stiffness.
  template <class Run>
  std::optional<DeviceResampled> resample(const Run& run, const Exec& exec, const Model& model,
                                          const Cuts& cuts, const BodyToResample& body, const CtVolume& ct,
                                          const Grid& grid, const ResampleOptions& options) {
    const bool surroundings = options.keep_surroundings;
    if (!fits(model, cuts, grid) || !upload_ct(ct)) return {};
    // memory
    const auto out = std::make_shared<DeviceSampleArray<Backend>>(sample_count(grid));
    if (!out->array.is_allocated()) return {};
    if (surroundings && !(surroundings_.upload(exec, model, ct) && surroundings_.resize(sample_count(grid))))
      return {};
    if (!std::exchange(is_mass_current_, true)) rest_mass_ = rest_mass(exec, model, cuts, ct);
    // rest mass on the host, once per cut
    ResampleView view = this->view(run, model, cuts, body, grid);
    view.rest = rest_frame(model, ct.grid);
    // tissue, then the outside of the body
    view.sample = CtSampler(ct_.data(), ct.grid.size);
    view.conserve_mass = options.conserve_mass;
    view.out = out->array.data();
    resample_with(run, view);
    if (surroundings) fill_outside(run, model, view, ct, grid);
    return DeviceResampled{grid, out, report(grid)};
  }
  /// Computes a field of deformed_fields.hpp and downloads it. Returns false if device memory is short.
  template <class Run, class Of, class Sample>
  bool download_field(const Run& run, const Model& model, const Cuts& cuts, const BodyToResample& body,
                      const Grid& grid, const Of& of, std::span<Sample> samples) {
    List<Sample> field;
    if (!fits(model, cuts, grid) || !field.try_resize(samples.size())) return false;
    const ResampleView view = this->view(run, model, cuts, body, grid);
    claim_with(run, view);
    fill_field_with(run, view, of, field.data());
    field.array.download(samples);
    return true;
  }

 private:
  template <class T>
  using List = DeviceList<Backend, T>;

  /// Allocates the arrays for a grid. Returns false if memory is short or tissue cannot be identified.
  bool fits(const Model& model, const Cuts& cuts, const Grid& grid) {
    const auto nodes = std::size_t(node_count(model.anatomy.lattice));
    if (nodes > ResampleView::kPartialVolume / ResampleView::kClaims) return false;
    if (model.params.solver.method == Method::kPbd && model.params.solver.pbd_stiffness == 0)
      return false;  // tissue is identified by its stiffness
    if (!fragments_.is_current && !fragments_.upload(model, cuts)) return false;
    const std::size_t corners =
        model.anatomy.tissue.size() + fragments_.virtual_nodes.count + 8 * fragments_.ghosts.count;
    return position_.try_resize(corners) && owner_.try_resize(sample_count(grid)) && moved_.try_resize(1) &&
           counts_.try_resize(kCounterCount);
  }
  bool upload_ct(const CtVolume& ct) { return ct_.count > 0 || ct_.try_assign(ct.samples); }
  /// View in units of nodes and without a CT. Chooses the fixed point from the largest displacements.
  template <class Run>
  ResampleView view(const Run& run, const Model& model, const Cuts& cuts, const BodyToResample& body,
                    const Grid& grid) {
    const VoxelCoordinates to = voxel_coordinates(model, grid);
    ResampleView view{.lattice = model.anatomy.lattice,
                      .nodes = body.nodes,
                      .cuts = fragments_.view(cuts, body),
                      .moved = moved_.data(),
                      .counts = counts_.data(),
                      .conserve_mass = false,
                      .volume_scale = 0,
                      .voxel_coordinates = to,
                      .window = {.low = {0, 0, 0}, .high = grid.size, .handedness = handedness(to)},
                      .rest = kNodeUnits,
                      .position = position_.data(),
                      .owner = owner_.data(),
                      .sample = CtSampler(nullptr, {1, 1, 1}),
                      .out = nullptr};
    // largest displacements
    MovedBits moved;
    moved_.array.upload({&moved, 1});
    counts_.array.upload(std::vector<ResampleCounts>(kCounterCount));
    run(std::size_t(node_count(view.lattice)), FindMoved{view});
    moved_.array.download({&moved, 1});
    view.window.bits = view.voxel_coordinates.bits = finest_bits(to, moved.low(), moved.high());
    view.volume_scale = volume_ratio(model, grid, view.window.bits);
    return view;
  }
  template <class Run>
  void fill_outside(const Run& run, const Model& model, const ResampleView& view, const CtVolume& ct,
                    const Grid& grid) {
    const PartialVolumeView partial_volume = surroundings_.view(model, view, ct, grid);
    if (!surroundings_.is_marked_for(grid)) mark_rest_with(run, partial_volume);
    surroundings_.marked_grid = grid;
    fill_outside_with(run, partial_volume);
  }
  ResampleReport report(const Grid& grid) const {
    std::vector<ResampleCounts> counters(kCounterCount);
    counts_.array.download(counters);
    ResampleCounts all;
    for (const ResampleCounts& counter : counters) {
      all.inverted_tets += counter.inverted_tets, all.claims += counter.claims;
      all.covered += counter.covered, all.mass += counter.mass;
    }
    const double mass = double(std::int64_t(all.mass)) * sample_volume(grid);
    return {.mass_error = rest_mass_ > 0 ? (mass - rest_mass_) / rest_mass_ : 0,
            .inverted_tets = long(all.inverted_tets),
            .overlaps = long(all.claims - all.covered)};
  }

  DeviceFragments<Backend> fragments_;
  DeviceSurroundings<Backend> surroundings_;
  List<std::int16_t> ct_;
  List<Int3> position_;
  List<std::uint32_t> owner_;
  List<MovedBits> moved_;
  List<ResampleCounts> counts_;
  bool is_mass_current_ = false;  // rest mass of the current cuts
  double rest_mass_ = 0;          // in the CT [HU m³]
};

}  // namespace turgor::lattice
