// The parts of a sheet on one side of a bus or the other: what nothing holds begins a step with the velocity
// that its total force gives it (component_kernels.hpp).
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "turgor/core/device_arrays.hpp"
#include "turgor/models/cloth/solver/component_kernels.hpp"

namespace turgor::cloth {

/// The parts of a sheet, those that nothing holds with their masses.
template <class Side>
class DeviceComponents {
 public:
  DeviceComponents(DeviceAllocator<Side>& rooms, const Model& m)
      : DeviceComponents(rooms, m, parts_of(m), pieces_of(m)) {}

  /// Which of them are held. The force's sums come from what is not.
  void keep(const Model& m, std::span<const Hold> holds) {
    any_free_ = false;
    for (std::size_t p = 0; p < whole_.size(); p++) {
      const auto at = std::lower_bound(holds.begin(), holds.end(), m.part_begin[p],
                                       [](const Hold& h, int v) { return h.vertex < v; });
      const bool is_held = at != holds.end() && at->vertex < m.part_begin[p + 1];
      whole_[p].mass = is_held ? 0 : masses_[p];
      any_free_ = any_free_ || !is_held;
    }
    parts_.upload(whole_);
  }
  template <class Run>
  void sum_drag(const Run& run, const SheetView& sheet) {
    if (any_free_) run(pieces_.size(), SumDrag{pieces_.data(), sheet.inverse[0], sums_.data()});
  }
  template <class Run>
  void start(const Run& run, const SheetView& sheet, double keep, bool has_air) {
    if (any_free_) {
      run(pieces_.size(), SumForce{pieces_.data(), sheet.force, sums_.data()});
      run(parts_.size(), FindPartVelocity{parts_.data(), sums_.data(), keep, has_air, velocity_.data()});
    }
    run(sheet.size, StartChange{sheet, part_of_.data(), any_free_ ? velocity_.data() : nullptr});
  }

 private:
  static constexpr int kPiece = 512;

  DeviceComponents(DeviceAllocator<Side>& rooms, const Model& m, std::vector<int> part_of,
                   std::vector<PartPiece> pieces)
      : part_of_(rooms.copy(part_of)),
        pieces_(rooms.copy(pieces)),
        sums_(rooms.template room<PartSum>(pieces.size())),
        velocity_(rooms.template room<Vec3>(m.part_begin.size() - 1)),
        parts_(rooms.template room<WholePart>(m.part_begin.size() - 1)) {
    int piece = 0;
    for (std::size_t p = 0; p + 1 < m.part_begin.size(); p++) {
      const int begin = m.part_begin[p], end = m.part_begin[p + 1];
      const int count = (end - begin + kPiece - 1) / kPiece;
      whole_.push_back({piece, piece + count, 0});
      piece += count;
      double mass = 0;
      for (int v = begin; v < end; v++) mass += double(m.mass[std::size_t(v)]);
      masses_.push_back(mass);
    }
  }
  static std::vector<int> parts_of(const Model& m) {
    std::vector<int> of(m.mass.size(), -1);
    for (std::size_t p = 0; p + 1 < m.part_begin.size(); p++)
      std::fill(of.begin() + m.part_begin[p], of.begin() + m.part_begin[p + 1], int(p));
    return of;
  }
  static std::vector<PartPiece> pieces_of(const Model& m) {
    std::vector<PartPiece> pieces;
    for (std::size_t p = 0; p + 1 < m.part_begin.size(); p++)
      for (int v = m.part_begin[p]; v < m.part_begin[p + 1]; v += kPiece)
        pieces.push_back({v, std::min(v + kPiece, m.part_begin[p + 1])});
    return pieces;
  }

  typename Side::template Array<int> part_of_;
  typename Side::template Array<PartPiece> pieces_;
  typename Side::template Array<PartSum> sums_;
  typename Side::template Array<Vec3> velocity_;
  typename Side::template Array<WholePart> parts_;
  std::vector<WholePart> whole_;
  std::vector<double> masses_;  // [kg]
  bool any_free_ = true;
};

}  // namespace turgor::cloth
