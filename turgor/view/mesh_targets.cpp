#include "turgor/view/mesh_targets.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "turgor/view/color.hpp"

namespace turgor {

namespace {

constexpr int kSamples = 8;  // per pixel, if the driver supports it

// Lookups return the fraction of the texel's neighborhood that is nearer to the light.
GLuint new_shadow_texture(GlObjects& objects) {
  const GLuint texture = new_texture(objects, GL_DEPTH_COMPONENT24, GL_DEPTH_COMPONENT, GL_UNSIGNED_INT,
                                     kShadowSize, kShadowSize);
  for (const GLenum filter : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
    glTexParameteri(GL_TEXTURE_2D, filter, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
  return texture;
}

Status check_size(int width, int height) {
  GLint most = 0;
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &most);
  if (width >= 1 && height >= 1 && width <= most && height <= most) return Done{};
  return Error{
      fmt::format("cannot draw a picture of {} x {} pixels: OpenGL supports 1 to {}", width, height, most)};
}

Error incomplete() { return {"cannot draw: glCheckFramebufferStatus found an incomplete framebuffer"}; }

// Fills the bound texture.
void fill_with_backdrop(int width, int height) {
  Image image = make_image(width, height);
  for (int y = 0; y < height; y++)
    for (int x = 0; x < width; x++)
      image.at(x, height - 1 - y) =  // OpenGL counts rows from the bottom
          screen_color(backdrop((float(x) + 0.5f) / float(width), (float(y) + 0.5f) / float(height)));
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, width, height, GL_RGB, GL_UNSIGNED_BYTE, image.pixels.data());
}

}  // namespace

Result<GBuffer> make_g_buffer(GlObjects& objects, const MeshTargets& targets) {
  const auto texture = [&](GLenum format) {
    return new_multisample_texture(objects, format, targets.samples, targets.width, targets.height);
  };
  const GBuffer g_buffer{.framebuffer = objects.new_framebuffer(),
                         .colors = texture(GL_R32UI),
                         .normals = texture(GL_R32UI),
                         .depths = texture(GL_DEPTH24_STENCIL8)};
  if (!attach_textures(g_buffer.framebuffer, GL_TEXTURE_2D_MULTISAMPLE, {g_buffer.colors, g_buffer.normals},
                       g_buffer.depths, GL_DEPTH_STENCIL_ATTACHMENT))
    return incomplete();
  return g_buffer;
}

Result<MeshTargets> make_mesh_targets(GlObjects& objects, int width, int height) {
  if (const Status size = check_size(width, height); !size) return size.error();
  GLint of_integers = 0, of_depths = 0;
  glGetIntegerv(GL_MAX_INTEGER_SAMPLES, &of_integers);
  glGetIntegerv(GL_MAX_DEPTH_TEXTURE_SAMPLES, &of_depths);
  MeshTargets t{
      .samples = std::clamp(std::min(of_integers, of_depths), 1, kSamples), .width = width, .height = height};
  const Result<GBuffer> g_buffer = make_g_buffer(objects, t);
  if (!g_buffer) return g_buffer.error();
  t.g_buffer = *g_buffer;
  t.colors = new_texture(objects, GL_RGBA8, GL_RGBA, GL_UNSIGNED_BYTE, width, height);
  t.normals = new_texture(objects, GL_RGB10_A2, GL_RGBA, GL_UNSIGNED_INT_2_10_10_10_REV, width, height);
  t.depths = new_texture(objects, GL_R32F, GL_RED, GL_FLOAT, width, height);
  t.lights = new_texture(objects, GL_RGBA16F, GL_RGBA, GL_HALF_FLOAT, width, height);
  t.occlusions = new_texture(objects, GL_RG32F, GL_RG, GL_FLOAT, width, height);
  const GLuint picture = new_texture(objects, GL_RGBA8, GL_RGBA, GL_UNSIGNED_BYTE, width, height);
  const GLuint levels =  // floats, because levels are compared
      new_texture(objects, GL_DEPTH_COMPONENT32F, GL_DEPTH_COMPONENT, GL_FLOAT, width, height);
  t.shadow_depths = new_shadow_texture(objects);
  for (GLuint* framebuffer : {&t.shadow, &t.resolved, &t.lit, &t.occlusion, &t.picture})
    *framebuffer = objects.new_framebuffer();
  const bool complete = attach_textures(t.shadow, GL_TEXTURE_2D, {}, t.shadow_depths) &&
                        attach_textures(t.resolved, GL_TEXTURE_2D, {t.colors, t.normals, t.depths}, levels) &&
                        attach_textures(t.lit, GL_TEXTURE_2D, {t.lights}, levels) &&
                        attach_textures(t.occlusion, GL_TEXTURE_2D, {t.occlusions}, levels) &&
                        attach_textures(t.picture, GL_TEXTURE_2D, {picture}, 0);
  if (!complete) return incomplete();
  return t;
}

Result<QuickTargets> make_quick_targets(GlObjects& objects, int width, int height) {
  if (const Status size = check_size(width, height); !size) return size.error();
  QuickTargets t{.width = width, .height = height};
  const GLuint picture = new_texture(objects, GL_RGBA8, GL_RGBA, GL_UNSIGNED_BYTE, width, height);
  const GLuint depth =
      new_texture(objects, GL_DEPTH24_STENCIL8, GL_DEPTH_STENCIL, GL_UNSIGNED_INT_24_8, width, height);
  const GLuint behind = new_texture(objects, GL_RGBA8, GL_RGBA, GL_UNSIGNED_BYTE, width, height);
  fill_with_backdrop(width, height);
  for (GLuint* framebuffer : {&t.picture, &t.backdrop}) *framebuffer = objects.new_framebuffer();
  if (!attach_textures(t.picture, GL_TEXTURE_2D, {picture}, depth, GL_DEPTH_STENCIL_ATTACHMENT) ||
      !attach_textures(t.backdrop, GL_TEXTURE_2D, {behind}, 0))
    return incomplete();
  return t;
}

}  // namespace turgor
