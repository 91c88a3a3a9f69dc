#include "turgor/window/window.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>

#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <fmt/format.h>
#include <imgui.h>

#include "turgor/window/drawing_threads.hpp"
#include "turgor/window/window_impl.hpp"

namespace turgor {

namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

std::string& glfw_trouble() {
  static std::string sentence;
  return sentence;
}

bool same(const DrawnState& a, const DrawnState& b) {
  return a.world == b.world && a.number == b.number && a.width == b.width && a.height == b.height &&
         a.camera.eye == b.camera.eye && a.camera.target == b.camera.target && a.color == b.color &&
         a.style == b.style && a.cutaway == b.cutaway && a.sectioned == b.sectioned &&
         a.gray_values == b.gray_values && a.organ_forces == b.organ_forces;
}

struct PixelSize {
  int width = 0, height = 0;
};

void copy_to_window(GLuint framebuffer, PixelSize from, bool from_top, PixelArea to) {
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, 0);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer);
  const bool same_size = from.width == to.width && from.height == to.height;
  glBlitFramebuffer(0, from_top ? from.height : 0, from.width, from_top ? 0 : from.height, to.x, to.y,
                    to.x + to.width, to.y + to.height, GL_COLOR_BUFFER_BIT,
                    same_size ? GL_NEAREST : GL_LINEAR);
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
}

/// Monitor scale and framebuffer scale of a window. `wanted` replaces the monitor's; 0: as it is.
WindowScale scale_of(GLFWwindow* window, float wanted) {
  WindowScale scale;
  float ignored = 1;
  glfwGetWindowContentScale(window, &scale.monitor, &ignored);
  int width = 0, height = 0, pixels = 0;
  glfwGetWindowSize(window, &width, &height);
  glfwGetFramebufferSize(window, &pixels, &height);
  if (width > 0 && pixels > 0) scale.framebuffer = float(pixels) / float(width);
  if (wanted > 0) scale.monitor = wanted;
  return scale;
}

}  // namespace

SceneWindow::Impl::~Impl() {
  if (viewer) keep_settings();
  const std::string name = viewer ? name_of_pictures() : "";
  session.reset();  // ends its threads
  if (!film.frames.empty()) (void)end_film(options.out, name, film);
  if (window) glfwMakeContextCurrent(window);
  picture.reset(), volume.reset(), sections.reset(), gallery = {};
  if (has_imgui) ImGui_ImplOpenGL3_Shutdown(), ImGui_ImplGlfw_Shutdown(), ImGui::DestroyContext();
  if (window) glfwDestroyWindow(window);
  glfwTerminate();
}

/// Opens the window with its OpenGL context, at its remembered size.
Status SceneWindow::Impl::open_window() {
  glfwSetErrorCallback([](int, const char* sentence) { glfw_trouble() = sentence; });
  Result<Settings> read = options.settings.empty() ? Settings() : read_settings(options.settings);
  if (read)
    settings = *read;
  else
    trouble = read.error().message;
  std::error_code ignored;
  const bool is_remembered = options.width > 0 || std::filesystem::exists(options.settings, ignored);
  if (options.width > 0 && options.height > 0)
    settings.width = options.width, settings.height = options.height;
  const auto no_window = [&] {
    return Error{
        fmt::format("no window: {}; without a display, turgor run {} simulates the scene and draws pictures",
                    glfw_trouble(), options.scene.empty() ? "SCENE" : options.scene.string())};
  };
  if (!glfwInit()) return no_window();
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  glfwWindowHint(GLFW_SCALE_TO_MONITOR, is_remembered ? GLFW_FALSE : GLFW_TRUE);
  window = glfwCreateWindow(settings.width, settings.height, "Turgor", nullptr, nullptr);
  if (!window) return no_window();
  glfwMakeContextCurrent(window);
  glfwSwapInterval(1);
  return Done{};
}

Status SceneWindow::Impl::begin() {
  if (const Status opened = open_window(); !opened) return opened;
  Result<WorldPicture> made = make_world_picture();
  if (!made) return made.error();
  picture.emplace(std::move(*made)), volume.emplace(), sections.emplace();
  lower_drawing_priority();
  listen();
  ImGui::CreateContext();
  has_imgui = true;
  ImGui::GetIO().IniFilename = nullptr;
  ImGui_ImplGlfw_InitForOpenGL(window, true);  // chains the callbacks of listen()
  ImGui_ImplOpenGL3_Init("#version 330 core");
  session.emplace(options.scene, options.overrides, options.session);
  viewer.emplace(Viewer{.session = *session});
  viewer->settings = settings, viewer->panels = settings.panels, viewer->message = viewer->failure = trouble;
  if (options.scene.empty())
    viewer->shows_gallery = true;
  else
    add_recent(options.scene, viewer->settings);
  return Done{};
}

