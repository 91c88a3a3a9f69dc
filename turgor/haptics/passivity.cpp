#include "turgor/haptics/passivity.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/haptics/rotation.hpp"

namespace turgor::haptics {

namespace {

/// That a hand can be given back at most by what it presses [J].
double stored_at_most(const PassivityParams& params, const DeviceOutput& haptic) {
  return norm(haptic.force) * params.reach + norm(haptic.torque) * params.angular_reach;
}

/// Time without a force, in which nothing is owed any more.
void rest(const PassivityParams& params, Passivity& state, double dt) {
  constexpr double kNothing = 1e-3;  // [N] [N·m]
  const bool nothing = norm(state.haptic.force) < kNothing && norm(state.haptic.torque) < kNothing;
  state.rested = nothing ? state.rested + dt : 0;
  if (state.rested > params.rest) state.energy = std::max(state.energy, 0.0);
}

}  // namespace

double largest_damping(const DeviceSpec& spec, double dt) {
  constexpr double kUsual = 10;  // of devices whose makers say nothing
  const double said = spec.damping > 0 ? spec.damping : kUsual;
  return spec.mass > 0 && dt > 0 ? std::min(said, 0.5 * spec.mass / dt) : said;
}

void observe(const PassivityParams& params, Passivity& state, const contact::Pose& pose, double dt) {
  if (!contact::is_valid(pose)) return;
  if (state.began) {
    const Vec3d turn = rotation_vector(pose.axes * transposed(state.before.axes));
    const double given =
        dot(state.haptic.force, pose.position - state.before.position) + dot(state.haptic.torque, turn);
    if (std::isfinite(given)) state.energy -= given;
    state.lowest = std::min(state.lowest, state.energy);
    state.energy = std::clamp(state.energy, -params.debt, stored_at_most(params, state.haptic));
    rest(params, state, dt);
  }
  state.before = pose;
  state.began = true;
}

DeviceOutput pay_back(const PassivityParams& params, const Passivity& state, const DeviceOutput& wanted,
                      const DeviceInput& hand, double dt, bool& damped) {
  const Vec3d v = hand.velocity, w = hand.angular_velocity;
  const double most = dt * (params.damping * dot(v, v) + params.angular_damping * dot(w, w));  // [J]
  damped = state.energy < 0 && most > 0 && std::isfinite(most);
  if (!damped) return wanted;
  const double part = std::min(1.0, -state.energy / most);
  DeviceOutput paid = wanted;
  paid.force -= v * (part * params.damping);
  paid.torque -= w * (part * params.angular_damping);
  return paid;
}

}  // namespace turgor::haptics
