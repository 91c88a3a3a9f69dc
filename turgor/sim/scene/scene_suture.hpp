// Reads [suture.NAME]: a row of stitches or a single one, its thread, and its pull.
#pragma once

#include "turgor/sim/scene/scene.hpp"
#include "turgor/sim/scene/scene_table.hpp"

namespace turgor {

SutureScene read_suture(SceneTable table, const std::string& name, const Scene& scene);

/// Names of the threads, from thin to thick.
std::vector<std::string> thread_names();
/// Sets the thread of that name. Returns false if the name is unknown.
bool set_thread(const std::string& name, SutureScene& suture);

}  // namespace turgor
