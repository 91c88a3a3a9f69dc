// Pictures, videos and haptic recordings of a window.
#include <algorithm>
#include <system_error>

#include "turgor/window/window_impl.hpp"

namespace turgor {

std::string SceneWindow::Impl::name_of_pictures() const {
  const bool has_scene = viewer->now && viewer->now->scene;
  const std::string name = (has_scene ? viewer->now->scene->file : options.scene).stem().string();
  return name.empty() ? "turgor" : name;
}

Image SceneWindow::Impl::read() const {
  int width = 0, height = 0;
  glfwGetFramebufferSize(window, &width, &height);
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  Image image = read_pixels(std::max(1, width), std::max(1, height));
  if (!viewer->records_picture_only) return image;
  const PixelArea area = picture_area();
  const int top = height - area.y - area.height;
  Image picture_only = make_image(area.width, area.height);
  for (int y = 0; y < area.height; y++)
    for (int x = 0; x < area.width; x++) picture_only.at(x, y) = image.at(area.x + x, top + y);
  return picture_only;
}

void SceneWindow::Impl::save_pictures() {
  const std::string name = name_of_pictures();
  if (viewer->wants_picture) viewer->message = save_picture(read(), options.out, name);
  viewer->wants_picture = false;
  if (viewer->wants_felt) save_haptics();
  if (!viewer->clipboard.empty()) glfwSetClipboardString(window, viewer->clipboard.c_str());
  viewer->clipboard.clear();
  if (viewer->wants_video && is_due(film)) viewer->message = add_to_film(read(), options.out, film);
  if (!viewer->wants_video && !film.frames.empty()) viewer->message = end_film(options.out, name, film);
}

/// The session saves; its result is reported later.
void SceneWindow::Impl::save_haptics() {
  std::error_code ignored;
  std::filesystem::create_directories(options.out, ignored);
  session->request(SaveRequest{free_name(options.out, name_of_pictures() + "-haptic", ".h5")});
  viewer->wants_felt = false;
}

}  // namespace turgor
