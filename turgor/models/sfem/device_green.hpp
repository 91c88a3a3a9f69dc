// The dense store of Green's functions, made on one side of the bus or the other (green_kernels.hpp).
#pragma once

#include <algorithm>
#include <vector>

#include "turgor/core/device_arrays.hpp"
#include "turgor/core/progress.hpp"
#include "turgor/models/sfem/cholesky.hpp"
#include "turgor/models/sfem/green_kernels.hpp"
#include "turgor/models/sfem/stored_permutation.hpp"

namespace turgor::sfem {

/// What is to be solved, and in which order.
struct ColumnPlan {
  KeptPlaces kept;
  std::vector<double> values;              // ColumnsView::values, and room to read beyond its end
  std::vector<std::vector<RowTile>> down;  // by distance from the roots, supernodes ascending
};
ColumnPlan plan_columns(const Model& model);
/// Those of the rows below the supernodes that forces at these rows of K come through, one supernode after
/// another: `begin` has one entry more than there are such supernodes.
struct UpPlan {
  std::vector<unsigned char> on_path;
  std::vector<RowTile> tiles;
  std::vector<std::size_t> begin;
};
UpPlan plan_up(const Elimination& plan, std::span<const int> rows);

/// `T`: of the store.
template <class Side, class T>
class DeviceGreen {
 public:
  template <class V>
  using Array = typename Side::template Array<V>;

  /// The columns of `together` nodes are solved at once.
  DeviceGreen(const Model& model, DeviceAllocator<Side>& rooms, std::size_t together = 1024)
      : plan_(model.factor->plan),
        columns_(plan_columns(model)),
        nodes_(columns_.kept.place.size()),
        together_(std::min(together, nodes_)) {
    for (const std::vector<RowTile>& level : columns_.down) down_.push_back(rooms.copy(level));
    supernodes_ = rooms.copy(plan_.supernodes);
    rows_ = rooms.copy(plan_.rows);
    values_ = rooms.copy(columns_.values);
    place_ = rooms.copy(columns_.kept.place);
    forces_ = rooms.template room<double>(9 * plan_.order.size() * together_);
    x_ = rooms.template room<double>(9 * plan_.order.size() * together_);
    places_ = rooms.template room<int>(together_), slots_ = rooms.template room<int>(together_);
    on_path_ = rooms.template room<unsigned char>(plan_.supernodes.size());
    store_ = rooms.template room<T>(9 * nodes_ * nodes_);
    std::size_t most = 0;  // all supernodes may be on a path
    for (const Supernode& s : plan_.supernodes) most += tiles_of(3 * s.row_count);
    up_ = rooms.template room<RowTile>(most);
  }

  static std::size_t tiles_of(std::size_t rows) { return (rows + RowTile::kRows - 1) / RowTile::kRows; }

  void fill(std::span<T> values, const Progress& progress) {
    for (std::size_t first = 0; first < nodes_; first += together_) {
      const std::size_t count = std::min(together_, nodes_ - first);
      solve(std::span<const int>(columns_.kept.by_place).subspan(first, count));
      if (progress) progress(double(first + count) / double(nodes_));
    }
    run_(store_.size(), MirrorStore<T>{store()});
    store_.download(values);
  }

 private:
  const Elimination& plan_;
  ColumnPlan columns_;
  std::size_t nodes_, together_;
  typename Side::Run run_;
  std::vector<Array<RowTile>> down_;
  Array<RowTile> up_;
  Array<Supernode> supernodes_;
  Array<int> rows_, place_, places_, slots_;
  Array<double> values_, forces_, x_;
  Array<unsigned char> on_path_;
  Array<T> store_;

  StoreView<T> store() const { return {store_.data(), 3 * nodes_, place_.data()}; }

  /// The columns of these kept nodes, each down to the first one's place.
  void solve(std::span<const int> slots) {
    std::vector<int> places, rows;
    for (const int slot : slots)
      places.push_back(columns_.kept.place[std::size_t(slot)]),
          rows.push_back(columns_.kept.rows[std::size_t(slot)]);
    const UpPlan up = plan_up(plan_, rows);
    places_.upload(places), slots_.upload(slots);
    up_.upload(up.tiles), on_path_.upload(up.on_path);
    const ColumnsView v{supernodes_.data(), rows_.data(), values_.data(),
                        forces_.data(),     x_.data(),    3 * slots.size()};
    run_(3 * plan_.order.size() * v.columns, ClearForces{v.forces}, 4096);
    run_(v.columns, SetUnits{v, places_.data()});
    for (std::size_t n = 0; n + 1 < up.begin.size(); n++)
      run_((up.begin[n + 1] - up.begin[n]) * v.columns, SolveUp{v, up_.data() + up.begin[n]});
    for (std::size_t level = 0; level < down_.size(); level++) {
      const std::vector<RowTile>& tiles = columns_.down[level];
      const auto begin = std::partition_point(tiles.begin(), tiles.end(), [&](const RowTile& tile) {
        const Supernode& s = plan_.supernodes[std::size_t(tile.supernode)];
        return s.first + s.count <= places.front();
      });
      run_(std::size_t(tiles.end() - begin) * v.columns,
           SolveDown{v, down_[level].data() + (begin - tiles.begin()), on_path_.data()});
    }
    run_(3 * nodes_ * v.columns, StoreColumns<T>{v, store(), slots_.data()}, 4096);
  }
};

}  // namespace turgor::sfem
