// The patient frame that a mesh file declares, as 3D Slicer writes it. Internal to io/.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace turgor::io {

/// Name of the field of a VTK file that holds the frame.
constexpr std::string_view kFrameField = "SPACE";

/// Adds a note if the file declares RAS: by its field, else by a comment or a title at its beginning.
void note_frame(std::string_view bytes, std::string_view field, std::vector<std::string>& notes);

}  // namespace turgor::io
