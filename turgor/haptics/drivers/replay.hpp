// Replay of a hand's poses over time from a file, without a device. Forces do not move the hand.
#pragma once

#include <filesystem>
#include <vector>

#include "turgor/geometry/quaternion.hpp"
#include "turgor/haptics/device.hpp"
#include "turgor/haptics/drivers/devices.hpp"

namespace turgor::haptics {

/// One row of the file.
struct PoseRow {
  double time = 0;                     // [s]
  Vec3d position;                      // in the device's frame [m]
  Quaternion orientation{1, 0, 0, 0};  // unit
  bool has_orientation = false;        // false: the file has none
  double grip = 0;                     // 0 open, 1 closed
  std::uint32_t buttons = 0;           // a bit each
};

/// Reads a .csv file whose first line names its columns, in any order: time_s, x_m, y_m, z_m and, optionally,
/// all of qw, qx, qy, qz, then grip and buttons. Error: file and line, expected and found content.
Result<std::vector<PoseRow>> read_poses(const std::filesystem::path& file);

/// Hand at a time: linear between two rows, at rest before the first and after the last. Buttons are those of
/// the row before. Requires at least one row and ascending times.
DeviceInput pose_at(const std::vector<PoseRow>& rows, double time);

/// Device that replays a file. Time starts at the first exchange.
class Replay final : public Device {
 public:
  explicit Replay(const DeviceOptions& options) : file_(options.file) {}

  Status open() override;
  const DeviceSpec& spec() const override { return spec_; }
  bool exchange(const DeviceOutput& output, DeviceInput& input) noexcept override;
  void close() noexcept override { rows_.clear(); }
  std::string trouble() const override { return rows_.empty() ? "replay: the device is not open" : ""; }

 private:
  std::filesystem::path file_;
  std::vector<PoseRow> rows_;
  DeviceSpec spec_;
  double start_ = -1;  // of the first exchange [s]
};

void list_replay(const DeviceOptions& options, DeviceListing& listing);

}  // namespace turgor::haptics
