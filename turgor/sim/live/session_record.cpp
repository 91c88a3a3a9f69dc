#include "turgor/sim/live/session_record.hpp"

#include <fmt/format.h>

namespace turgor {

std::string save_record(const SessionRecord& record, const SessionWorld& live,
                        const std::filesystem::path& file) {
  Result<HapticRecording> run =
      live.touch ? live.touch->haptic_recording()
                 : HapticRecording{.frames = live.world->frame, .hash = state_hash(*live.world)};
  Status status = run ? Status(Done{}) : run.error();
  if (status) {
    set_scene(*record.scene, true, *run);
    run->requests = record.requests;
    status = write_haptic_recording(file, *run);
  }
  return status ? fmt::format("saved {}: turgor replay repeats it", file.string()) : status.error().message;
}

}  // namespace turgor
