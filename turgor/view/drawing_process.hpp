// Drawing of meshes in a child process. A driver of OpenGL that crashes, hangs or exhausts memory then ends
// the child, and the run goes on without pictures. The child is started by exec, has limits, and is kept for
// the next pictures.
#pragma once

#include <future>
#include <string>
#include <vector>

#include "turgor/view/mesh_view.hpp"

namespace turgor {

/// Program that calls serve_drawings.
struct DrawingProgram {
  std::vector<std::string> arguments;  // its path first
  double patience = 60;                // time of a picture after which the child is stopped [s]
  std::string refusal;                 // reason why there is no program; nothing is drawn then
};

/// From now on draw_meshes uses a child. An empty program ends this, and the child.
void set_drawing_program(DrawingProgram program);
bool has_drawing_program();

/// draw_in_process by the child. Error: as there, or how the child ended; the next call starts another one.
/// A child ends with the thread that started it. Other threads and forks of this process then start their
/// own.
Result<Image> draw_in_child(const std::vector<RenderItem>& items, const Camera& camera, int width, int height,
                            RenderQuality quality);

/// Starts the child and has it draw a small picture, which compiles its shaders. Later pictures wait for it;
/// without a program nothing happens.
std::future<void> warm_up_drawing();

/// The child's work: draws what arrives on standard input, a socket, until that closes. Returns its exit
/// code.
int serve_drawings();

}  // namespace turgor
