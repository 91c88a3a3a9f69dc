#include "turgor/window/ct_pictures.hpp"

#include <chrono>
#include <system_error>

namespace turgor {

namespace {

/// True for a deferred picture too, which get() draws.
bool is_ready(const std::future<Result<Image>>& image) {
  return image.valid() && image.wait_for(std::chrono::seconds(0)) != std::future_status::timeout;
}

/// Draws in a thread, or if the system refuses one in the caller of get().
template <class Draw>
std::future<Result<Image>> begin_drawing(const Draw& draw) {
  try {
    return std::async(std::launch::async, draw);
  } catch (const std::system_error&) {
    return std::async(std::launch::deferred, draw);
  }
}

void begin(const VolumeRequest& request, int coarseness, VolumePicture& picture) {
  picture.request = request, picture.coarseness = coarseness;
  picture.coming = begin_drawing([request, coarseness, exec = picture.exec, &pictures = picture.pictures] {
    return draw_deformed(exec, *request.ct, pictures, request.preset, request.camera,
                         std::max(1, request.width / coarseness), std::max(1, request.height / coarseness));
  });
}

}  // namespace

void ShownImage::show(const Image& image) {
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  if (!texture) texture = objects.new_texture(), framebuffer = objects.new_framebuffer();
  glBindTexture(GL_TEXTURE_2D, texture);
  for (const GLenum filter : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
    glTexParameteri(GL_TEXTURE_2D, filter, GL_LINEAR);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGB8, image.width, image.height, 0, GL_RGB, GL_UNSIGNED_BYTE,
               image.pixels.data());
  attach_textures(framebuffer, GL_TEXTURE_2D, {texture}, 0);
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  width = image.width, height = image.height;
}

Status renew(const VolumeRequest& request, VolumePicture& picture) {
  const int first = request.ct->device ? 1 : 4;
  Status status = Done{};
  if (is_ready(picture.coming)) {
    const Result<Image> image = picture.coming.get();
    picture.made = picture.request, picture.shown_coarseness = picture.coarseness;
    if (image)
      picture.image.show(*image);
    else
      status = image.error();
  }
  if (picture.coming.valid()) return status;
  if (!(request == picture.made))
    begin(request, first, picture);
  else if (picture.shown_coarseness > 1)
    begin(request, picture.shown_coarseness / 2, picture);
  return status;
}

void renew(const std::shared_ptr<const DeformedCt>& ct, Vec3d point, const std::string& window,
           Sections& sections) {
  if (ct == sections.ct && point == sections.point && window == sections.window) return;
  sections.ct = ct, sections.point = point, sections.window = window;
  const Result<Window> gray = window_preset(window);
  constexpr int kHeight = 200;
  int n = 0;
  for (const Plane plane : {Plane::kAxial, Plane::kCoronal, Plane::kSagittal})
    sections.images[n++].show(draw_section(ct->ct, plane, point, gray ? *gray : Window(), kHeight));
}

}  // namespace turgor
