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
#include "turgor/view/mesh_targets.hpp"
#include "turgor/view/projection.hpp"

namespace turgor {

namespace {

constexpr float kOcclusionReach = 0.08f;  // of the picture's height

struct Programs {
  GLuint shadow = 0, surface = 0, occlusion = 0, picture = 0;
};

Result<Programs> link_programs() {
  Programs programs;
  const std::array<std::tuple<GLuint*, const char*, const char*>, 4> wanted = {{
      {&programs.shadow, kShadowVertexShader, kShadowFragmentShader},
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

template <class T>
void upload(GlObjects& objects, GLuint attribute, int components, GLenum type, const std::vector<T>& values) {
  glBindBuffer(GL_ARRAY_BUFFER, objects.new_buffer());
  glBufferData(GL_ARRAY_BUFFER, GLsizeiptr(values.size() * sizeof(T)), values.data(), GL_STREAM_DRAW);
  glVertexAttribPointer(attribute, components, type, type == GL_UNSIGNED_BYTE, 0, nullptr);
  glEnableVertexAttribArray(attribute);
}

// A part that OpenGL holds.
struct HeldPart {
  GLuint array = 0;
  GLsizei indices = 0;
  Vec3 color;
  bool use_map = false;
};

HeldPart hold_part(GlObjects& objects, const MeshPart& part) {
  const TriMesh& mesh = *part.mesh;
  HeldPart held{.array = objects.new_array(),
                .indices = GLsizei(3 * mesh.triangles.size()),
                .color = Vec3{float(part.color.r), float(part.color.g), float(part.color.b)} / 255,
                .use_map = part.scale != nullptr};
  glBindVertexArray(held.array);
  upload(objects, 0, 3, GL_FLOAT, mesh.vertices);
  upload(objects, 1, 3, GL_FLOAT, mesh.normals.empty() ? vertex_normals(mesh) : mesh.normals);
  if (part.colors) upload(objects, 2, 3, GL_UNSIGNED_BYTE, *part.colors);
  if (part.scale) {
    std::vector<float> fractions(mesh.scalars.size());
    std::transform(mesh.scalars.begin(), mesh.scalars.end(), fractions.begin(),
                   [&part](float scalar) { return scale_fraction(*part.scale, scalar); });
    upload(objects, 3, 1, GL_FLOAT, fractions);
  }
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, objects.new_buffer());
  glBufferData(GL_ELEMENT_ARRAY_BUFFER, GLsizeiptr(mesh.triangles.size() * sizeof(Int3)),
               mesh.triangles.data(), GL_STREAM_DRAW);
  return held;
}

void draw_parts(const std::vector<HeldPart>& parts) {
  for (const HeldPart& part : parts) {
    glBindVertexArray(part.array);
    glVertexAttrib3f(2, part.color.x, part.color.y, part.color.z);  // where vertices have no colours
    set_uniform("use_map", part.use_map);
    glDrawElements(GL_TRIANGLES, part.indices, GL_UNSIGNED_INT, nullptr);
  }
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

// What the key light sees.
void draw_shadow(GLuint program, const MeshTargets& targets, const std::vector<HeldPart>& parts,
                 const LightView& light) {
  glBindFramebuffer(GL_FRAMEBUFFER, targets.shadow);
  glViewport(0, 0, kShadowSize, kShadowSize);
  glEnable(GL_DEPTH_TEST);
  glEnable(GL_POLYGON_OFFSET_FILL);
  glPolygonOffset(2.0f, 4.0f);
  glClear(GL_DEPTH_BUFFER_BIT);
  glUseProgram(program);
  set_uniform("to_clip", light.matrix);
  draw_parts(parts);
  glDisable(GL_POLYGON_OFFSET_FILL);
}

void set_lights(const View& view) {
  const Lights lights = camera_lights(view.frame);
  set_uniform("key", lights.key), set_uniform("key_color", lights.key_color);
  set_uniform("fill", lights.fill), set_uniform("fill_color", lights.fill_color);
  set_uniform("rim", lights.rim), set_uniform("rim_color", lights.rim_color);
  set_uniform("up", lights.up), set_uniform("sky_color", lights.sky_color);
  set_uniform("floor_color", lights.floor_color);
}

void draw_surfaces(GlObjects& objects, GLuint program, const MeshTargets& targets,
                   const std::vector<HeldPart>& parts, const View& view, const LightView& light) {
  glBindFramebuffer(GL_FRAMEBUFFER, targets.sampled);
  glViewport(0, 0, targets.width, targets.height);
  glEnable(GL_DEPTH_TEST);
  glClearColor(0, 0, 0, 0);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  glUseProgram(program);
  set_uniform("to_clip", camera_matrix(view));
  set_uniform("to_light", light.matrix);
  set_uniform("shadow_texel", float(light.width / kShadowSize));
  set_uniform("right_axis", Vec3(view.frame.right)), set_uniform("back_axis", Vec3(view.frame.back));
  set_uniform("eye", Vec3(view.eye));
  set_lights(view);
  set_texture("color_map", 0, new_color_map(objects));
  set_texture("shadow", 1, targets.shadow_depths);
  draw_parts(parts);
}

void draw_screen(GlObjects& objects) {
  glDisable(GL_DEPTH_TEST);
  glBindVertexArray(objects.new_array());
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

void draw_occlusion(GlObjects& objects, GLuint program, const MeshTargets& targets, const View& view) {
  glBindFramebuffer(GL_FRAMEBUFFER, targets.occlusion);
  glUseProgram(program);
  set_texture("depths", 0, targets.depths);
  set_texture("normals", 1, targets.normals);
  set_uniform("tan_half", float(view.frame.tan_half * view.aspect), float(view.frame.tan_half));
  set_uniform("near_far", float(view.near), float(view.far));
  set_uniform("reach", kOcclusionReach);
  draw_screen(objects);
}

void draw_picture(GlObjects& objects, GLuint program, const MeshTargets& targets, const View& view) {
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
  const Result<MeshTargets> targets = make_mesh_targets(objects, width, height);
  if (!targets) return targets.error();
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  std::vector<Box> boxes;
  std::vector<HeldPart> held;
  for (const MeshPart& part : parts) {
    if (part.mesh->triangles.empty()) continue;
    boxes.push_back(bounding_box(*part.mesh));
    held.push_back(hold_part(objects, part));
  }
  const View view = make_view(boxes, camera, double(width) / height);
  const LightView light = make_light_view(boxes, Vec3d(camera_lights(view.frame).key));
  draw_shadow(programs->shadow, *targets, held, light);
  draw_surfaces(objects, programs->surface, *targets, held, view, light);
  resolve_samples(*targets);
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
