#include "turgor/window/window.hpp"

#include <algorithm>
#include <chrono>
#include <functional>
#include <thread>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <fmt/format.h>
#include <imgui.h>

#include "turgor/view/text.hpp"
#include "turgor/window/film.hpp"
#include "turgor/window/panels.hpp"
#include "turgor/window/picture.hpp"

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

/// State of the last drawing; another value requires a new picture.
struct DrawnState {
  int world = -1, frame = -1, width = 0, height = 0;
  Camera camera;
  SkinColor color = SkinColor::kNone;
  MeshStyle style = MeshStyle::kSurface;
};

bool same(const DrawnState& a, const DrawnState& b) {
  return a.world == b.world && a.frame == b.frame && a.width == b.width && a.height == b.height &&
         a.camera.eye == b.camera.eye && a.camera.target == b.camera.target && a.color == b.color &&
         a.style == b.style;
}

struct PixelSize {
  int width = 0, height = 0;
};

void copy_to_window(GLuint framebuffer, PixelSize from, bool from_top, PixelSize to) {
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, 0);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer);
  const bool same_size = from.width == to.width && from.height == to.height;
  glBlitFramebuffer(0, from_top ? from.height : 0, from.width, from_top ? 0 : from.height, 0, 0, to.width,
                    to.height, GL_COLOR_BUFFER_BIT, same_size ? GL_NEAREST : GL_LINEAR);
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
}

void set_fonts() {
  static constexpr ImWchar kLetters[] = {0x20, 0xFF, 0x370, 0x3FF, 0x2010, 0x209F, 0};
  ImGuiIO& io = ImGui::GetIO();
  const std::string file = font_file();
  if (!file.empty()) io.Fonts->AddFontFromFileTTF(file.c_str(), 15, nullptr, kLetters);
}

}  // namespace

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
  DrawnState drawn;
  Clock::time_point changed = Clock::now(), latest = Clock::now();
  Film film;

  ~Impl();
  Status begin();
  void listen();
  void handle_events();
  void draw_surfaces(int width, int height);
  void draw_picture();
  void draw_panels();
  void save_pictures();
  void save_haptics();
  void keep_rate();
  ScreenPosition screen_position(double x, double y) const;
  Image read() const;
};

SceneWindow::Impl::~Impl() {
  session.reset();  // ends its threads
  if (!film.frames.empty()) (void)end_film(options.out, options.scene.stem().string(), film);
  if (window) glfwMakeContextCurrent(window);
  picture.reset(), volume.reset(), sections.reset();
  if (has_imgui) ImGui_ImplOpenGL3_Shutdown(), ImGui_ImplGlfw_Shutdown(), ImGui::DestroyContext();
  if (window) glfwDestroyWindow(window);
  glfwTerminate();
}

Status SceneWindow::Impl::begin() {
  glfwSetErrorCallback([](int, const char* sentence) { glfw_trouble() = sentence; });
  const auto no_window = [&] {
    return Error{
        fmt::format("no window: {}; without a display, turgor run {} simulates the scene and draws pictures",
                    glfw_trouble(), options.scene.string())};
  };
  if (!glfwInit()) return no_window();
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  const std::string title = "Turgor – " + options.scene.filename().string();
  window = glfwCreateWindow(options.width, options.height, title.c_str(), nullptr, nullptr);
  if (!window) return no_window();
  glfwMakeContextCurrent(window);
  glfwSwapInterval(1);
  Result<WorldPicture> made = make_world_picture();
  if (!made) return made.error();
  picture.emplace(std::move(*made)), volume.emplace(), sections.emplace();
  listen();
  ImGui::CreateContext();
  has_imgui = true;
  ImGui::GetIO().IniFilename = nullptr;
  set_fonts();
  ImGui_ImplGlfw_InitForOpenGL(window, true);  // chains the callbacks of listen()
  ImGui_ImplOpenGL3_Init("#version 330 core");
  session.emplace(options.scene, options.overrides, options.session);
  viewer.emplace(Viewer{.session = *session});
  return Done{};
}

ScreenPosition SceneWindow::Impl::screen_position(double x, double y) const {
  int width = 1, height = 1;
  glfwGetWindowSize(window, &width, &height);
  return {2 * x / std::max(1, width) - 1, 1 - 2 * y / std::max(1, height)};
}

