// Types of Force Dimension arms, with limits that are known to be stable.
#include <algorithm>
#include <iterator>

#include "turgor/haptics/drivers/dhd.hpp"

namespace turgor::haptics {

namespace {

struct Type {
  int type;
  double force;       // [N]
  double stiffness;   // [N/m]
  double damping;     // [N·s/m]
  double radius;      // of the workspace [m]
  double torque;      // of wrists with motors [N·m]
  double grip_force;  // [N]
  double rate;        // [Hz]
};

constexpr Type kTypes[] = {
    {33, 12, 5000, 30, 0.075, 0, 0, 4000},      // omega.3
    {34, 12, 5000, 30, 0.075, 0, 0, 4000},      // omega.6, right
    {36, 12, 5000, 30, 0.075, 0, 0, 4000},      // left
    {35, 12, 5000, 30, 0.075, 0, 8, 4000},      // omega.7
    {37, 12, 5000, 30, 0.075, 0, 8, 4000},      // left
    {63, 20, 5000, 30, 0.15, 0, 0, 4000},       // delta.3
    {206, 12, 4000, 30, 0.075, 0, 0, 4000},     // sigma.3
    {104, 12, 4000, 30, 0.075, 0.2, 8, 4000},   // sigma.7
    {105, 12, 4000, 30, 0.075, 0.2, 8, 4000},   // left
    {203, 12, 8000, 30, 0.1125, 0, 0, 4000},    // lambda.3
    {131, 12, 8000, 30, 0.1125, 0.2, 0, 4000},  // lambda.6
    {132, 12, 8000, 30, 0.1125, 0.2, 0, 4000},  // left
    {108, 12, 8000, 30, 0.1125, 0.2, 8, 4000},  // lambda.7
    {109, 12, 8000, 30, 0.1125, 0.2, 8, 4000},  // left
    {60, 8, 3000, 20, 0.04, 0, 0, 1000},        // Novint Falcon
};
/// Weak limits for an unknown arm.
constexpr Type kUnknown{0, 5, 1000, 10, 0.04, 0, 0, 1000};

}  // namespace

DeviceSpec dhd_spec(int system_type) {
  const auto known = std::find_if(std::begin(kTypes), std::end(kTypes),
                                  [=](const Type& type) { return type.type == system_type; });
  const Type& t = known == std::end(kTypes) ? kUnknown : *known;
  return {.workspace_low = {-t.radius, -t.radius, -t.radius},
          .workspace_high = {t.radius, t.radius, t.radius},
          .force = t.force,
          .torque = t.torque,
          .grip_force = t.grip_force,
          .stiffness = t.stiffness,
          .damping = t.damping,
          .rate = t.rate};
}

}  // namespace turgor::haptics
