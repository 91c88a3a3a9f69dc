// Recording of a haptic run: the scene, the commands of every tool tick by tick, the data that ticks and
// frames took from each other, and the requests between frames. Nothing else affects the world. HapticReplay
// can therefore reproduce it bit by bit without devices and without a clock.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "turgor/contact/tool_io.hpp"
#include "turgor/core/disk_log.hpp"
#include "turgor/sim/live/requests.hpp"
#include "turgor/sim/live/tick_inputs.hpp"

namespace turgor {

struct HapticTick {
  double time = 0, step = 0;  // simulated time, and its increment in this tick [s]
  contact::ToolCommand command;
  TickInputs inputs_used;
};

/// Recording of one tool of World::tools.
struct HapticTool {
  std::string name;
  DiskLog<HapticTick> ticks;  // those of a long session are on disk
  std::vector<FrameInputs> frames;
};

/// Request applied after `frame` frames.
struct RecordedRequest {
  int frame = 0;
  WorldRequest what;
};

struct HapticRecording {
  std::filesystem::path file, folder;  // file of the scene; working directory when it was read
  std::string text;                    // text of the scene's file
  std::vector<std::string> overrides;
  bool has_mouse_tools = false;  // true if mouse_tools.hpp added tools to the scene
  bool has_whole_cells = false;  // where the scene does not choose: its file does not store the default
  int frames = 0;
  std::vector<HapticTool> tools;
  std::vector<RecordedRequest> requests;
  std::uint64_t hash = 0;  // state_hash of the world after the last frame
  bool has_hash = true;    // false: the run was killed (haptic_log.hpp)
};

/// Stores a scene as it was before any request.
void set_scene(const Scene& scene, bool has_mouse_tools, HapticRecording& run);
/// Recorded scene with its tools; its duration is that of the run. Error: the text is no valid scene.
Result<Scene> scene_of(const HapticRecording& run);

/// Writes an HDF5 file.
Status write_haptic_recording(const std::filesystem::path& path, const HapticRecording& run);
/// Reads such a file, or the log of a killed run. Error: missing or damaged file, or another format.
Result<HapticRecording> read_haptic_recording(const std::filesystem::path& path);

}  // namespace turgor
