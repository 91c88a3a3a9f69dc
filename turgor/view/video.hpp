// Videos from pictures, by the program ffmpeg if it is installed.
#pragma once

#include <filesystem>
#include <vector>

#include "turgor/core/result.hpp"

namespace turgor {

/// True if ffmpeg is on the PATH.
bool has_ffmpeg();

/// Writes H.264 in MP4, which every browser plays, from frames in this order, all of the first one's size (an
/// odd width or height grows by one). The video appears under its name when it is complete. ffmpeg is stopped
/// when its file has not grown for `patience` [s]. Error: no ffmpeg, no frames, ffmpeg's message, or how it
/// ended.
Status write_video(const std::vector<std::filesystem::path>& frames, double frames_per_second,
                   const std::filesystem::path& path, double patience = 120);

}  // namespace turgor