void SceneWindow::Impl::keep_settings() {
  if (options.settings.empty()) return;
  Settings& kept = viewer->settings;
  kept.panels = viewer->panels;
  if (!glfwGetWindowAttrib(window, GLFW_MAXIMIZED)) glfwGetWindowSize(window, &kept.width, &kept.height);
  (void)write_settings(options.settings, kept);  // the window closes and cannot show a message
}

/// Sets the theme, and makes the font again if the size of text or the monitor changed.
void SceneWindow::Impl::set_style() {
  const WindowScale now = scale_of(window, options.scale);
  if (has_font && now == scale && viewer->settings.appearance == appearance) return;
  const bool has_new_font =
      !(now == scale) || viewer->settings.appearance.text_size != appearance.text_size || !has_font;
  scale = now, appearance = viewer->settings.appearance;
  set_appearance(appearance, scale);
  if (!has_new_font) return;
  has_font = true;
  set_font(appearance.text_size, scale);
  ImGui_ImplOpenGL3_DestroyDeviceObjects();  // the next frame makes them again, with the new font
}

/// Sets the rectangle of the picture beside the side panel, above the status line.
void SceneWindow::Impl::set_area() {
  int width = 1, height = 1;
  glfwGetWindowSize(window, &width, &height);
  const double side = viewer->panels.controls ? double(viewer->panels.side_width * scale.units()) : 0;
  Area& area = viewer->area;
  area = {.x = std::min(side, width - 1.0), .y = std::min(viewer->menu_height, height - 1.0)};
  area.width = std::max(1.0, width - area.x);
  area.height = std::max(1.0, height - area.y - viewer->status_height);
  viewer->aspect = area.aspect();
}

PixelArea SceneWindow::Impl::picture_area() const {
  int width = 0, height = 0;
  glfwGetFramebufferSize(window, &width, &height);
  const Area& area = viewer->area;
  const double f = double(scale.framebuffer);
  const auto pixels = [f](double units) { return int(std::lround(units * f)); };
  PixelArea to{.x = pixels(area.x), .y = height - pixels(area.y + area.height)};
  to.width = std::max(0, std::min(width - to.x, pixels(area.width)));
  to.height = std::max(0, std::min(height - to.y, pixels(area.height)));
  return to;
}

/// Draws again if anything changed, with full quality at rest. A world that plays is not at rest: a picture
/// of full quality after a late frame would delay the next ones.
void SceneWindow::Impl::draw_surfaces(int width, int height) {
  const SessionStatus& now = *viewer->now;
  const DrawnState current{now.world,
                           now.number,
                           width,
                           height,
                           viewer->camera,
                           viewer->display.color,
                           viewer->display.style,
                           viewer->display.cutaway,
                           now.snapshot.cutaway,
                           viewer->display.window,
                           viewer->display.organ_forces};
  const bool changes = !same(current, drawn);
  if (changes) changed = Clock::now();
  constexpr double kRest = 0.25;  // delay before the full quality is used [s]
  const bool is_at_rest = !now.plays && !changes && seconds_since(changed) > kRest;
  if (!changes && !(is_at_rest && can_be_refined(*picture))) return;
  const Status status = draw_world(*viewer, changes, width, height, *picture);
  if (!status) viewer->message = viewer->failure = status.error().message;
  drawn = current;
}

void SceneWindow::Impl::draw_picture() {
  const PixelArea area = picture_area();
  const int width = area.width, height = area.height;
  if (width < 1 || height < 1) return;
  const SessionStatus& now = *viewer->now;
  const bool is_allocated = now.phase == SessionStatus::Phase::kReady && !now.snapshot.bodies.empty();
  const bool shows_volume = is_allocated && viewer->display.volume && now.ct;
  if (is_allocated && !shows_volume) draw_surfaces(width, height);
  if (shows_volume && (viewer->draws_on_device || !now.ct->device)) {
    const Status status = renew({now.ct, viewer->display.preset, viewer->camera, width, height}, *volume);
    if (!status) viewer->message = viewer->failure = status.error().message, viewer->draws_on_device = false;
  }
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, 0);
  glClearColor(0.03f, 0.04f, 0.05f, 1);
  glClear(GL_COLOR_BUFFER_BIT);
  const ShownImage& image = volume->image;  // rows from the top
  if (shows_volume && image.framebuffer)
    copy_to_window(image.framebuffer, {image.width, image.height}, true, area);
  else if (picture->framebuffer)
    copy_to_window(picture->framebuffer, {picture->width, picture->height}, false, area);
}

