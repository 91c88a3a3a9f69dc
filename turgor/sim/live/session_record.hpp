// Scene and requests of a session. Together with the record of its haptic loop they form a haptic recording.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "turgor/sim/live/haptic_recording.hpp"
#include "turgor/sim/live/session_world.hpp"

namespace turgor {

struct SessionRecord {
  std::shared_ptr<const Scene> scene;     // scene from which the world was loaded
  std::vector<RecordedRequest> requests;  // requests applied since the world was loaded
};

/// Writes a haptic recording. Waits until the ticks are paused. Returns a message: success, or the reason of
/// the failure.
std::string save_record(const SessionRecord& record, const SessionWorld& live,
                        const std::filesystem::path& file);

}  // namespace turgor
