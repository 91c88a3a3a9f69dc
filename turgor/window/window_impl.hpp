// Everything behind a SceneWindow. Its functions are in window.cpp (window, style, drawing), window_input.cpp
// (events) and window_output.cpp (pictures, videos, recordings).
#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include "turgor/window/appearance.hpp"
#include "turgor/window/film.hpp"
#include "turgor/window/panels.hpp"
#include "turgor/window/picture.hpp"
#include "turgor/window/window.hpp"

namespace turgor {

/// State of the last drawing; another value requires a new picture.
struct DrawnState {
  int world = -1;
  long number = -1;  // of the published state; a paused world publishes changes only
  int width = 0, height = 0;
  Camera camera;
  SkinColor color = SkinColor::kNone;
  MeshStyle style = MeshStyle::kSurface;
  std::optional<CutawayScene> cutaway, sectioned;  // of the viewer, and of the snapshot
  std::string gray_values;                         // window of the sections
  bool organ_forces = false;
};

/// Rectangle of the framebuffer, from its lower left corner [pixels].
struct PixelArea {
  int x = 0, y = 0, width = 0, height = 0;
};

struct SceneWindow::Impl {
  WindowOptions options;
  GLFWwindow* window = nullptr;
  bool has_imgui = false;
  std::optional<Session> session;
  std::optional<Viewer> viewer;
  std::optional<WorldPicture> picture;
  std::optional<VolumePicture> volume;
  std::optional<Sections> sections;
  std::vector<std::function<void()>> events;  // in order of arrival
  Settings settings;                          // as read
  Appearance appearance;                      // as set
  bool has_font = false;
  WindowScale scale;    // as set
  std::string trouble;  // error of the settings' file
  DrawnState drawn;
  std::chrono::steady_clock::time_point changed = std::chrono::steady_clock::now(), latest = changed;
  WindowFilm film;
  GalleryPictures gallery;
  std::string title;  // as shown

  ~Impl();
  Status begin();
  Status open_window();
  void keep_settings();
  void listen();
  void set_style();
  void set_title();
  std::string name_of_pictures() const;
  void set_area();
  PixelArea picture_area() const;
  void handle_events();
  void draw_surfaces(int width, int height);
  void draw_picture();
  void draw_panels();
  void save_pictures();
  void save_haptics();
  bool is_late() const;
  void wait_for_news();
  void keep_rate();
  Image read() const;
};

}  // namespace turgor
