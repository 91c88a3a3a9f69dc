// What the frames of every model do alike to make a LocalContact: measure how stiff the tissue is.
#pragma once

#include "turgor/contact/local_contact.hpp"

namespace turgor::contact {

/// Fills in the stiffnesses by what the force changed since the frame before, or by `guess` while that says
/// nothing; at most `most`. [N/m]
void measure_stiffness(double guess, double most, LocalMemory& memory, LocalContact& contact);

}  // namespace turgor::contact
