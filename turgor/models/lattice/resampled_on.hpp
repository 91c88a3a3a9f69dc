// The deformed CT on one side of the bus (body_on.hpp): what it needs there beside the body, from when it is
// first asked for.
#pragma once

#include <optional>

#include "turgor/models/lattice/arrays_on.hpp"
#include "turgor/models/lattice/resample_loops.hpp"

namespace turgor::lattice {

/// A body that is there.
struct BodyToResample {
  NodeArrays nodes;
  const std::uint8_t* removed;
  const CopyShift* shifts;  // State::copies
  std::size_t shift_count;
};

/// The pieces of a cut body, as they are after the last cut.
template <class Side>
struct PiecesOn {
  template <class T>
  using List = ListOn<Side, T>;

  FineLattice fine{};
  bool known = false;
  List<CutCell> cells;
  List<Piece> pieces;
  List<NodeCopy> copies;
  List<CopySource> sources;
  List<std::int16_t> label;
  List<KeyEntry> edge_index;
  List<CutEdge> edges;
  List<SpecialCell> special;
  List<std::uint8_t> is_special;  // by slot

  bool put(const Model& model, const State& cuts) {
    const Pieces now = make_pieces(model, cuts);
    fine = now.fine;
    const std::vector<SpecialCell> cells_now = special_cells(model, cuts, now);
    known = cells.holds(now.cells) && pieces.holds(now.pieces) && copies.holds(now.copies) &&
            sources.holds(now.sources) && label.holds(now.label) &&
            edge_index.holds(now.edge_index.entries()) && edges.holds(cuts.cut_edges) &&
            special.holds(cells_now) && is_special.fits(cells_now.empty() ? 0 : model.tissue.size());
    return known;
  }
  ResampleCuts view(const State& cuts, const BodyToResample& body) const {
    return {.pieces = {.fine = fine,
                       .cells = cells.data(),
                       .pieces = pieces.data(),
                       .copies = copies.data(),
                       .sources = sources.data(),
                       .label = label.data(),
                       .edge_index = {edge_index.data(), edge_index.count},
                       .edges = edges.data(),
                       .shifts = body.shift_count == copies.count ? body.shifts : nullptr},
            .copy_count = int(copies.count),
            .special = special.data(),
            .special_count = int(special.count),
            .is_special = special.count > 0 ? is_special.data() : nullptr,
            .removed = cuts.removed_nodes > 0 ? body.removed : nullptr};
  }
};

template <class Side>
class ResampledOn {
 public:
  /// Pieces are not those of the state that is there.
  void forget_cuts() { pieces_.known = false; }

  /// `cuts`: what blades did to the state that is there; its places are not looked at. Nothing where there is
  /// no room.
  template <class Run>
  std::optional<CtVolume> make(const Run& run, const Model& model, const State& cuts,
                               const BodyToResample& body, const CtVolume& ct, const Grid& grid) {
    CtVolume now{.grid = grid, .samples = {}};
    now.samples.resize(sample_count(grid));
    const auto nodes = std::size_t(node_count(model.lattice));
    if (nodes > ResampleView::kNobody / ResampleView::kClaims) return {};
    if (!pieces_.known && !pieces_.put(model, cuts)) return {};
    if (!fits(model.tissue.size() + pieces_.copies.count, ct, now.samples.size())) return {};
    ResampleView view = this->view(model, cuts, body, ct, grid);
    MovedBits moved;
    moved_.room.upload({&moved, 1});
    run(nodes, FindMoved{view});
    moved_.room.download({&moved, 1});
    view.window.bits = view.to_voxels.bits = finest_bits(view.to_voxels, moved.low(), moved.high());
    resample_with(run, view);
    out_.room.download(now.samples);
    return now;
  }

 private:
  template <class T>
  using List = ListOn<Side, T>;

  bool fits(std::size_t corners, const CtVolume& ct, std::size_t voxels) {
    const bool is_new = ct_.count == 0;
    const bool all = ct_.fits(ct.samples.size()) && out_.fits(voxels) && place_.fits(corners) &&
                     owner_.fits(voxels) && moved_.fits(1);
    if (all && is_new) ct_.room.upload(ct.samples);
    return all;
  }
  ResampleView view(const Model& model, const State& cuts, const BodyToResample& body, const CtVolume& ct,
                    const Grid& grid) const {
    const ToVoxels to = to_voxels(model, grid);
    const Vec3d voxel = ct.grid.spacing, step = model.grid.spacing;
    return {.lattice = model.lattice,
            .nodes = body.nodes,
            .cuts = pieces_.view(cuts, body),
            .moved = moved_.data(),
            .to_voxels = to,
            .window = {.low = {0, 0, 0}, .high = grid.size, .handed = handed(to)},
            .rest = {.first_node = index_at(ct.grid, model.grid.origin),
                     .cell_size = {step.x / voxel.x, step.y / voxel.y, step.z / voxel.z}},
            .place = place_.data(),
            .owner = owner_.data(),
            .sample = Sampler(ct_.data(), ct.grid.size),
            .out = out_.data()};
  }

  PiecesOn<Side> pieces_;
  List<std::int16_t> ct_, out_;
  List<Int3> place_;
  List<std::uint32_t> owner_;
  List<MovedBits> moved_;
};

}  // namespace turgor::lattice
