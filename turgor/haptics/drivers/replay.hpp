// A hand from a file: poses over time, written by a person or a program, in place of a device. It feels any
// force and does not yield.
#pragma once

#include <filesystem>
#include <vector>

#include "turgor/geometry/quaternion.hpp"
#include "turgor/haptics/device.hpp"
#include "turgor/haptics/drivers/devices.hpp"

namespace turgor::haptics {

/// A row of such a file.
struct PoseRow {
  double time = 0;                     // [s]
  Vec3d position;                      // in the device's frame [m]
  Quaternion orientation{1, 0, 0, 0};  // unit
  double grip = 0;                     // 0 open, 1 closed
  std::uint32_t buttons = 0;           // a bit each
};

/// A .csv file whose first line names its columns, in any order: time_s, x_m, y_m, z_m and, if wanted, all of
/// qw, qx, qy, qz, then grip and buttons. Error: file and line, what was expected, what was found.
Result<std::vector<PoseRow>> read_poses(const std::filesystem::path& file);

/// The hand at a time: straight and evenly between two rows, at rest before the first and after the last;
/// buttons are those of the row before. There is at least one row, times ascend.
DeviceInput pose_at(const std::vector<PoseRow>& rows, double time);

/// Time runs from the first exchange on.
class Replay final : public Device {
 public:
  explicit Replay(const DeviceOptions& options) : file_(options.file) {}

  Status open() override;
  const DeviceSpec& spec() const override { return spec_; }
  bool exchange(const DeviceOutput& output, DeviceInput& input) noexcept override;
  void close() noexcept override { rows_.clear(); }
  std::string trouble() const override { return rows_.empty() ? "replay: it is not open" : ""; }

 private:
  std::filesystem::path file_;
  std::vector<PoseRow> rows_;
  DeviceSpec spec_;
  double start_ = -1;  // of the first exchange [s]
};

void look_for_replay(const DeviceOptions& options, DeviceListing& listing);

}  // namespace turgor::haptics
