// A window that shows a running simulation: GLFW, Dear ImGui and the drawing of view/. The simulation runs in
// its own threads (sim/live/session.hpp), independent of the window.
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
  int width = 0, height = 0;               // of the window; 0: as remembered [pixels]
  float scale = 0;                         // of text and panels; 0: that of the monitor
  std::filesystem::path settings;          // file of remembered settings; empty: nothing is remembered
  SessionParams session;
};

class SceneWindow {
 public:
  /// Error: no display, or no OpenGL 3.3. Errors of the scene are shown in the window.
  static Result<std::unique_ptr<SceneWindow>> open(const WindowOptions& options);
  ~SceneWindow();
  SceneWindow(const SceneWindow&) = delete;
  SceneWindow& operator=(const SceneWindow&) = delete;

  /// Processes input and draws. False: the window was closed.
  bool draw();
  /// Content of the screen.
  Image picture() const;
  Viewer& viewer();

 private:
  struct Impl;
  explicit SceneWindow(std::unique_ptr<Impl> items);
  std::unique_ptr<Impl> impl_;
};

/// Runs until the window is closed. Error: as SceneWindow::open.
Status view_scene(const WindowOptions& options);

}  // namespace turgor
