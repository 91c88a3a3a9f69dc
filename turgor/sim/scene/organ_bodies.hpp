// [organs]: several organs from one segmentation by one table. It is rewritten into [body.NAME],
// [attachment.NAME] and [contact.NAME] before these are read.
#pragma once

#include "turgor/sim/scene/scene_table.hpp"

namespace turgor {

/// Adds a body for every label, and an attachment and a contact for every pair of them if the table asks for
/// them. Keys of a body that the scene has itself count; other keys of the table are those of all its bodies.
void add_organ_bodies(toml::table& root, SceneProblems& problems);

/// Reads the table's own keys, for errors and the list of keys.
void read_organs_table(SceneTable organs);

}  // namespace turgor
