// CCD on the device: tells whether anything would collide in a step. If not, resolve_ccd would change
// nothing; otherwise, which is rare, the host runs resolve_ccd.
#pragma once

#include "turgor/core/device_arrays.hpp"
#include "turgor/models/cloth/ccd/ccd_kernels.hpp"
#include "turgor/models/cloth/model/state.hpp"

namespace turgor::cloth {

template <class Backend>
class DeviceCcd {
 public:
  /// Allocates nothing for models without self-collision.
  DeviceCcd(DeviceAllocator<Backend>& allocator, const Model& m)
      : count_(m.params.collision.self ? m.count : 0) {
    begin_.push_back(0);
    for (int size = (count_ + kCcdLeaf - 1) / kCcdLeaf; size > 0; size = size > 1 ? (size + 1) / 2 : 0)
      begin_.push_back(begin_.back() + size);
    boxes_ = allocator.template allocate<MotionBox>(std::size_t(begin_.back()));
    pairs_ = allocator.template allocate<VertexPair>(std::size_t(count_));
    answer_ = allocator.template allocate<CcdResult>(1);
  }

  /// True if anything collides in the motion from System::previous to x.
  template <class Run>
  bool any_collision(const Run& run, const SheetView& sheet, const Int3* triangles, TrianglesAround around,
                     double thickness) {
    // view and cleared result
    CcdView g{ccd_motion(sheet),      sheet.x_rest, triangles, around,        boxes_.data(), {},
              int(begin_.size()) - 1, count_,       thickness, pairs_.data(), answer_.data()};
    std::copy(begin_.begin(), begin_.end(), g.level_begin);
    CcdResult answer;
    answer_.upload({&answer, 1});
    // displacements, normals and flatness
    run(sheet.size, SetDisplacement{sheet.x, g.motion});
    run(sheet.size, MeasureNormals{g});
    run(sheet.size, MeasureFlatness{g});
    // box tree
    run(std::size_t(begin_[1]), BuildLeaf{g});
    for (int level = 1; level < g.levels; level++)
      run(std::size_t(begin_[std::size_t(level) + 1] - begin_[std::size_t(level)]), BuildLevel{g, level});
    // pairs and their tests
    run(std::size_t(count_), ListPairs{g});
    run(std::size_t(count_), TestPair{g});
    run(std::size_t(count_), TestUnlisted{g});
    answer_.download({&answer, 1});
    return answer.collides != 0;
  }

 private:
  int count_;
  std::vector<int> begin_;  // first box of each level, and the end
  typename Backend::template Array<MotionBox> boxes_;
  typename Backend::template Array<VertexPair> pairs_;
  typename Backend::template Array<CcdResult> answer_;
};

}  // namespace turgor::cloth
