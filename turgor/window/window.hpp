// A window on a scene that is simulated: GLFW, Dear ImGui and the drawing of view/. The simulation goes on in
// threads of its own (sim/live/session.hpp) whatever happens to the window.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "turgor/core/result.hpp"
#include "turgor/io/files/image.hpp"
#include "turgor/window/viewer.hpp"

namespace turgor {

struct WindowOptions {
  std::filesystem::path scene;
  std::vector<std::string> overrides;
  std::filesystem::path out = "out/view";  // for pictures and videos
  int width = 960, height = 720;           // [pixels]
  SessionParams session;
};

class SceneWindow {
 public:
  /// Error: no display, no OpenGL 3.3. What is wrong with the scene is shown in the window.
  static Result<std::unique_ptr<SceneWindow>> open(const WindowOptions& options);
  ~SceneWindow();
  SceneWindow(const SceneWindow&) = delete;
  SceneWindow& operator=(const SceneWindow&) = delete;

  /// Takes what was typed and moved, and draws. False: the window was closed.
  bool draw();
  /// What is on the screen.
  Image picture() const;
  Viewer& viewer();

 private:
  struct Parts;
  explicit SceneWindow(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

/// Until the window is closed. Error: as SceneWindow::open.
Status view_scene(const WindowOptions& options);

}  // namespace turgor