/// Events are queued until it is known whether a panel is under the cursor.
void SceneWindow::Impl::listen() {
  glfwSetWindowUserPointer(window, this);
  static const auto impl_of = [](GLFWwindow* w) -> Impl& {
    return *static_cast<Impl*>(glfwGetWindowUserPointer(w));
  };
  glfwSetCursorPosCallback(window, [](GLFWwindow* w, double x, double y) {
    Impl& p = impl_of(w);
    p.events.push_back([&p, x, y] { move_cursor(*p.viewer, p.screen_position(x, y)); });
  });
  glfwSetMouseButtonCallback(window, [](GLFWwindow* w, int button, int action, int mods) {
    Impl& p = impl_of(w);
    p.events.push_back([&p, button, action, mods] {
      if (action == GLFW_RELEASE) return release_button(*p.viewer);
      if (!ImGui::GetIO().WantCaptureMouse) press_button(*p.viewer, button, mods & GLFW_MOD_SHIFT);
    });
  });
  glfwSetScrollCallback(window, [](GLFWwindow* w, double, double notches) {
    Impl& p = impl_of(w);
    p.events.push_back([&p, notches] {
      if (!ImGui::GetIO().WantCaptureMouse) scroll(*p.viewer, notches);
    });
  });
  glfwSetKeyCallback(window, [](GLFWwindow* w, int key, int, int action, int mods) {
    Impl& p = impl_of(w);
    const bool again = action == GLFW_REPEAT && key == GLFW_KEY_PERIOD;  // while held, frame by frame
    if (action != GLFW_PRESS && !again) return;
    p.events.push_back([&p, key, mods] {
      if (!ImGui::GetIO().WantTextInput) press_key(*p.viewer, key, mods & GLFW_MOD_SHIFT);
    });
  });
  glfwSetDropCallback(window, [](GLFWwindow* w, int count, const char** files) {
    Impl& p = impl_of(w);
    if (count > 0) p.events.push_back([&p, file = std::string(files[0])] { open_file(*p.viewer, file); });
  });
}

void SceneWindow::Impl::handle_events() {
  std::vector<std::function<void()>> now;
  now.swap(events);
  for (const auto& event : now) event();
}

/// Draws again if anything changed, with full quality at rest.
void SceneWindow::Impl::draw_surfaces(int width, int height) {
  const SessionStatus& now = *viewer->now;
  const DrawnState current{now.world,
                           now.snapshot.frame,
                           width,
                           height,
                           viewer->camera,
                           viewer->display.color,
                           viewer->display.style};
  const bool changes = !same(current, drawn);
  if (changes) changed = Clock::now();
  constexpr double kRest = 0.25;  // delay before the full quality is used [s]
  if (!changes && !(seconds_since(changed) > kRest && can_be_refined(*picture))) return;
  const Status status = draw_world(*viewer, changes, width, height, *picture);
  if (!status) viewer->message = status.error().message;
  drawn = current;
}

void SceneWindow::Impl::draw_picture() {
  int width = 0, height = 0;
  glfwGetFramebufferSize(window, &width, &height);
  if (width < 1 || height < 1) return;
  const SessionStatus& now = *viewer->now;
  const bool is_allocated = now.phase == SessionStatus::Phase::kReady && !now.snapshot.bodies.empty();
  const bool shows_volume = is_allocated && viewer->display.volume && now.ct;
  if (is_allocated && !shows_volume) draw_surfaces(width, height);
  if (shows_volume && (viewer->draws_on_device || !now.ct->device)) {
    const Status status = renew({now.ct, viewer->display.preset, viewer->camera, width, height}, *volume);
    if (!status) viewer->message = status.error().message, viewer->draws_on_device = false;
  }
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, 0);
  glClearColor(0.03f, 0.04f, 0.05f, 1);
  glClear(GL_COLOR_BUFFER_BIT);
  const ShownImage& image = volume->image;  // rows from the top
  if (shows_volume && image.framebuffer)
    copy_to_window(image.framebuffer, {image.width, image.height}, true, {width, height});
  else if (picture->framebuffer)
    copy_to_window(picture->framebuffer, {picture->width, picture->height}, false, {width, height});
}

void SceneWindow::Impl::draw_panels() {
  show_marks(*viewer, *picture);
  show_controls(*viewer);
  show_parameters(*viewer);
  show_ct(*viewer, *sections);
  show_curves(*viewer);
  show_status(*viewer);
  show_help(*viewer);
  ImGui::Render();
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

Image SceneWindow::Impl::read() const {
  int width = 0, height = 0;
  glfwGetFramebufferSize(window, &width, &height);
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  return read_pixels(std::max(1, width), std::max(1, height));
}

void SceneWindow::Impl::save_pictures() {
  const std::string name = options.scene.stem().string();
  if (viewer->wants_picture) viewer->message = save_picture(read(), options.out, name);
  viewer->wants_picture = false;
  if (viewer->wants_felt) save_haptics();
  if (viewer->wants_video && is_due(film)) viewer->message = add_to_film(read(), options.out, film);
  if (!viewer->wants_video && !film.frames.empty()) viewer->message = end_film(options.out, name, film);
}

/// The session saves; its result is reported later.
void SceneWindow::Impl::save_haptics() {
  std::error_code ignored;
  std::filesystem::create_directories(options.out, ignored);
  session->request(SaveRequest{free_name(options.out, options.scene.stem().string() + "-haptic", ".h5")});
  viewer->wants_felt = false;
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
  glfwPollEvents();
  if (glfwWindowShouldClose(p.window) || p.viewer->ends) return false;
  int width = 1, height = 1;
  glfwGetWindowSize(p.window, &width, &height);
  p.viewer->aspect = double(std::max(1, width)) / std::max(1, height);
  ImGui_ImplOpenGL3_NewFrame();
  ImGui_ImplGlfw_NewFrame();
  ImGui::NewFrame();
  look(*p.viewer);
  p.handle_events();
  p.draw_picture();
  p.draw_panels();
  p.save_pictures();
  glfwSwapBuffers(p.window);
  p.keep_rate();
  return true;
}

Image SceneWindow::picture() const {
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
