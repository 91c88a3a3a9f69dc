// Priority of the threads of a software rasterizer, which share the processor with the physics.
#pragma once

namespace turgor {

/// Lowers the priority of the rasterizer threads of this process, so that pictures take the time that frames
/// of the physics leave. Returns the number of threads. Zero: OpenGL draws on a GPU.
int lower_drawing_priority();

}  // namespace turgor
