// The deformed CT and its fields on one side of the bus (device_body.hpp): what they need there beside the
// body, from when they are first asked for.
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

/// A body that is there.
struct BodyToResample {
  NodeArrays nodes;
  const std::uint8_t* removed;
  const VirtualNodeShift* shifts;  // State::copies
  std::size_t shift_count;
};

/// The pieces of a cut body, as they are after the last cut.
template <class Side>
struct DeviceFragments {
  template <class T>
  using List = DeviceList<Side, T>;

  FineLattice fine{};
  bool known = false;
  List<CutCell> cells;
  List<Fragment> pieces;
  List<VirtualNode> virtual_nodes;
  List<FitTerm> sources;
  List<GhostFragment> ghosts;
  List<std::int16_t> label;
  List<KeyEntry> edge_index;
  List<CutEdge> edges;
  List<SpecialCell> special;
  List<std::uint8_t> is_special;  // by slot

  bool put(const Model& model, const State& cuts) {
    const Fragments now = make_fragments(model, cuts);
    fine = now.fine;
    const std::vector<SpecialCell> cells_now = special_cells(model, cuts, now);
    known = cells.holds(now.cells) && pieces.holds(now.pieces) && virtual_nodes.holds(now.virtual_nodes) &&
            sources.holds(now.sources) && ghosts.holds(now.ghosts) && label.holds(now.label) &&
            edge_index.holds(now.edge_index.entries()) && edges.holds(cuts.cut_edges) &&
            special.holds(cells_now) && is_special.fits(cells_now.empty() ? 0 : model.tissue.size());
    return known;
  }
  ResampleCuts view(const State& cuts, const BodyToResample& body) const {
    return {.pieces = {.fine = fine,
                       .cells = cells.data(),
                       .pieces = pieces.data(),
                       .virtual_nodes = virtual_nodes.data(),
                       .sources = sources.data(),
                       .ghosts = ghosts.data(),
                       .first_ghost_place = slot_count(fine.cells) + int(virtual_nodes.count),
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

/// What lies beside the body in the CT, and where the CT shows the body on a grid.
template <class Side>
struct DeviceSurroundings {
  template <class T>
  using List = DeviceList<Side, T>;

  List<std::uint8_t> marks, mask, row_mask;  // of RestBody, of BesideBody
  Int3 cell, size;                           // of BesideBody
  List<std::uint8_t> rest, near_rest;        // by voxel
  Grid known;                                // whose voxels these are

  bool put(const Exec& exec, const Model& model, const CtVolume& ct) {
    if (marks.count > 0) return true;
    const RestFrame frame = rest_frame(model, ct.grid);
    const Surroundings beside = find_beside_body(exec, ct, model.params.tissue.air_max);
    cell = beside.cell, size = beside.size;
    return mask.holds(beside.mask) && row_mask.holds(beside.row_mask) &&
           marks.holds(RestBody(exec, model, frame.first_node, frame.cell_size).marks());
  }
  bool fits(std::size_t voxels) { return rest.fits(voxels) && near_rest.fits(voxels); }
  PartialVolumeView view(const Model& model, const ResampleView& body, const CtVolume& ct,
                         const Grid& grid) const {
    const RestFrame frame = rest_frame(model, ct.grid);
    const Vec3d side = frame.cell_size;
    const RestBodyView at_rest{.lattice = model.lattice,
                               .first_node = frame.first_node,
                               .per_cell = {1 / side.x, 1 / side.y, 1 / side.z},
                               .marks = marks.data()};
    PartialVolumeView f{.v = body,
                        .value = voxel_beside(ct, model.params.tissue.air_max, grid, at_rest,
                                              {cell, size, mask.data(), row_mask.data()}),
                        .rest = rest.data(),
                        .near_rest = near_rest.data(),
                        .reach = reach_in(grid, ct.grid)};
    f.value.sample = body.sample;
    return f;
  }
  /// The marks by voxel are those of this grid.
  bool knows(const Grid& grid) const {
    return known.size == grid.size && known.spacing == grid.spacing && known.origin == grid.origin &&
           known.axes == grid.axes;
  }
};

template <class Side>
struct DeviceSampleArray final : DeviceSamples {
  typename Side::template Array<std::int16_t> room;

  explicit DeviceSampleArray(std::size_t count) : room(count) {}
  const std::int16_t* data() const override { return room.data(); }
  void get(std::span<std::int16_t> samples) const override { room.download(samples); }
};

template <class Side>
class DeviceResampling {
 public:
  /// Pieces are not those of the state that is there.
  void forget_cuts() { pieces_.known = knows_mass_ = false; }

  /// resample_ct. `cuts`: what blades did to the state that is there; its places are not looked at. Nothing
  /// where there is no room, or no stiffness.
  template <class Run>
  std::optional<DeviceResampled> make(const Run& run, const Exec& exec, const Model& model, const State& cuts,
                                      const BodyToResample& body, const CtVolume& ct, const Grid& grid,
                                      const ResampleOptions& options) {
    const bool beside = options.keep_surroundings;
    if (!fits(model, cuts, grid) || !teleports(ct)) return {};
    const auto out = std::make_shared<DeviceSampleArray<Side>>(sample_count(grid));
    if (!out->room.is_allocated()) return {};
    if (beside && !(beside_.put(exec, model, ct) && beside_.fits(sample_count(grid)))) return {};
    if (!std::exchange(knows_mass_, true)) rest_mass_ = rest_mass(exec, model, cuts, ct);
    ResampleView view = this->view(run, model, cuts, body, grid);
    view.rest = rest_frame(model, ct.grid);
    view.sample = Sampler(ct_.data(), ct.grid.size);
    view.conserve_mass = options.conserve_mass;
    view.out = out->room.data();
    resample_with(run, view);
    if (beside) fill_beside(run, model, view, ct, grid);
    return DeviceResampled{grid, out, report(grid)};
  }
  /// A field of deformed_fields.hpp, made there and brought here. False where there is no room.
  template <class Run, class Of, class Sample>
  bool get_field(const Run& run, const Model& model, const State& cuts, const BodyToResample& body,
                 const Grid& grid, const Of& of, std::span<Sample> samples) {
    List<Sample> field;
    if (!fits(model, cuts, grid) || !field.fits(samples.size())) return false;
    const ResampleView view = this->view(run, model, cuts, body, grid);
    claim_with(run, view);
    fill_field_with(run, view, of, field.data());
    field.room.download(samples);
    return true;
  }

 private:
  template <class T>
  using List = DeviceList<Side, T>;

  /// For whatever is asked of the voxels of a grid. Is it known whose they are?
  bool fits(const Model& model, const State& cuts, const Grid& grid) {
    const auto nodes = std::size_t(node_count(model.lattice));
    if (nodes > ResampleView::kBeside / ResampleView::kClaims) return false;
    if (model.params.solver.method == Method::kPbd && model.params.solver.pbd_stiffness == 0)
      return false;  // tissue is known by its stiffness
    if (!pieces_.known && !pieces_.put(model, cuts)) return false;
    const std::size_t corners = model.tissue.size() + pieces_.virtual_nodes.count + 8 * pieces_.ghosts.count;
    return place_.fits(corners) && owner_.fits(sample_count(grid)) && moved_.fits(1) &&
           counts_.fits(kCountParts);
  }
  bool teleports(const CtVolume& ct) { return ct_.count > 0 || ct_.holds(ct.samples); }
  /// In nodes, and without a CT to sample. Chooses the fixed point by how far the body has moved.
  template <class Run>
  ResampleView view(const Run& run, const Model& model, const State& cuts, const BodyToResample& body,
                    const Grid& grid) {
    const VoxelCoordinates to = voxel_coordinates(model, grid);
    ResampleView view{.lattice = model.lattice,
                      .nodes = body.nodes,
                      .cuts = pieces_.view(cuts, body),
                      .moved = moved_.data(),
                      .counts = counts_.data(),
                      .conserve_mass = false,
                      .to_ratio = 0,
                      .voxel_coordinates = to,
                      .window = {.low = {0, 0, 0}, .high = grid.size, .handed = handed(to)},
                      .rest = kInNodes,
                      .place = place_.data(),
                      .owner = owner_.data(),
                      .sample = Sampler(nullptr, {1, 1, 1}),
                      .out = nullptr};
    MovedBits moved;
    moved_.room.upload({&moved, 1});
    counts_.room.upload(std::vector<ResampleCounts>(kCountParts));
    run(std::size_t(node_count(view.lattice)), FindMoved{view});
    moved_.room.download({&moved, 1});
    view.window.bits = view.voxel_coordinates.bits = finest_bits(to, moved.low(), moved.high());
    view.to_ratio = volume_ratio(model, grid, view.window.bits);
    return view;
  }
  template <class Run>
  void fill_beside(const Run& run, const Model& model, const ResampleView& view, const CtVolume& ct,
                   const Grid& grid) {
    const PartialVolumeView partial_volume = beside_.view(model, view, ct, grid);
    if (!beside_.knows(grid)) mark_rest_with(run, partial_volume);
    beside_.known = grid;
    fill_beside_with(run, partial_volume);
  }
  ResampleReport report(const Grid& grid) const {
    std::vector<ResampleCounts> parts(kCountParts);
    counts_.room.download(parts);
    ResampleCounts all;
    for (const ResampleCounts& part : parts) {
      all.folds += part.folds, all.claims += part.claims;
      all.covered += part.covered, all.mass += part.mass;
    }
    const double mass = double(std::int64_t(all.mass)) * sample_volume(grid);
    return {.mass_error = rest_mass_ > 0 ? (mass - rest_mass_) / rest_mass_ : 0,
            .folds = long(all.folds),
            .overlaps = long(all.claims - all.covered)};
  }

  DeviceFragments<Side> pieces_;
  DeviceSurroundings<Side> beside_;
  List<std::int16_t> ct_;
  List<Int3> place_;
  List<std::uint32_t> owner_;
  List<MovedBits> moved_;
  List<ResampleCounts> counts_;
  bool knows_mass_ = false;  // of the body as it is cut:
  double rest_mass_ = 0;     // in the CT [HU m³]
};

}  // namespace turgor::lattice