/// File name of the scene, with a star if it has unsaved edits, and what the window waits for.
void SceneWindow::Impl::set_title() {
  const SessionStatus& now = *viewer->now;
  const Document& document = viewer->document;
  std::string name = "Turgor";
  if (now.scene)
    name = (document.file.empty() ? now.scene->file : document.file).filename().string() +
           (has_unsaved_edits(*viewer) ? "* – Turgor" : " – Turgor");
  if (now.phase == SessionStatus::Phase::kLoading) name += " (loading)";
  if (now.phase == SessionStatus::Phase::kReady && now.cut_result.cut >= 0 && !now.cut_result.is_measured)
    name += " (cutting)";
  if (name == title) return;
  title = name;
  glfwSetWindowTitle(window, title.c_str());
}

void SceneWindow::Impl::draw_panels() {
  show_menu(*viewer);
  show_marks(*viewer, *picture);
  show_side_panel(*viewer, *sections, scale.units());
  show_status(*viewer);
  show_cube(*viewer);
  show_start(*viewer);
  show_gallery(*viewer, gallery);
  show_help(*viewer);
  show_file_dialog(*viewer);
  show_question(*viewer);
  ImGui::Render();
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

/// True while frames come later than the clock asks for.
bool SceneWindow::Impl::is_late() const {
  if (!viewer->now) return false;
  const SessionStatus& now = *viewer->now;
  return now.phase == SessionStatus::Phase::kReady && now.plays && now.real_pace < 0.9 * now.pace;
}

/// While frames are late, waits for an event or a new state, so that no time goes into pictures of the same
/// state.
void SceneWindow::Impl::wait_for_news() {
  constexpr double kLongest = 1.0 / 15;  // [s]
  while (is_late() && seconds_since(latest) < kLongest && !session->has_news() && events.empty())
    glfwWaitEventsTimeout(0.002);
}

/// Limits the rate to that of a screen, if swapping buffers does not wait.
void SceneWindow::Impl::keep_rate() {
  constexpr double kShortest = 1.0 / 60;  // [s]
  const double passed = seconds_since(latest);
  if (passed < kShortest) std::this_thread::sleep_for(std::chrono::duration<double>(kShortest - passed));
  const double rate = 1 / std::max(1e-6, seconds_since(latest));
  viewer->drawn_per_second += (viewer->drawn_per_second > 0 ? 0.1 : 1) * (rate - viewer->drawn_per_second);
  latest = Clock::now();
}

SceneWindow::SceneWindow(std::unique_ptr<Impl> items) : impl_(std::move(items)) {}
SceneWindow::~SceneWindow() = default;

Result<std::unique_ptr<SceneWindow>> SceneWindow::open(const WindowOptions& options) {
  auto items = std::make_unique<Impl>();
  items->options = options;
  if (const Status status = items->begin(); !status) return status.error();
  return std::unique_ptr<SceneWindow>(new SceneWindow(std::move(items)));
}

bool SceneWindow::draw() {
  Impl& p = *impl_;
  p.wait_for_news();
  glfwPollEvents();
  if (glfwWindowShouldClose(p.window)) glfwSetWindowShouldClose(p.window, GLFW_FALSE), quit(*p.viewer);
  if (p.viewer->ends) return false;
  p.set_style();
  p.set_area();
  ImGui_ImplOpenGL3_NewFrame();
  ImGui_ImplGlfw_NewFrame();
  ImGui::NewFrame();
  look(*p.viewer);
  p.handle_events();
  p.draw_picture();
  p.draw_panels();
  p.set_title();
  p.save_pictures();
  glfwSwapBuffers(p.window);
  p.keep_rate();
  return true;
}

Image SceneWindow::picture() const {
  glBindFramebuffer(GL_FRAMEBUFFER, 0);  // whose buffer is chosen next
  glReadBuffer(GL_FRONT);
  Image image = impl_->read();
  glReadBuffer(GL_BACK);
  return image;
}

Viewer& SceneWindow::viewer() { return *impl_->viewer; }

Status view_scene(const WindowOptions& options) {
  Result<std::unique_ptr<SceneWindow>> window = SceneWindow::open(options);
  if (!window) return window.error();
  while ((*window)->draw()) {
  }
  return Done{};
}

}  // namespace turgor
