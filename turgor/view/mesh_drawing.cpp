#include "turgor/view/mesh_drawing.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include <fmt/format.h>

#include "turgor/view/lights.hpp"
#include "turgor/view/mesh_shaders.hpp"
#include "turgor/view/projection.hpp"

namespace turgor {

namespace {

constexpr float kOcclusionReach = 0.08f;  // of the picture's height
constexpr float kThrough = 0.5f;          // of its own light has a part that is seen through another

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
  bool use_map = false, through = false;
};

HeldPart hold_part(GlObjects& objects, const MeshPart& part) {
  const TriMesh& mesh = *part.mesh;
  HeldPart held{.array = objects.new_array(),
                .indices = GLsizei(3 * mesh.triangles.size()),
                .color = Vec3{float(part.color.r), float(part.color.g), float(part.color.b)} / 255,
                .use_map = part.scale != nullptr,
                .through = part.through};
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

void draw_parts(const std::vector<HeldPart>& parts, MeshStyle style = MeshStyle::kSurface) {
  glPolygonMode(GL_FRONT_AND_BACK, style == MeshStyle::kWires ? GL_LINE : GL_FILL);
  for (const HeldPart& part : parts) {
    glBindVertexArray(part.array);
    glVertexAttrib3f(2, part.color.x, part.color.y, part.color.z);  // where vertices have no colours
    set_uniform("use_map", part.use_map);
    glDrawElements(GL_TRIANGLES, part.indices, GL_UNSIGNED_INT, nullptr);
  }
  glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
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

// Depths alone, so that no pixel is lit which something hides.
void draw_depths(GLuint program, const std::vector<HeldPart>& parts, const View& view) {
  glUseProgram(program);
  set_uniform("to_clip", camera_matrix(view));
  glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
  draw_parts(parts);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
}

// What other surfaces hide of the parts that are seen through them, over those: with the program, the targets
// and the depths of the picture so far.
void draw_through(const std::vector<HeldPart>& parts) {
  std::vector<HeldPart> through;
  std::copy_if(parts.begin(), parts.end(), std::back_inserter(through),
               [](const HeldPart& part) { return part.through; });
  if (through.empty()) return;
  glDepthFunc(GL_GREATER);
  glDepthMask(GL_FALSE);
  glColorMaski(1, GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);  // normals stay those of the surface before it
  glEnable(GL_BLEND);
  glEnable(GL_CULL_FACE);
  glBlendColor(0, 0, 0, kThrough);
  glBlendFuncSeparate(GL_CONSTANT_ALPHA, GL_ONE_MINUS_CONSTANT_ALPHA, GL_ZERO, GL_ONE);
  set_uniform("through", true);
  draw_parts(through);
  set_uniform("through", false);
  glDisable(GL_CULL_FACE);
  glDisable(GL_BLEND);
  glColorMaski(1, GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  glDepthMask(GL_TRUE);
  glDepthFunc(GL_LESS);
}

void draw_surfaces(GlObjects& objects, const MeshPrograms& programs, const MeshTargets& targets,
                   const std::vector<HeldPart>& parts, const View& view, const LightView& light,
                   MeshStyle style) {
  glBindFramebuffer(GL_FRAMEBUFFER, targets.sampled);
  glViewport(0, 0, targets.width, targets.height);
  glEnable(GL_DEPTH_TEST);
  glClearColor(0, 0, 0, 0);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  if (style == MeshStyle::kSurface) draw_depths(programs.shadow, parts, view);
  glDepthFunc(GL_LEQUAL);
  glUseProgram(programs.surface);
  set_uniform("to_clip", camera_matrix(view));
  set_uniform("to_light", light.matrix);
  set_uniform("shadow_texel", float(light.width / kShadowSize));
  set_uniform("right_axis", Vec3(view.frame.right)), set_uniform("back_axis", Vec3(view.frame.back));
  set_uniform("eye", Vec3(view.eye));
  set_lights(view);
  set_texture("color_map", 0, new_color_map(objects));
  set_texture("shadow", 1, targets.shadow_depths);
  draw_parts(parts, style);
  glDepthFunc(GL_LESS);
  if (style == MeshStyle::kSurface) draw_through(parts);
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

// What a picture shows, as OpenGL holds it.
struct HeldScene {
  std::vector<Box> boxes;
  std::vector<HeldPart> parts;
};

HeldScene hold_scene(GlObjects& objects, const std::vector<MeshPart>& parts) {
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  HeldScene scene;
  for (const MeshPart& part : parts) {
    if (part.mesh->triangles.empty()) continue;
    scene.boxes.push_back(bounding_box(*part.mesh));
    scene.parts.push_back(hold_part(objects, part));
  }
  return scene;
}

// The targets of the last picture when they fit, else new ones.
template <class Targets>
Status keep_targets(std::unique_ptr<GlObjects>& objects, std::optional<Targets>& targets, int width,
                    int height, Result<Targets> (*make)(GlObjects&, int, int)) {
  if (targets && targets->width == width && targets->height == height) return Done{};
  targets.reset();
  objects = std::make_unique<GlObjects>();
  const Result<Targets> made = make(*objects, width, height);
  if (!made) return made.error();
  targets = *made;
  return Done{};
}

GLuint draw_fully(GlObjects& objects, const MeshDrawing& drawing, const HeldScene& scene, const View& view,
                  MeshStyle style) {
  const MeshTargets& targets = *drawing.targets;
  const LightView light = make_light_view(scene.boxes, Vec3d(camera_lights(view.frame).key));
  draw_shadow(drawing.programs.shadow, targets, scene.parts, light);
  draw_surfaces(objects, drawing.programs, targets, scene.parts, view, light, style);
  resolve_samples(targets);
  draw_occlusion(objects, drawing.programs.occlusion, targets, view);
  draw_picture(objects, drawing.programs.picture, targets, view);
  return targets.picture;
}

GLuint draw_quickly(GlObjects& objects, const MeshDrawing& drawing, const HeldScene& scene, const View& view,
                    MeshStyle style) {
  const QuickTargets& targets = *drawing.quick;
  const int width = targets.width, height = targets.height;
  glBindFramebuffer(GL_READ_FRAMEBUFFER, targets.backdrop);
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, targets.picture);
  glBlitFramebuffer(0, 0, width, height, 0, 0, width, height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
  glBindFramebuffer(GL_FRAMEBUFFER, targets.picture);
  glViewport(0, 0, width, height);
  glEnable(GL_DEPTH_TEST);
  glClear(GL_DEPTH_BUFFER_BIT);
  glUseProgram(drawing.programs.quick);
  set_uniform("to_clip", camera_matrix(view));
  set_uniform("eye", Vec3(view.eye));
  set_lights(view);
  set_texture("color_map", 0, new_color_map(objects));
  draw_parts(scene.parts, style);
  if (style == MeshStyle::kSurface) draw_through(scene.parts);
  return targets.picture;
}

}  // namespace

Result<MeshPrograms> link_mesh_programs() {
  MeshPrograms programs;
  const std::array<std::tuple<GLuint*, const char*, const char*>, 5> wanted = {{
      {&programs.shadow, kShadowVertexShader, kShadowFragmentShader},
      {&programs.surface, kSurfaceVertexShader, kSurfaceFragmentShader},
      {&programs.occlusion, kScreenVertexShader, kOcclusionFragmentShader},
      {&programs.picture, kScreenVertexShader, kPictureFragmentShader},
      {&programs.quick, kQuickVertexShader, kQuickFragmentShader},
  }};
  for (const auto& [program, vertex, fragment] : wanted) {
    const Result<GLuint> linked = link_program(vertex, fragment);
    if (!linked) return linked.error();
    *program = *linked;
  }
  return programs;
}

Result<GLuint> draw_into_texture(MeshDrawing& drawing, const std::vector<MeshPart>& parts,
                                 const Camera& camera, int width, int height, MeshCare care,
                                 MeshStyle style) {
  while (glGetError() != GL_NO_ERROR) {
  }
  const bool full = care == MeshCare::kFull;
  const Status made =
      full ? keep_targets(drawing.objects, drawing.targets, width, height, make_mesh_targets)
           : keep_targets(drawing.quick_objects, drawing.quick, width, height, make_quick_targets);
  if (!made) return made.error();
  GlObjects objects;
  const HeldScene scene = hold_scene(objects, parts);
  const View view = make_view(scene.boxes, camera, double(width) / height);
  const GLuint picture = full ? draw_fully(objects, drawing, scene, view, style)
                              : draw_quickly(objects, drawing, scene, view, style);
  if (const GLenum error = glGetError(); error != GL_NO_ERROR)
    return Error{fmt::format("cannot draw: OpenGL failed with error {:#x} ({})", error,
                             error == GL_OUT_OF_MEMORY ? "out of memory" : "see glGetError")};
  return picture;
}

Image read_pixels(int width, int height) {
  Image image = make_image(width, height);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, width, height, GL_RGB, GL_UNSIGNED_BYTE, image.pixels.data());
  for (int y = 0; y < height / 2; y++)  // OpenGL counts rows from the bottom
    std::swap_ranges(&image.at(0, y), &image.at(0, y) + width, &image.at(0, height - 1 - y));
  return image;
}

}  // namespace turgor
