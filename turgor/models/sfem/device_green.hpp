// Computation of the dense store of Green's functions on a device or on the host (green_kernels.hpp).
#pragma once

#include <algorithm>
#include <vector>

#include "turgor/core/assert.hpp"
#include "turgor/core/device_arrays.hpp"
#include "turgor/core/progress.hpp"
#include "turgor/models/sfem/cholesky.hpp"
#include "turgor/models/sfem/green_kernels.hpp"
#include "turgor/models/sfem/stored_permutation.hpp"

namespace turgor::sfem {

/// Columns to be solved and the order of their computation.
struct ColumnPlan {
  StoredPermutation stored;
  std::vector<double> values;              // ColumnsView::values, padded for reads beyond the end
  std::vector<std::vector<RowTile>> down;  // by distance from the roots, supernodes ascending
};
ColumnPlan plan_columns(const Model& model);
/// Row tiles of the supernodes on the elimination path of forces at these rows of K, one supernode after
/// another. `begin` has one entry more than the number of such supernodes.
struct UpPlan {
  std::vector<unsigned char> on_path;
  std::vector<RowTile> tiles;
  std::vector<std::size_t> begin;
};
UpPlan plan_up(const Elimination& plan, std::span<const int> rows);

/// `T`: number type of the store.
template <class Backend, class T>
class DeviceGreen {
 public:
  template <class V>
  using Array = typename Backend::template Array<V>;

  /// Number of nodes whose columns are solved at once.
  DeviceGreen(const Model& model, DeviceAllocator<Backend>& allocator, std::size_t together = 1024)
      : plan_(model.factor->plan),
        columns_(plan_columns(model)),
        nodes_(columns_.stored.position.size()),
        together_(std::min(together, nodes_)) {
    for (const std::vector<RowTile>& level : columns_.down) down_.push_back(allocator.copy(level));
    supernodes_ = allocator.copy(plan_.supernodes);
    rows_ = allocator.copy(plan_.rows);
    values_ = allocator.copy(columns_.values);
    positions_ = allocator.copy(columns_.stored.position);
    forces_ = allocator.template allocate<double>(9 * plan_.order.size() * together_);
    x_ = allocator.template allocate<double>(9 * plan_.order.size() * together_);
    unit_positions_ = allocator.template allocate<int>(together_),
    slots_ = allocator.template allocate<int>(together_);
    on_path_ = allocator.template allocate<unsigned char>(plan_.supernodes.size());
    store_ = allocator.template allocate<T>(9 * nodes_ * nodes_);
    std::size_t most = 0;  // all supernodes may be on a path
    for (const Supernode& s : plan_.supernodes) most += tiles_of(3 * s.row_count);
    up_ = allocator.template allocate<RowTile>(most);
  }

  static std::size_t tiles_of(std::size_t rows) { return (rows + RowTile::kRows - 1) / RowTile::kRows; }

  void fill(std::span<T> values, const Progress& progress) {
    TURGOR_CHECK(values.size() == store_.size(), "the host store has the size of that on the device");
    for (std::size_t first = 0; first < nodes_; first += together_) {
      const std::size_t count = std::min(together_, nodes_ - first);
      solve(std::span<const int>(columns_.stored.by_position).subspan(first, count));
      if (progress) progress(double(first + count) / double(nodes_));
    }
    run_(store_.size(), MirrorStore<T>{store()});
    store_.download(values);
  }

 private:
  const Elimination& plan_;
  ColumnPlan columns_;
  std::size_t nodes_, together_;
  typename Backend::Run run_;
  std::vector<Array<RowTile>> down_;
  Array<RowTile> up_;
  Array<Supernode> supernodes_;
  Array<int> rows_, positions_, unit_positions_, slots_;
  Array<double> values_, forces_, x_;
  Array<unsigned char> on_path_;
  Array<T> store_;

  StoreView<T> store() const { return {store_.data(), 3 * nodes_, positions_.data()}; }

  /// Solves the columns of these stored nodes, each down to the first one's position.
  void solve(std::span<const int> slots) {
    // positions and paths, uploaded
    TURGOR_CHECK(slots.size() <= together_, "the columns fit the allocated arrays");
    std::vector<int> positions, rows;
    for (const int slot : slots)
      positions.push_back(columns_.stored.position[std::size_t(slot)]),
          rows.push_back(columns_.stored.rows[std::size_t(slot)]);
    const UpPlan up = plan_up(plan_, rows);
    unit_positions_.upload(positions), slots_.upload(slots);
    up_.upload(up.tiles), on_path_.upload(up.on_path);
    const ColumnsView v{supernodes_.data(), rows_.data(), values_.data(),
                        forces_.data(),     x_.data(),    3 * slots.size()};
    // unit forces
    run_(3 * plan_.order.size() * v.columns, ClearForces{v.forces}, 4096);
    run_(v.columns, SetUnits{v, unit_positions_.data()});
    // forward along the paths
    for (std::size_t n = 0; n + 1 < up.begin.size(); n++)
      run_((up.begin[n + 1] - up.begin[n]) * v.columns, SolveUp{v, up_.data() + up.begin[n]});
    // backward, level by level, down to the first position
    for (std::size_t level = 0; level < down_.size(); level++) {
      const std::vector<RowTile>& tiles = columns_.down[level];
      const auto begin = std::partition_point(tiles.begin(), tiles.end(), [&](const RowTile& tile) {
        const Supernode& s = plan_.supernodes[std::size_t(tile.supernode)];
        return s.first + s.count <= positions.front();
      });
      run_(std::size_t(tiles.end() - begin) * v.columns,
           SolveDown{v, down_[level].data() + (begin - tiles.begin()), on_path_.data()});
    }
    // store
    run_(3 * nodes_ * v.columns, StoreColumns<T>{v, store(), slots_.data()}, 4096);
  }
};

}  // namespace turgor::sfem
