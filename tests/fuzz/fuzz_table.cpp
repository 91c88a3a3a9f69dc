// Any bytes as the tables that people bring, a measured force–depth curve, a tool's path and a recorded hand:
// an error that names the file, or rows of finite numbers in order, never a crash.
#include <cmath>
#include <cstdint>
#include <fstream>

#include "fuzz_input.hpp"
#include "tests/folders.hpp"
#include "turgor/sim/tools/force_curve.hpp"
#include "turgor/sim/tools/hand.hpp"
#include "turgor/sim/tools/tool_path.hpp"

namespace {

namespace fs = std::filesystem;

void check(const std::vector<turgor::rhombus::CurvePoint>& curve) {
  require(!curve.empty());
  for (const turgor::rhombus::CurvePoint& point : curve)
    require(std::isfinite(point.depth) && std::isfinite(point.force));
}

void check(const std::vector<turgor::PathRow>& rows) {
  require(!rows.empty());
  for (std::size_t i = 0; i < rows.size(); i++) {
    require(std::isfinite(rows[i].time));
    for (int axis = 0; axis < 3; axis++) require(std::isfinite(rows[i].position[axis]));
    require(i == 0 || rows[i].time > rows[i - 1].time);
    const turgor::Mat3d axes = turgor::axes_of(rows[i].orientation);
    for (const turgor::Vec3d& axis : axes.column) require(std::abs(norm(axis) - 1) < 1e-6);
  }
}

void check(const std::vector<turgor::HandRow>& hand) {
  require(!hand.empty());
  for (const auto& [time, command] : hand)
    require(std::isfinite(time) && turgor::contact::is_valid(command.pose) && command.grip >= 0 &&
            command.grip <= 1);
  check(turgor::path_of(hand).rows);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  static const fs::path folder = turgor::test::fresh_folder();
  const fs::path file = folder / "table.csv";
  std::ofstream(file, std::ios::binary).write(reinterpret_cast<const char*>(bytes), std::streamsize(size));
  const auto curve = turgor::read_force_curve(file);
  curve ? check(*curve) : require(curve.error().message.find("/table.csv") != std::string::npos);
  const auto rows = turgor::read_path_rows(file);
  rows ? check(*rows) : require(rows.error().message.find("/table.csv") != std::string::npos);
  const auto hand = turgor::read_hand(file, "finger");
  hand ? check(*hand) : require(hand.error().message.find("/table.csv") != std::string::npos);
  return 0;
}
