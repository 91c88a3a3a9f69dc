// Log of a haptic run that grows with it: a plain file beside the results, from which a run that was killed
// is replayed. A complete run removes it, because haptic.h5 has the same content (haptic_recording.hpp).
//
//   "turgor haptic log 2\n", then the length of the header (8 bytes) and the header as JSON: scene and tools
//   frames: "FRAM", the number of ticks since the frame before (4 bytes); for each tick and then each ticked
//   tool 16 doubles (haptic_rows.hpp) and 3 integers of 4 bytes (TickInputs); for each ticked tool 2 integers
//   (FrameInputs)
//
// A frame that was cut off by the end of the program is ignored.
#pragma once

#include <cstdio>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "turgor/core/result.hpp"
#include "turgor/sim/live/haptic_recording.hpp"

namespace turgor {

/// A ticked tool that is logged.
struct LoggedTool {
  const DiskLog<HapticTick>* ticks = nullptr;
  FrameInputs frame;  // inputs of the latest frame
};

/// Writer of ".NAME.haptic-PID-N" beside the results.
class HapticLogWriter {
 public:
  /// `run` has the scene and the names of all tools; `ticked` has the indices of those with ticks.
  HapticLogWriter(const std::filesystem::path& goal, const HapticRecording& run,
                  const std::vector<int>& ticked);

  const std::filesystem::path& path() const { return path_; }
  /// After a frame: adds the ticks since the frame before, and what the frame used. Ticks of all tools have
  /// the same number. The first frame makes the file; after an error nothing more is written.
  void add_frame(std::span<const LoggedTool> tools);
  void remove();

 private:
  struct Closer {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  void write(const std::string& bytes);

  std::filesystem::path path_;
  std::string begin_;  // title and header
  std::unique_ptr<std::FILE, Closer> file_;
  std::size_t ticks_ = 0;  // written so far
  bool failed_ = false;
};

/// True if the file begins like a log.
bool is_haptic_log(const std::filesystem::path& path);
/// Recording of the complete frames. It has no state hash. Error: damaged, or without a frame.
Result<HapticRecording> read_haptic_log(const std::filesystem::path& path);

/// Gives the logs of killed runs beside the results the names "NAME.haptic-log", "NAME.haptic-log-2", …, and
/// returns a sentence for each.
std::vector<std::string> keep_haptic_logs(const std::filesystem::path& goal);

}  // namespace turgor
