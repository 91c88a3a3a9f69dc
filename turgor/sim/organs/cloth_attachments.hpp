// Attachments of cloth to bodies of other models. Their springs are solved in the step of the cloth
// (cloth::VertexSpring), after the bodies below it have moved. The other body bears the opposite forces from
// the next frame on, relaxed like those of contact with cloth (sim/bodies/cloth/cloth_load.hpp).
#pragma once

#include <vector>

#include "turgor/models/cloth/model/state.hpp"
#include "turgor/sim/bodies/cloth/cloth_load.hpp"
#include "turgor/sim/organs/coupling.hpp"

namespace turgor {

struct ClothBody;

/// Springs of all attachments of a cloth to other bodies in its next step, except those to cloth.
std::vector<cloth::VertexSpring> attachment_springs(const Exec& exec, const ClothBody& body,
                                                    const World& world);
/// Reads their forces after the step. The most overloaded spring of each attachment breaks.
void finish_attachment_springs(const Exec& exec, const ClothBody& body, World& world);

/// Error: springs between a cloth and a body that moves freely that are too stiff for its inertia. It bears
/// their forces a frame later, as in explicit integration.
Status check_cloth_attachment(const World& world, const std::string& where, const Attachment& attachment);

/// Forces of attachments of cloth on a body of finite elements or a rigid one, by vertex, and the mass that
/// they move.
void add_cloth_attachments(const World& world, BodyId id, ClothForces& forces);

}  // namespace turgor
