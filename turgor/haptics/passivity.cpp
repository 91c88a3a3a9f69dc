#include "turgor/haptics/passivity.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/core/assert.hpp"
#include "turgor/haptics/rotation.hpp"

namespace turgor::haptics {

namespace {

/// Largest energy that a body under this force can return [J].
double largest_stored_energy(const PassivityParams& params, const DeviceOutput& held) {
  TURGOR_CHECK(params.reach >= 0 && params.angular_reach >= 0, "the reach of a press is not negative");
  return norm(held.force) * params.reach + norm(held.torque) * params.angular_reach;
}

/// Forgives a deficit after a time without force.
void forgive_debt(const PassivityParams& params, Passivity& state, double dt) {
  TURGOR_CHECK(dt >= 0, "time does not run backwards");
  constexpr double kZeroForce = 1e-3;  // [N] [N·m]
  const bool nothing =
      norm(state.held_output.force) < kZeroForce && norm(state.held_output.torque) < kZeroForce;
  state.force_free_time = nothing ? state.force_free_time + dt : 0;
  if (state.force_free_time > params.rest) state.energy = std::max(state.energy, 0.0);
}

}  // namespace

double largest_damping(const DeviceSpec& spec, double dt) {
  constexpr double kUsual = 10;  // of devices without a stated value
  const double said = spec.damping > 0 ? spec.damping : kUsual;
  return spec.mass > 0 && dt > 0 ? std::min(said, 0.5 * spec.mass / dt) : said;
}

void observe(const PassivityParams& params, Passivity& state, const contact::Pose& pose, double dt) {
  if (!contact::is_valid(pose)) return;
  if (state.has_pose) {
    // energy given to the hand since the last pose
    const Vec3d turn = rotation_vector(pose.axes * transposed(state.before.axes));
    const double given = dot(state.held_output.force, pose.position - state.before.position) +
                         dot(state.held_output.torque, turn);
    // update and clamp the observed energy
    TURGOR_CHECK(params.debt >= 0, "the forgiven energy is not negative");
    if (std::isfinite(given)) state.energy -= given;
    state.lowest = std::min(state.lowest, state.energy);
    state.energy = std::clamp(state.energy, -params.debt, largest_stored_energy(params, state.held_output));
    TURGOR_CHECK(std::isfinite(state.energy), "the observed energy is finite");
    forgive_debt(params, state, dt);
  }
  // start of the next interval
  state.before = pose;
  state.has_pose = true;
}

DeviceOutput add_passivity_damping(const PassivityParams& params, const Passivity& state,
                                   const DeviceOutput& wanted, const DeviceInput& hand, double dt,
                                   bool& damped) {
  TURGOR_CHECK(dt >= 0 && params.damping >= 0 && params.angular_damping >= 0, "damping dissipates energy");
  const Vec3d v = hand.velocity, w = hand.angular_velocity;
  const double most =
      dt * (params.damping * dot(v, v) +
            params.angular_damping * dot(w, w));  // energy that full damping dissipates in a tick [J]
  damped = state.energy < 0 && most > 0 && std::isfinite(most);
  if (!damped) return wanted;
  const double fraction = std::min(1.0, -state.energy / most);
  TURGOR_CHECK(fraction >= 0, "damping never adds energy");
  DeviceOutput damped_output = wanted;
  damped_output.force -= v * (fraction * params.damping);
  damped_output.torque -= w * (fraction * params.angular_damping);
  return damped_output;
}

}  // namespace turgor::haptics
