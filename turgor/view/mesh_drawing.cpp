#include "turgor/view/mesh_drawing.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <string>

#include <fmt/format.h>

#include "turgor/view/lights.hpp"
#include "turgor/view/mesh_shaders.hpp"
#include "turgor/view/projection.hpp"

namespace turgor {

namespace {

constexpr float kOcclusionReach = 0.08f;                                // of the picture's height
constexpr float kNoLevel = 1, kSmoothLevel = 0.5f, kEdgeLevel = 0.25f;  // selects the lighting of a pixel
constexpr float kSeeThroughShare = 0.9f, kQuickShare = 0.5f;  // largest share of light through a surface
constexpr float kAbsorption = 0.3f;  // depth of tissue that absorbs light, by the size of what is behind it

template <class T>
void upload(GlObjects& objects, GLuint attribute, int components, GLenum type, const std::vector<T>& values) {
  glBindBuffer(GL_ARRAY_BUFFER, objects.new_buffer());
  glBufferData(GL_ARRAY_BUFFER, GLsizeiptr(values.size() * sizeof(T)), values.data(), GL_STREAM_DRAW);
  glVertexAttribPointer(attribute, components, type, type == GL_UNSIGNED_BYTE, 0, nullptr);
  glEnableVertexAttribArray(attribute);
}

// An item's OpenGL objects.
struct GlMesh {
  GLuint array = 0;
  GLsizei indices = 0;
  Vec3 color;
  bool use_map = false, see_through = false, closed = false;
  float size = 0;  // of a see-through item [m]
};

// Triangles of a large mesh that the camera may show, and a margin around them that may cast shadows into the
// picture.
std::vector<Int3> triangles_around(const TriMesh& mesh, const Mat4& to_clip) {
  constexpr std::size_t kLarge = 20'000;
  constexpr float kMargin = 1.3f;  // of the picture's half sides
  if (mesh.triangles.size() < kLarge) return mesh.triangles;
  std::vector<std::uint8_t> beyond;  // bit n: outside the n-th side
  beyond.reserve(mesh.vertices.size());
  for (const Vec3 p : mesh.vertices) {
    const auto row = [&](std::size_t r) {
      return to_clip[r] * p.x + to_clip[4 + r] * p.y + to_clip[8 + r] * p.z + to_clip[12 + r];
    };
    const float x = row(0), y = row(1), side = kMargin * row(3);
    beyond.push_back(std::uint8_t((x > side) | (x < -side) << 1 | (y > side) << 2 | (y < -side) << 3));
  }
  std::vector<Int3> around;
  for (const Int3 t : mesh.triangles)
    if (!(beyond[std::size_t(t.x)] & beyond[std::size_t(t.y)] & beyond[std::size_t(t.z)]))
      around.push_back(t);
  return around;
}

GlMesh upload_item(GlObjects& objects, const RenderItem& item, const Mat4& to_clip) {
  const TriMesh& mesh = *item.mesh;
  const std::vector<Int3> triangles = triangles_around(mesh, to_clip);
  GlMesh held{.array = objects.new_array(),
              .indices = GLsizei(3 * triangles.size()),
              .color = Vec3{float(item.color.r), float(item.color.g), float(item.color.b)} / 255,
              .use_map = item.scale != nullptr,
              .see_through = item.see_through,
              .closed = item.closed};
  if (item.see_through) {
    const Box box = bounding_box(mesh);
    held.size = float(norm(box.high - box.low));
  }
  glBindVertexArray(held.array);
  upload(objects, 0, 3, GL_FLOAT, mesh.vertices);
  upload(objects, 1, 3, GL_FLOAT, mesh.normals.empty() ? vertex_normals(mesh) : mesh.normals);
  if (item.colors) upload(objects, 2, 3, GL_UNSIGNED_BYTE, *item.colors);
  if (item.scale) {
    std::vector<float> fractions(mesh.scalars.size());
    std::transform(mesh.scalars.begin(), mesh.scalars.end(), fractions.begin(),
                   [&item](float scalar) { return scale_fraction(*item.scale, scalar); });
    upload(objects, 3, 1, GL_FLOAT, fractions);
  }
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, objects.new_buffer());
  glBufferData(GL_ELEMENT_ARRAY_BUFFER, GLsizeiptr(triangles.size() * sizeof(Int3)), triangles.data(),
               GL_STREAM_DRAW);
  return held;
}

void draw_items(const std::vector<GlMesh>& items, MeshStyle style = MeshStyle::kSurface) {
  glPolygonMode(GL_FRONT_AND_BACK, style == MeshStyle::kWires ? GL_LINE : GL_FILL);
  for (const GlMesh& item : items) {
    glBindVertexArray(item.array);
    glVertexAttrib3f(2, item.color.x, item.color.y, item.color.z);  // for vertices without colors
    set_uniform("use_map", item.use_map);
    (item.closed ? glEnable : glDisable)(GL_CULL_FACE);
    glDrawElements(GL_TRIANGLES, item.indices, GL_UNSIGNED_INT, nullptr);
  }
  glDisable(GL_CULL_FACE);
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

void set_axes(const View& view) {
  set_uniform("right_axis", Vec3(view.frame.right));
  set_uniform("up", Vec3(view.frame.up));
  set_uniform("back_axis", Vec3(view.frame.back));
}

// Depths of the key light.
void draw_shadow(GLuint program, const MeshTargets& targets, const std::vector<GlMesh>& items,
                 const LightView& light) {
  glBindFramebuffer(GL_FRAMEBUFFER, targets.shadow);
  glViewport(0, 0, kShadowSize, kShadowSize);
  glEnable(GL_DEPTH_TEST);
  glEnable(GL_POLYGON_OFFSET_FILL);
  glPolygonOffset(2.0f, 4.0f);
  glClear(GL_DEPTH_BUFFER_BIT);
  glUseProgram(program);
  set_uniform("to_clip", light.matrix);
  draw_items(items);
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

std::vector<GlMesh> see_through_items(const std::vector<GlMesh>& items) {
  std::vector<GlMesh> through;
  std::copy_if(items.begin(), items.end(), std::back_inserter(through),
               [](const GlMesh& item) { return item.see_through; });
  return through;
}

// Blends hidden fragments of see-through items over the quick picture, with its program and depths.
void draw_see_through(const std::vector<GlMesh>& items) {
  const std::vector<GlMesh> through = see_through_items(items);
  if (through.empty()) return;
  glDepthFunc(GL_GREATER);
  glDepthMask(GL_FALSE);
  glEnable(GL_BLEND);
  glBlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ZERO, GL_ONE);
  set_uniform("through", kQuickShare);
  draw_items(through);
  glDisable(GL_BLEND);
  glDepthMask(GL_TRUE);
  glDepthFunc(GL_LESS);
}

void draw_surfaces(GlObjects& objects, GLuint program, const GBuffer& g_buffer,
                   const std::vector<GlMesh>& items, const View& view, MeshStyle style) {
  glBindFramebuffer(GL_FRAMEBUFFER, g_buffer.framebuffer);
  glEnable(GL_DEPTH_TEST);
  constexpr GLuint kNothing[4] = {};
  for (const GLint target : {0, 1}) glClearBufferuiv(GL_COLOR, target, kNothing);
  glClear(GL_DEPTH_BUFFER_BIT);
  glUseProgram(program);
  set_uniform("to_clip", camera_matrix(view));
  set_uniform("eye", Vec3(view.eye));
  set_axes(view);
  set_texture("color_map", 0, new_color_map(objects));
  draw_items(items, style);
}

// Full-screen triangle; with a depth function, only where the level matches.
void draw_screen(GlObjects& objects, std::optional<GLenum> levels = {}, float level = 0) {
  if (levels)
    glEnable(GL_DEPTH_TEST), glDepthFunc(*levels), glDepthMask(*levels == GL_ALWAYS);
  else
    glDisable(GL_DEPTH_TEST);
  set_uniform("level", level);
  glBindVertexArray(objects.new_array());
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glDepthFunc(GL_LESS), glDepthMask(GL_TRUE);
}

void set_surfaces(const MeshTargets& targets, const GBuffer& g_buffer, const View& view) {
  set_texture("colors", 0, g_buffer.colors, GL_TEXTURE_2D_MULTISAMPLE);
  set_texture("normals", 1, g_buffer.normals, GL_TEXTURE_2D_MULTISAMPLE);
  set_texture("depths", 2, g_buffer.depths, GL_TEXTURE_2D_MULTISAMPLE);
  set_uniform("samples", targets.samples);
  set_uniform("near_far", float(view.near), float(view.far));
}

void resolve_samples(GlObjects& objects, GLuint program, const MeshTargets& targets, const View& view) {
  glBindFramebuffer(GL_FRAMEBUFFER, targets.resolved);
  glUseProgram(program);
  set_surfaces(targets, targets.g_buffer, view);
  set_uniform("smooth_level", kSmoothLevel);
  set_uniform("edge_level", kEdgeLevel);
  draw_screen(objects, GL_ALWAYS);
}

void set_lighting(const MeshTargets& targets, const View& view, const LightView& light) {
  set_texture("shadow", 3, targets.shadow_depths);
  set_uniform("to_light", light.matrix);
  set_uniform("shadow_texel", float(light.width / kShadowSize));
  set_uniform("tan_half", float(view.frame.tan_half * view.aspect), float(view.frame.tan_half));
  set_uniform("eye", Vec3(view.eye));
  set_axes(view);
  set_lights(view);
}

void draw_light(GlObjects& objects, const MeshPrograms& programs, const MeshTargets& targets,
                const View& view, const LightView& light) {
  glBindFramebuffer(GL_FRAMEBUFFER, targets.lit);
  glClearColor(0, 0, 0, 0);
  glClear(GL_COLOR_BUFFER_BIT);
  glUseProgram(programs.smooth);
  set_lighting(targets, view, light);
  set_texture("resolved_colors", 0, targets.colors);
  set_texture("resolved_normals", 1, targets.normals);
  set_texture("resolved_depths", 2, targets.depths);
  draw_screen(objects, GL_EQUAL, kSmoothLevel);
  glUseProgram(programs.edge);
  set_lighting(targets, view, light);
  set_surfaces(targets, targets.g_buffer, view);
  draw_screen(objects, GL_EQUAL, kEdgeLevel);
}

// Blends hidden fragments of see-through items over the surfaces in front of them.
void draw_inner(GlObjects& objects, GLuint program, const MeshTargets& targets, const View& view,
                const LightView& light, float size) {
  glBindFramebuffer(GL_FRAMEBUFFER, targets.lit);
  glUseProgram(program);
  set_lighting(targets, view, light);
  set_surfaces(targets, targets.inner, view);
  set_texture("nearer", 4, targets.g_buffer.depths, GL_TEXTURE_2D_MULTISAMPLE);
  set_texture("outer", 5, targets.g_buffer.colors, GL_TEXTURE_2D_MULTISAMPLE);
  set_uniform("through", kSeeThroughShare);
  set_uniform("absorption", kAbsorption * size);
  glEnable(GL_BLEND);
  glBlendFuncSeparate(GL_ONE, GL_ONE_MINUS_SRC_ALPHA, GL_ZERO, GL_ONE);
  draw_screen(objects, GL_GREATER, kNoLevel);
  glDisable(GL_BLEND);
}

void draw_occlusion(GlObjects& objects, GLuint program, const MeshTargets& targets, const View& view) {
  glBindFramebuffer(GL_FRAMEBUFFER, targets.occlusion);
  glClearColor(1, float(view.far), 0, 0);
  glClear(GL_COLOR_BUFFER_BIT);
  glUseProgram(program);
  set_texture("depths", 0, targets.depths);
  set_texture("normals", 1, targets.normals);
  set_uniform("tan_half", float(view.frame.tan_half * view.aspect), float(view.frame.tan_half));
  set_uniform("reach", kOcclusionReach);
  draw_screen(objects, GL_GREATER, kNoLevel);
}

void draw_picture(GlObjects& objects, GLuint program, const MeshTargets& targets) {
  glBindFramebuffer(GL_FRAMEBUFFER, targets.picture);
  glUseProgram(program);
  set_texture("lights", 0, targets.lights);
  set_texture("occlusions", 1, targets.occlusions);
  set_uniform("backdrop_center", kBackdropCenter), set_uniform("backdrop_edge", kBackdropEdge);
  set_uniform("shoulder", kShoulder);
  draw_screen(objects);
}

// OpenGL objects of the items, and the view.
struct GlScene {
  std::vector<Box> boxes;
  View view;
  std::vector<GlMesh> items;
};

GlScene upload_scene(GlObjects& objects, const std::vector<RenderItem>& items, const Camera& camera,
                     double aspect) {
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  std::vector<Box> boxes;
  for (const RenderItem& item : items)
    if (!item.mesh->triangles.empty()) boxes.push_back(bounding_box(*item.mesh));
  GlScene scene{boxes, make_view(boxes, camera, aspect), {}};
  for (const RenderItem& item : items)
    if (!item.mesh->triangles.empty())
      scene.items.push_back(upload_item(objects, item, camera_matrix(scene.view)));
  return scene;
}

// Reuses the last picture's targets if they fit, else creates new ones.
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

Result<GLuint> draw_fully(GlObjects& objects, MeshDrawing& drawing, const GlScene& scene, MeshStyle style) {
  const View& view = scene.view;
  MeshTargets& targets = *drawing.targets;
  const MeshPrograms& programs = drawing.programs;
  const std::vector<GlMesh> through =
      style == MeshStyle::kSurface ? see_through_items(scene.items) : std::vector<GlMesh>();
  if (!through.empty() && !targets.inner.framebuffer) {
    const Result<GBuffer> inner = make_g_buffer(*drawing.objects, targets);
    if (!inner) return inner.error();
    targets.inner = *inner;
  }
  // shadow map and G-buffers
  const LightView light = make_light_view(scene.boxes, Vec3d(camera_lights(view.frame).key));
  draw_shadow(programs.shadow, targets, scene.items, light);
  glViewport(0, 0, targets.width, targets.height);
  draw_surfaces(objects, programs.surface, targets.g_buffer, scene.items, view, style);
  if (!through.empty()) draw_surfaces(objects, programs.surface, targets.inner, through, view, style);
  // lighting, occlusion and composition
  resolve_samples(objects, programs.resolve, targets, view);
  draw_light(objects, programs, targets, view, light);
  float size = 0;
  for (const GlMesh& item : through) size = std::max(size, item.size);
  if (!through.empty()) draw_inner(objects, programs.inner, targets, view, light, size);
  draw_occlusion(objects, programs.occlusion, targets, view);
  draw_picture(objects, programs.picture, targets);
  return targets.picture;
}

GLuint draw_quickly(GlObjects& objects, const MeshDrawing& drawing, const GlScene& scene, MeshStyle style) {
  const View& view = scene.view;
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
  set_uniform("through", 1.0f);
  draw_items(scene.items, style);
  if (style == MeshStyle::kSurface) draw_see_through(scene.items);
  return targets.picture;
}

}  // namespace

Result<MeshPrograms> link_mesh_programs() {
  MeshPrograms programs;
  struct ProgramSource {
    GLuint* program;
    const char* vertex;
    std::string fragment;
  };
  const std::string lighting = kLighting;
  const ProgramSource sources[] = {
      {&programs.shadow, kShadowVertexShader, kShadowFragmentShader},
      {&programs.surface, kSurfaceVertexShader, kSurfaceFragmentShader},
      {&programs.resolve, kScreenVertexShader, lighting + kResolveMain},
      {&programs.smooth, kScreenVertexShader, lighting + kKeyShare + kSmoothMain},
      {&programs.edge, kScreenVertexShader, lighting + kKeyShare + kEdgeMain},
      {&programs.inner, kScreenVertexShader, lighting + kInnerMain},
      {&programs.occlusion, kScreenVertexShader, kOcclusionFragmentShader},
      {&programs.picture, kScreenVertexShader, kPictureFragmentShader},
      {&programs.quick, kQuickVertexShader, kQuickFragmentShader},
  };
  for (const ProgramSource& one : sources) {
    const Result<GLuint> linked = link_program(one.vertex, one.fragment.c_str());
    if (!linked) return linked.error();
    *one.program = *linked;
  }
  return programs;
}

Result<GLuint> draw_into_texture(MeshDrawing& drawing, const std::vector<RenderItem>& items,
                                 const Camera& camera, int width, int height, RenderQuality quality,
                                 MeshStyle style) {
  while (glGetError() != GL_NO_ERROR) {
  }
  const bool full = quality == RenderQuality::kFull;
  const Status made =
      full ? keep_targets(drawing.objects, drawing.targets, width, height, make_mesh_targets)
           : keep_targets(drawing.quick_objects, drawing.quick, width, height, make_quick_targets);
  if (!made) return made.error();
  GlObjects objects;
  const GlScene scene = upload_scene(objects, items, camera, double(width) / height);
  const Result<GLuint> picture = full ? draw_fully(objects, drawing, scene, style)
                                      : Result<GLuint>(draw_quickly(objects, drawing, scene, style));
  if (!picture) return picture.error();
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
