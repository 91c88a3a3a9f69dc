#include "turgor/contact/local_stiffness.hpp"

#include <algorithm>
#include <cmath>

namespace turgor::contact {

namespace {

constexpr double kLeastWay = 1e-5;  // of the tool in a frame by which a stiffness is measured [m]
constexpr double kInwards = 0.7;    // and so much of it must go in or out: dragged over bumps it says nothing
constexpr double kTrust = 0.5;      // of a new measurement
constexpr double kShear = 0.8;      // across the normal by along it [Mindlin 1949: 2 (1 − ν)/(2 − ν)]

}  // namespace

void measure_stiffness(double guess, double most, LocalMemory& memory, LocalContact& contact) {
  const double pressing = dot(contact.force, contact.normal);
  if (memory.seen && pressing > 0) {
    const double way = dot(memory.position - contact.origin, contact.normal) - memory.gap + contact.gap;
    const bool tells = std::abs(way) > std::max(kLeastWay, kInwards * norm(memory.position - contact.origin));
    const double measured = tells ? (pressing - memory.pressing) / way : 0;
    if (measured > 0) {
      const double before = memory.stiffness > 0 ? memory.stiffness : measured;
      memory.stiffness = std::min(before + kTrust * (measured - before), most);
    }
  }
  if (!contact.is_near) memory.stiffness = 0;
  memory.seen = true, memory.position = contact.origin;
  memory.pressing = std::max(0.0, pressing), memory.gap = contact.gap;
  contact.stiffness = memory.stiffness > 0 ? memory.stiffness : std::min(guess, most);
  contact.shear_stiffness = kShear * contact.stiffness;
}

}  // namespace turgor::contact
