// Pictures to a video, by the program ffmpeg when this machine has it.
#pragma once

#include <filesystem>
#include <vector>

#include "turgor/core/result.hpp"

namespace turgor {

/// Whether ffmpeg is found on the PATH.
bool has_ffmpeg();

/// H.264 in MP4, which every browser plays; the frames in this order, all of the first one's size (an odd
/// width or height grows by one). The video appears under its name when it is complete. ffmpeg is stopped
/// when its file has not grown for `patience` [s]. Error: no ffmpeg, no frames, what ffmpeg said, or how it
/// ended.
Status write_video(const std::vector<std::filesystem::path>& frames, double frames_per_second,
                   const std::filesystem::path& path, double patience = 120);

}  // namespace turgor
