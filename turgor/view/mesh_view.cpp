#include "turgor/view/mesh_view.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "turgor/view/annotate.hpp"
#include "turgor/view/gl.hpp"
#include "turgor/view/gl_context.hpp"
#include "turgor/view/lights.hpp"
#include "turgor/view/mesh_shaders.hpp"

namespace turgor {

namespace {

constexpr int kSamples = 8;               // a pixel, where the driver has so many
constexpr float kOcclusionReach = 0.08f;  // of the picture's height

struct Programs {
  GLuint surface = 0, occlusion = 0, picture = 0;
};

Result<Programs> link_programs() {
  Programs programs;
  const std::array<std::tuple<GLuint*, const char*, const char*>, 3> wanted = {{
      {&programs.surface, kSurfaceVertexShader, kSurfaceFragmentShader},
      {&programs.occlusion, kScreenVertexShader, kOcclusionFragmentShader},
      {&programs.picture, kScreenVertexShader, kPictureFragmentShader},
  }};
  for (const auto& [program, vertex, fragment] : wanted) {
    const Result<GLuint> linked = link_program(vertex, fragment);
    if (!linked) return linked.error();
    *program = *linked;
  }
  return programs;
}

// Several samples a pixel, and the same resolved to one.
struct Targets {
  GLuint sampled = 0, resolved = 0, occlusion = 0, picture = 0;  // framebuffers
  GLuint lights = 0, normals = 0, depths = 0, occlusions = 0;    // textures
};

Result<Targets> make_targets(GlObjects& objects, int width, int height) {
  GLint most_samples = 0, most_pixels = 0;
  glGetIntegerv(GL_MAX_SAMPLES, &most_samples);
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &most_pixels);
  if (width < 1 || height < 1 || width > most_pixels || height > most_pixels)
    return Error{fmt::format("cannot draw a picture of {} x {} pixels: OpenGL here draws 1 to {}", width,
                             height, most_pixels)};
  const int samples = std::clamp(most_samples, 1, kSamples);
  Targets t;
  const GLuint light_samples = new_multisample_texture(objects, GL_RGBA16F, samples, width, height);
  const GLuint normal_samples = new_multisample_texture(objects, GL_RGBA8, samples, width, height);
  const GLuint depth_samples = new_multisample_texture(objects, GL_DEPTH_COMPONENT24, samples, width, height);
  t.lights = new_texture(objects, GL_RGBA16F, GL_RGBA, GL_HALF_FLOAT, width, height);
  t.normals = new_texture(objects, GL_RGBA8, GL_RGBA, GL_UNSIGNED_BYTE, width, height);
  t.depths = new_texture(objects, GL_DEPTH_COMPONENT24, GL_DEPTH_COMPONENT, GL_UNSIGNED_INT, width, height);
  t.occlusions = new_texture(objects, GL_RGBA8, GL_RGBA, GL_UNSIGNED_BYTE, width, height);
  const GLuint picture = new_texture(objects, GL_RGBA8, GL_RGBA, GL_UNSIGNED_BYTE, width, height);
  for (GLuint* framebuffer : {&t.sampled, &t.resolved, &t.occlusion, &t.picture})
    *framebuffer = objects.new_framebuffer();
  const bool complete =
      attach_textures(t.sampled, GL_TEXTURE_2D_MULTISAMPLE, {light_samples, normal_samples}, depth_samples) &&
      attach_textures(t.resolved, GL_TEXTURE_2D, {t.lights, t.normals}, t.depths) &&
      attach_textures(t.occlusion, GL_TEXTURE_2D, {t.occlusions}, 0) &&
      attach_textures(t.picture, GL_TEXTURE_2D, {picture}, 0);
  if (!complete) return Error{"cannot draw: glCheckFramebufferStatus found an incomplete framebuffer"};
  return t;
}

struct View {
  CameraFrame frame;
  Vec3d eye;
  double aspect, near, far;
};

// The nearest and farthest depth are taken from what there is to see.
View make_view(const std::vector<MeshPart>& parts, const Camera& camera, double aspect) {
  View view{camera_frame(camera), camera.eye, aspect, 1e30, 0};
  for (const MeshPart& part : parts) {
    const Box box = bounding_box(*part.mesh);
    for (int i = 0; i < 8; i++) {
      const Vec3d x{i & 1 ? box.high.x : box.low.x, i & 2 ? box.high.y : box.low.y,
                    i & 4 ? box.high.z : box.low.z};
      const double depth = dot(view.eye - x, view.frame.back);
      view.near = std::min(view.near, depth);
      view.far = std::max(view.far, depth);
    }
  }
  view.far = view.far > 0 ? 1.01 * view.far : 1;
  view.near = std::clamp(0.98 * view.near, 2e-3 * view.far, 0.9 * view.far);
  return view;
}

// From patient space to clip space, by columns.
std::array<float, 16> clip_matrix(const View& view) {
  const auto& [right, up, back, tan_half] = view.frame;
  const double sx = 1 / (tan_half * view.aspect), sy = 1 / tan_half;
  const double a = (view.near + view.far) / (view.near - view.far),
               b = 2 * view.near * view.far / (view.near - view.far);
  std::array<float, 16> m{};
  for (int axis = 0; axis < 3; axis++) {
    m[std::size_t(4 * axis)] = float(sx * right[axis]);
    m[std::size_t(4 * axis + 1)] = float(sy * up[axis]);
    m[std::size_t(4 * axis + 2)] = float(a * back[axis]);
    m[std::size_t(4 * axis + 3)] = float(-back[axis]);
  }
  m[12] = float(-sx * dot(right, view.eye));
  m[13] = float(-sy * dot(up, view.eye));
  m[14] = float(-a * dot(back, view.eye) + b);
  m[15] = float(dot(back, view.eye));
  return m;
}

template <class T>
void upload(GlObjects& objects, GLuint attribute, int components, GLenum type, const std::vector<T>& values) {
  glBindBuffer(GL_ARRAY_BUFFER, objects.new_buffer());
  glBufferData(GL_ARRAY_BUFFER, GLsizeiptr(values.size() * sizeof(T)), values.data(), GL_STREAM_DRAW);
  glVertexAttribPointer(attribute, components, type, type == GL_UNSIGNED_BYTE, 0, nullptr);
  glEnableVertexAttribArray(attribute);
}

void draw_part(GlObjects& objects, const MeshPart& part) {
  const TriMesh& mesh = *part.mesh;
  if (mesh.triangles.empty()) return;
  glBindVertexArray(objects.new_array());
  upload(objects, 0, 3, GL_FLOAT, mesh.vertices);
  upload(objects, 1, 3, GL_FLOAT, mesh.normals.empty() ? vertex_normals(mesh) : mesh.normals);
  glVertexAttrib3f(2, float(part.color.r) / 255, float(part.color.g) / 255, float(part.color.b) / 255);
  if (part.colors) upload(objects, 2, 3, GL_UNSIGNED_BYTE, *part.colors);
  if (part.scale) {
    std::vector<float> fractions(mesh.scalars.size());
    std::transform(mesh.scalars.begin(), mesh.scalars.end(), fractions.begin(),
                   [&part](float scalar) { return scale_fraction(*part.scale, scalar); });
    upload(objects, 3, 1, GL_FLOAT, fractions);
  }
  set_uniform("use_map", part.scale != nullptr);
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, objects.new_buffer());
  glBufferData(GL_ELEMENT_ARRAY_BUFFER, GLsizeiptr(mesh.triangles.size() * sizeof(Int3)),
               mesh.triangles.data(), GL_STREAM_DRAW);
  glDrawElements(GL_TRIANGLES, GLsizei(3 * mesh.triangles.size()), GL_UNSIGNED_INT, nullptr);
}

