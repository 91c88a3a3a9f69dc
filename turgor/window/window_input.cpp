// Mouse, keyboard and dropped files of a window.
#include <utility>

#include <imgui.h>

#include "turgor/window/window_impl.hpp"

namespace turgor {

/// Events are queued until it is known whether a panel is under the cursor.
void SceneWindow::Impl::listen() {
  glfwSetWindowUserPointer(window, this);
  static const auto impl_of = [](GLFWwindow* w) -> Impl& {
    return *static_cast<Impl*>(glfwGetWindowUserPointer(w));
  };
  glfwSetCursorPosCallback(window, [](GLFWwindow* w, double x, double y) {
    Impl& p = impl_of(w);
    p.events.push_back([&p, x, y] { move_cursor(*p.viewer, screen_position(p.viewer->area, x, y)); });
  });
  glfwSetMouseButtonCallback(window, [](GLFWwindow* w, int button, int action, int mods) {
    Impl& p = impl_of(w);
    p.events.push_back([&p, button, action, mods] {
      if (action == GLFW_RELEASE) return release_button(*p.viewer, button);
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
    const bool repeats = key == GLFW_KEY_PERIOD || key == GLFW_KEY_PAGE_UP || key == GLFW_KEY_PAGE_DOWN;
    const bool again = action == GLFW_REPEAT && repeats;  // while held: frame by frame, or the needle
    if (action != GLFW_PRESS && !again) return;
    const Chord chord = !(mods & GLFW_MOD_CONTROL) ? Chord::kPlain
                        : (mods & GLFW_MOD_SHIFT)  ? Chord::kControlShift
                                                   : Chord::kControl;
    p.events.push_back([&p, key, chord] {
      const Document& document = p.viewer->document;
      const bool is_asked = document.dialog.is_open || document.leaving != Leaving::kNothing;
      if (key == GLFW_KEY_ESCAPE || !(ImGui::GetIO().WantTextInput || is_asked))
        press_key(*p.viewer, key, chord);
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

}  // namespace turgor
