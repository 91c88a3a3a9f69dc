// Virtual coupling: the model meets a light tool of its own, and a spring and a damper tie that tool to the
// hand. Whatever the model's stiffness (bone, a wall), the hand feels no more than the spring's, so the bound
// of the device holds for every scene. In free space nothing is felt but the tool's mass. Colgate, Stanley
// and Brown, "Issues in the haptic display of tool use" (1995); Adams and Hannaford, "Stable haptic
// interaction with virtual environments" (1999).
//
//   m x'' = F_model + f        f = K (x_hand − x) + B (x_hand' − x')        the hand feels −f
//
// and alike for rotations. f is taken at the end of the tick (backward Euler), F_model at its begin, so the
// tool itself is stable for K_model T² < 4 (m + B T + K T²): 1e5 N/m with the defaults at 1 kHz.
#pragma once

#include "turgor/contact/tool_io.hpp"

namespace turgor::haptics {

/// In the world.
struct Coupling {
  double stiffness = 1000, angular_stiffness = 1;  // [N/m] [N·m/rad]
  double damping = 6, angular_damping = 0.006;  // near critical for the masses below [N·s/m] [N·m·s/rad]
  double mass = 0.02, inertia = 2e-5;           // of the tool [kg] [kg·m²]
};

/// The tool that the model meets.
struct CoupledTool {
  contact::Pose pose;
  Vec3d velocity, angular_velocity;  // [m/s] [rad/s]
  Vec3d force, torque;               // of the coupling on the hand [N] [N·m]
  contact::Pose hand;                // at the last tick
  bool began = false;
};

/// Where the tool is, `dt` [s] after the model answered `reading` at its old place, and the hand went to
/// `hand`. A tool that is new is where the hand is.
void follow(const Coupling& coupling, const contact::Pose& hand, const contact::ToolReading& reading,
            double dt, CoupledTool& tool);
/// What the hand feels: `reading` with the coupling's force and torque instead of the model's; as it is when
/// the model's are not finite, for the safety chain to see.
contact::ToolReading haptic(const CoupledTool& tool, const contact::ToolReading& reading);

}  // namespace turgor::haptics
