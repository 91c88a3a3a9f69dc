// Virtual coupling: a light proxy tool touches the model, and a spring and a damper tie it to the hand.
// Whatever the model's stiffness (bone, a wall), the device renders at most the spring's stiffness, so its
// stability bound holds for every scene. In free space the hand feels only the proxy's mass. Colgate, Stanley
// and Brown, "Issues in the haptic display of tool use" (1995); Adams and Hannaford, "Stable haptic
// interaction with virtual environments" (1999).
//
//   m x'' = F_model + f        f = K (x_hand − x) + B (x_hand' − x')        the hand feels −f
//
// Rotations are coupled in the same manner. f is taken at the end of the tick (backward Euler), F_model at
// its start. The proxy itself is therefore stable for K_model T² < 4 (m + B T + K T²): 1e5 N/m with the
// defaults at 1 kHz.
#pragma once

#include "turgor/contact/tool_io.hpp"

namespace turgor::haptics {

/// Parameters in the world frame.
struct Coupling {
  double stiffness = 1000, angular_stiffness = 1;  // [N/m] [N·m/rad]
  double damping = 6, angular_damping = 0.006;  // near critical for the masses below [N·s/m] [N·m·s/rad]
  double mass = 0.02, inertia = 2e-5;           // of the proxy tool [kg] [kg·m²]
};

/// The proxy tool that touches the model.
struct CoupledTool {
  contact::Pose pose;
  Vec3d velocity, angular_velocity;  // [m/s] [rad/s]
  Vec3d force, torque;               // of the coupling on the hand [N] [N·m]
  contact::Pose hand;                // at the last tick
  bool is_initialized = false;
};

/// Advances the proxy by `dt` [s]. The model returned `reading` at the proxy's old pose, and the hand moved
/// to `hand`. A new proxy starts at the hand's pose.
void advance_coupled_tool(const Coupling& coupling, const contact::Pose& hand,
                          const contact::ToolReading& reading, double dt, CoupledTool& tool);
/// Reading with the coupling's force and torque in place of the model's. A reading that is not finite is
/// returned unchanged, so that the safety chain detects it.
contact::ToolReading coupled_reading(const CoupledTool& tool, const contact::ToolReading& reading);

}  // namespace turgor::haptics
