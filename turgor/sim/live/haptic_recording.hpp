// A felt run as a value: the scene, what hands and paths told every tool tick by tick, what ticks and frames
// knew of each other, and what was asked for between frames. Nothing else decided what became of the world,
// so that FeltReplay makes the same of it without devices and without a clock, to the same bits.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "turgor/contact/tool_io.hpp"
#include "turgor/sim/live/requests.hpp"
#include "turgor/sim/live/tick_inputs.hpp"

namespace turgor {

struct HapticTick {
  double time = 0, step = 0;  // [s]
  contact::ToolCommand command;
  TickInputs inputs_used;
};

/// A tool, as in World::tools.
struct HapticTool {
  std::string name;
  std::vector<HapticTick> ticks;
  std::vector<FrameInputs> frames;
};

/// What was asked for when so many frames were finished.
struct RecordedRequest {
  int frame = 0;
  WorldRequest what;
};

struct HapticRecording {
  std::filesystem::path file, folder;  // of the scene, and the current one when it was read
  std::string text;                    // of the scene
  std::vector<std::string> overrides;
  bool has_mouse_tools = false;  // see mouse_tools.hpp
  int frames = 0;
  std::vector<HapticTool> tools;
  std::vector<RecordedRequest> requests;
  std::uint64_t hash = 0;  // state_hash of the world in the end
};

/// Of this scene, as it was before anything was asked for.
void note_scene(const Scene& scene, bool has_mouse_tools, HapticRecording& run);
/// The scene with its tools, as long as the run was. Error: it is none any more.
Result<Scene> scene_of(const HapticRecording& run);

/// An HDF5 file.
Status write_haptic_recording(const std::filesystem::path& path, const HapticRecording& run);
/// Error: no such file, damaged, or of another version.
Result<HapticRecording> read_haptic_recording(const std::filesystem::path& path);

}  // namespace turgor