GLuint new_color_map(GlObjects& objects) {
  std::array<Rgb, 256> colors;
  for (std::size_t i = 0; i < colors.size(); i++) colors[i] = map_color(float(i) / 255);
  const GLuint texture = new_texture(objects, GL_RGB8, GL_RGB, GL_UNSIGNED_BYTE, 256, 1);
  glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, 256, 1, GL_RGB, GL_UNSIGNED_BYTE, colors.data());
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  return texture;
}

void draw_surfaces(GlObjects& objects, GLuint program, const std::vector<MeshPart>& parts, const View& view) {
  glEnable(GL_DEPTH_TEST);
  glClearColor(0, 0, 0, 0);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  glUseProgram(program);
  const std::array<float, 16> to_clip = clip_matrix(view);
  glUniformMatrix4fv(uniform_place("to_clip"), 1, GL_FALSE, to_clip.data());
  const Vec3 right(view.frame.right), up(view.frame.up), back(view.frame.back);
  const float to_view[] = {right.x, right.y, right.z, up.x, up.y, up.z, back.x, back.y, back.z};
  glUniformMatrix3fv(uniform_place("to_view"), 1, GL_TRUE, to_view);
  set_uniform("eye", Vec3(view.eye));
  const Lights lights = camera_lights(view.frame);
  set_uniform("key", lights.key), set_uniform("key_color", lights.key_color);
  set_uniform("fill", lights.fill), set_uniform("fill_color", lights.fill_color);
  set_uniform("rim", lights.rim), set_uniform("rim_color", lights.rim_color);
  set_uniform("up", lights.up), set_uniform("sky_color", lights.sky_color),
      set_uniform("floor_color", lights.floor_color);
  set_texture("color_map", 0, new_color_map(objects));
  for (const MeshPart& part : parts) draw_part(objects, part);
}

