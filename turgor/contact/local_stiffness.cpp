#include "turgor/contact/local_stiffness.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/core/assert.hpp"

namespace turgor::contact {

namespace {

constexpr double kMinDisplacement =
    1e-5;  // smallest displacement of the tool in a frame that allows a measurement [m]
constexpr double kMinNormalFraction =
    0.7;  // of the displacement along the normal: dragging over bumps gives no measurement
constexpr double kUpdateWeight = 0.5;  // weight of a new measurement
constexpr double kShearRatio = 0.8;    // tangential by normal [Mindlin 1949: 2 (1 − ν)/(2 − ν)]

}  // namespace

void measure_stiffness(double guess, double limit, LocalContactHistory& memory, LocalContact& contact) {
  TURGOR_CHECK(guess >= 0 && limit >= 0, "the stiffness of a contact is not negative");
  const double normal_force = dot(contact.force, contact.normal);
  // measure: change of the normal force over normal displacement
  if (memory.seen && normal_force > 0) {
    const double displacement =
        dot(memory.position - contact.origin, contact.normal) - memory.gap + contact.gap;
    const bool is_measurable =
        std::abs(displacement) >
        std::max(kMinDisplacement, kMinNormalFraction * norm(memory.position - contact.origin));
    const double measured = is_measurable ? (normal_force - memory.normal_force) / displacement : 0;
    if (measured > 0) {
      const double before = memory.stiffness > 0 ? memory.stiffness : measured;
      memory.stiffness = std::min(before + kUpdateWeight * (measured - before), limit);
    }
  }
  // store the pose and force of this frame
  if (!contact.is_near) memory.stiffness = 0;
  memory.seen = true, memory.position = contact.origin;
  memory.normal_force = std::max(0.0, normal_force), memory.gap = contact.gap;
  // result
  contact.stiffness = memory.stiffness > 0 ? memory.stiffness : std::min(guess, limit);
  contact.shear_stiffness = kShearRatio * contact.stiffness;
}

}  // namespace turgor::contact
