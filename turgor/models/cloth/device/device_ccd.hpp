// Whether anything of a sheet would meet on its way through a step, on one side of a bus or the other. It
// says yes or no alone: where it says no, avoid_crossings would change nothing, and where it says yes, which
// is rare, avoid_crossings has to be asked.
#pragma once

#include "turgor/core/device_arrays.hpp"
#include "turgor/models/cloth/ccd/ccd_kernels.hpp"

namespace turgor::cloth {

template <class Side>
class DeviceCcd {
 public:
  /// Of a model that has self-collision; others need nothing.
  DeviceCcd(DeviceAllocator<Side>& rooms, const Model& m) : count_(m.params.collision.self ? m.count : 0) {
    begin_.push_back(0);
    for (int size = (count_ + kGuardLeaf - 1) / kGuardLeaf; size > 0; size = size > 1 ? (size + 1) / 2 : 0)
      begin_.push_back(begin_.back() + size);
    boxes_ = rooms.template room<MotionBox>(std::size_t(begin_.back()));
    pairs_ = rooms.template room<VertexPair>(std::size_t(count_));
    answer_ = rooms.template room<CcdResult>(1);
  }

  /// From `before` to `x`: would anything meet?
  template <class Run>
  bool would_meet(const Run& run, const SheetView& sheet, const Int3* triangles, TrianglesAround around,
                  double thickness) {
    CcdView g{sheet,  triangles, around,        boxes_.data(), {}, int(begin_.size()) - 1,
              count_, thickness, pairs_.data(), answer_.data()};
    std::copy(begin_.begin(), begin_.end(), g.level_begin);
    CcdResult answer;
    answer_.upload({&answer, 1});
    run(sheet.size, SetMotion{sheet});
    run(sheet.size, MeasureUp{g});
    run(sheet.size, MeasureFlatness{g});
    run(std::size_t(begin_[1]), PlaceLeaf{g});
    for (int level = 1; level < g.levels; level++)
      run(std::size_t(begin_[std::size_t(level) + 1] - begin_[std::size_t(level)]), PlaceLevel{g, level});
    run(std::size_t(count_), ListPairs{g});
    run(std::size_t(count_), LookAtPair{g});
    run(std::size_t(count_), LookAtUnlisted{g});
    answer_.download({&answer, 1});
    return answer.meets != 0;
  }

 private:
  int count_;
  std::vector<int> begin_;  // first box of each level, and the end
  typename Side::template Array<MotionBox> boxes_;
  typename Side::template Array<VertexPair> pairs_;
  typename Side::template Array<CcdResult> answer_;
};

}  // namespace turgor::cloth
