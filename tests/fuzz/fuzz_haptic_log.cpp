// Any bytes as the log of a haptic run: an error, or frames whose ticks exist and are finite, never a crash.
#include <cmath>
#include <cstdint>
#include <fstream>

#include "fuzz_input.hpp"
#include "tests/folders.hpp"
#include "turgor/sim/live/haptic_log.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  static const std::filesystem::path file = turgor::test::fresh_folder() / "out.haptic-log";
  std::ofstream(file, std::ios::binary).write(reinterpret_cast<const char*>(bytes), std::streamsize(size));
  const turgor::Result<turgor::HapticRecording> run = turgor::read_haptic_recording(file);
  if (!run) return require(run.error().message.find("/out.haptic-log") != std::string::npos), 0;
  require(run->frames > 0 && !run->has_hash);
  for (const turgor::HapticTool& tool : run->tools) {
    for (const turgor::HapticTick& tick : tool.ticks) require(std::isfinite(tick.time));
    for (const turgor::FrameInputs& frame : tool.frames)
      require(frame.ticks >= 0 && std::size_t(frame.ticks) <= tool.ticks.size());
  }
  (void)bool(scene_of(*run));
  return 0;
}
