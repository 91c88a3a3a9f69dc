// Tissue stiffness measured from frame to frame, for the local contacts of all models.
#pragma once

#include "turgor/contact/local_contact.hpp"

namespace turgor::contact {

/// Sets both stiffnesses of a contact from the change of its force since the previous frame. Uses `guess`
/// until the first measurement. The result does not exceed `limit`. [N/m]
void measure_stiffness(double guess, double limit, LocalContactHistory& memory, LocalContact& contact);

}  // namespace turgor::contact