void resolve(const Targets& targets, int width, int height) {
  glBindFramebuffer(GL_READ_FRAMEBUFFER, targets.sampled);
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, targets.resolved);
  for (const GLenum attachment : {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1}) {
    glReadBuffer(attachment);
    const GLenum buffers[] = {attachment == GL_COLOR_ATTACHMENT0 ? attachment : GL_NONE,
                              attachment == GL_COLOR_ATTACHMENT1 ? attachment : GL_NONE};
    glDrawBuffers(2, buffers);
    glBlitFramebuffer(0, 0, width, height, 0, 0, width, height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
  }
  glBlitFramebuffer(0, 0, width, height, 0, 0, width, height, GL_DEPTH_BUFFER_BIT, GL_NEAREST);
}

void draw_screen(GlObjects& objects) {
  glDisable(GL_DEPTH_TEST);
  glBindVertexArray(objects.new_array());
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

void draw_occlusion(GlObjects& objects, GLuint program, const Targets& targets, const View& view) {
  glBindFramebuffer(GL_FRAMEBUFFER, targets.occlusion);
  glUseProgram(program);
  set_texture("depths", 0, targets.depths);
  set_texture("normals", 1, targets.normals);
  set_uniform("tan_half", float(view.frame.tan_half * view.aspect), float(view.frame.tan_half));
  set_uniform("near_far", float(view.near), float(view.far));
  set_uniform("reach", kOcclusionReach);
  draw_screen(objects);
}

void draw_picture(GlObjects& objects, GLuint program, const Targets& targets, const View& view) {
  glBindFramebuffer(GL_FRAMEBUFFER, targets.picture);
  glUseProgram(program);
  set_texture("lights", 0, targets.lights);
  set_texture("occlusions", 1, targets.occlusions);
  set_texture("depths", 2, targets.depths);
  set_uniform("near_far", float(view.near), float(view.far));
  set_uniform("backdrop_centre", kBackdropCentre), set_uniform("backdrop_edge", kBackdropEdge);
  set_uniform("shoulder", kShoulder);
  draw_screen(objects);
}

Image read_pixels(int width, int height) {
  Image image = make_image(width, height);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, width, height, GL_RGB, GL_UNSIGNED_BYTE, image.pixels.data());
  for (int y = 0; y < height / 2; y++)  // OpenGL counts rows from the bottom
    std::swap_ranges(&image.at(0, y), &image.at(0, y) + width, &image.at(0, height - 1 - y));
  return image;
}

Result<Image> draw_scene(const std::vector<MeshPart>& parts, const Camera& camera, int width, int height) {
  const Result<CurrentGl> gl = hold_gl();
  if (!gl) return gl.error();
  static const Result<Programs> programs = link_programs();  // guarded by holding the context
  if (!programs) return programs.error();
  while (glGetError() != GL_NO_ERROR) {
  }
  GlObjects objects;
  const Result<Targets> targets = make_targets(objects, width, height);
  if (!targets) return targets.error();
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glViewport(0, 0, width, height);
  const View view = make_view(parts, camera, double(width) / height);
  glBindFramebuffer(GL_FRAMEBUFFER, targets->sampled);
  draw_surfaces(objects, programs->surface, parts, view);
  resolve(*targets, width, height);
  draw_occlusion(objects, programs->occlusion, *targets, view);
  draw_picture(objects, programs->picture, *targets, view);
  Image image = read_pixels(width, height);
  if (const GLenum error = glGetError(); error != GL_NO_ERROR)
    return Error{fmt::format("cannot draw: OpenGL failed with error {:#x} ({})", error,
                             error == GL_OUT_OF_MEMORY ? "out of memory" : "see glGetError")};
  return image;
}

void draw_legends(Image& image, const std::vector<MeshPart>& parts) {
  std::vector<const ColorScale*> drawn;
  for (const MeshPart& part : parts) {
    if (!part.scale || std::find(drawn.begin(), drawn.end(), part.scale) != drawn.end()) continue;
    draw_legend(image, *part.scale, int(drawn.size()));
    drawn.push_back(part.scale);
  }
}

}  // namespace

Result<Image> draw_meshes(const std::vector<MeshPart>& parts, const Camera& camera, int width, int height) {
  for (const MeshPart& part : parts) {
    TURGOR_ASSERT(part.mesh, "every part of draw_meshes has a mesh");
    const std::size_t count = part.mesh->vertices.size();
    TURGOR_ASSERT(part.mesh->normals.empty() || part.mesh->normals.size() == count,
                  "one normal a vertex, or none");
    TURGOR_ASSERT(!part.scale || part.mesh->scalars.size() == count,
                  "a part with a scale has one scalar a vertex");
    TURGOR_ASSERT(!part.colors || part.colors->size() == count, "one colour a vertex");
  }
  Result<Image> image = draw_scene(parts, camera, width, height);
  if (image) draw_legends(*image, parts);
  return image;
}

}  // namespace turgor
