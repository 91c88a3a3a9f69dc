// Reads [attachment.NAME] and [contact.NAME].
#pragma once

#include "turgor/sim/scene/scene.hpp"
#include "turgor/sim/scene/scene_table.hpp"

namespace turgor {

/// Require that all bodies were read.
AttachmentScene read_attachment(SceneTable table, const std::string& name, const Scene& scene);
BodyContactScene read_body_contact(SceneTable table, const std::string& name, const Scene& scene);

}  // namespace turgor
