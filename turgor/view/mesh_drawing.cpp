#include "turgor/view/mesh_drawing.hpp"

#include <algorithm>
#include <array>
#include <functional>

#include <fmt/format.h>

#include "turgor/view/lights.hpp"
#include "turgor/view/mesh_items.hpp"

namespace turgor {

namespace {

constexpr float kOcclusionReach = 0.08f;  // of the picture's height
// depth values that select the lighting of a pixel
constexpr float kNoLevel = 1, kSmoothLevel = 0.5f, kWetSmoothLevel = 0.375f, kEdgeLevel = 0.25f,
                kWetEdgeLevel = 0.125f;
constexpr float kSeeThroughShare = 0.9f, kQuickShare = 0.5f;  // largest share of light through a surface
constexpr float kAbsorption = 0.3f;  // depth of tissue that absorbs light, by the size of what is behind it

bool has_wet(const GlScene& scene) {
  return std::any_of(scene.items.begin(), scene.items.end(), is_wet) ||
         std::any_of(scene.cut_faces.begin(), scene.cut_faces.end(), is_wet);
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
void draw_shadow(const SurfaceProgram& program, const MeshTargets& targets, const std::vector<GlMesh>& items,
                 const LightView& light) {
  glBindFramebuffer(GL_FRAMEBUFFER, targets.shadow);
  glViewport(0, 0, kShadowSize, kShadowSize);
  glEnable(GL_DEPTH_TEST);
  glEnable(GL_POLYGON_OFFSET_FILL);
  glPolygonOffset(2.0f, 4.0f);
  glClear(GL_DEPTH_BUFFER_BIT);
  draw_items(items, program, [&light](GLuint one) {
    glUseProgram(one);
    set_uniform("to_clip", light.matrix);
  });
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

// Adds the depths of items to the bound framebuffer.
void draw_depths(const SurfaceProgram& program, const std::vector<GlMesh>& items, const View& view) {
  glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
  draw_items(items, program, [&view](GLuint one) {
    glUseProgram(one);
    set_uniform("to_clip", camera_matrix(view));
  });
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
}

// Items and cut faces in a G-buffer. Items that hide them leave nothing else.
void draw_surfaces(GlObjects& objects, const MeshPrograms& programs, const GBuffer& g_buffer,
                   const std::vector<GlMesh>& items, const std::vector<GlMesh>& cut_faces, const View& view,
                   MeshStyle style, const std::vector<GlMesh>& hiding = {}) {
  glBindFramebuffer(GL_FRAMEBUFFER, g_buffer.framebuffer);
  glEnable(GL_DEPTH_TEST);
  constexpr GLuint kNothing[4] = {};
  for (const GLint target : {0, 1}) glClearBufferuiv(GL_COLOR, target, kNothing);
  glClear(GL_DEPTH_BUFFER_BIT);
  draw_depths(programs.shadow, hiding, view);
  const GLuint color_map = new_color_map(objects);
  const auto use = [&](GLuint program) {
    glUseProgram(program);
    set_uniform("to_clip", camera_matrix(view));
    set_uniform("eye", Vec3(view.eye));
    set_axes(view);
    set_texture("color_map", 0, color_map);
  };
  draw_items(items, programs.surface, use, style);
  if (cut_faces.empty() || style != MeshStyle::kSurface) return;
  use(programs.surface.cut);
  draw_cut_faces(programs.shadow.cut, programs.surface.cut, cut_faces, view);
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
  set_uniform("smooth_levels", kSmoothLevel, kWetSmoothLevel);
  set_uniform("edge_levels", kEdgeLevel, kWetEdgeLevel);
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

// Lights pixels inside surfaces, whose level this is.
void light_smooth(GlObjects& objects, GLuint program, const MeshTargets& targets, const View& view,
                  const LightView& light, float level) {
  glUseProgram(program);
  set_lighting(targets, view, light);
  set_texture("resolved_colors", 0, targets.colors);
  set_texture("resolved_normals", 1, targets.normals);
  set_texture("resolved_depths", 2, targets.depths);
  draw_screen(objects, GL_EQUAL, level);
}

// Lights pixels at edges, sample by sample.
void light_edges(GlObjects& objects, GLuint program, const MeshTargets& targets, const View& view,
                 const LightView& light, float level) {
  glUseProgram(program);
  set_lighting(targets, view, light);
  set_surfaces(targets, targets.g_buffer, view);
  draw_screen(objects, GL_EQUAL, level);
}

void draw_light(GlObjects& objects, const MeshPrograms& programs, const MeshTargets& targets,
                const View& view, const LightView& light, bool has_wet) {
  glBindFramebuffer(GL_FRAMEBUFFER, targets.lit);
  glClearColor(0, 0, 0, 0);
  glClear(GL_COLOR_BUFFER_BIT);
  light_smooth(objects, programs.smooth, targets, view, light, kSmoothLevel);
  light_edges(objects, programs.edge, targets, view, light, kEdgeLevel);
  if (!has_wet) return;
  light_smooth(objects, programs.wet_smooth, targets, view, light, kWetSmoothLevel);
  light_edges(objects, programs.wet_edge, targets, view, light, kWetEdgeLevel);
}

// Blends hidden fragments of the see-through items in the inner G-buffer over the surfaces in front of them.
void blend_inner(GlObjects& objects, GLuint program, const MeshTargets& targets, const View& view,
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

// Blends see-through items over the surfaces in front of them, apart from what opaque items hide.
Status draw_inner(GlObjects& objects, MeshDrawing& drawing, const std::vector<GlMesh>& through,
                  const std::vector<GlMesh>& hiding, const View& view, const LightView& light) {
  if (through.empty()) return Done{};
  MeshTargets& targets = *drawing.targets;
  if (!targets.inner.framebuffer) {
    const Result<GBuffer> inner = make_g_buffer(*drawing.objects, targets);
    if (!inner) return inner.error();
    targets.inner = *inner;
  }
  float size = 0;
  for (const GlMesh& item : through) size = std::max(size, item.size);
  draw_surfaces(objects, drawing.programs, targets.inner, through, {}, view, MeshStyle::kSurface, hiding);
  blend_inner(objects, drawing.programs.inner, targets, view, light, size);
  return Done{};
}

Result<GLuint> draw_fully(GlObjects& objects, MeshDrawing& drawing, const GlScene& scene, MeshStyle style) {
  const View& view = scene.view;
  MeshTargets& targets = *drawing.targets;
  const MeshPrograms& programs = drawing.programs;
  // shadow map and G-buffer
  const LightView light = make_light_view(scene.boxes, Vec3d(camera_lights(view.frame).key));
  draw_shadow(programs.shadow, targets, scene.items, light);
  glViewport(0, 0, targets.width, targets.height);
  draw_surfaces(objects, programs, targets.g_buffer, scene.items, scene.cut_faces, view, style);
  // lighting, occlusion and composition
  resolve_samples(objects, programs.resolve, targets, view);
  draw_light(objects, programs, targets, view, light, has_wet(scene));
  if (style == MeshStyle::kSurface) {
    const std::vector<GlMesh> hiding = items_that(scene.items, is_opaque);
    if (Status s = draw_inner(objects, drawing, items_that(scene.items, is_inclusion), hiding, view, light);
        !s)
      return s.error();
    if (Status s = draw_inner(objects, drawing, items_that(scene.items, is_seen_mark), {}, view, light); !s)
      return s.error();
  }
  draw_occlusion(objects, programs.occlusion, targets, view);
  draw_picture(objects, programs.picture, targets);
  return targets.picture;
}

bool has_hidden_inclusions(const std::vector<GlMesh>& items) {
  return std::any_of(items.begin(), items.end(), is_opaque) &&
         std::any_of(items.begin(), items.end(), is_inclusion);
}

// Marks where inclusions lie in front of opaque items, which are the only ones drawn so far.
void mark_inclusions(const SurfaceProgram& program, const std::vector<GlMesh>& items, const View& view) {
  glStencilMask(kFreeStencil);
  glClearStencil(0);
  glClear(GL_STENCIL_BUFFER_BIT);
  glEnable(GL_STENCIL_TEST);
  glStencilFunc(GL_ALWAYS, kFreeStencil, kFreeStencil);
  glStencilOp(GL_KEEP, GL_KEEP, GL_REPLACE);
  glDepthMask(GL_FALSE);
  draw_depths(program, items_that(items, is_inclusion), view);
  glDepthMask(GL_TRUE);
  glDisable(GL_STENCIL_TEST);
  glStencilOp(GL_KEEP, GL_KEEP, GL_KEEP);
  glStencilMask(0xFF);
}

// Blends hidden fragments of see-through items over the picture, with its depths.
template <class Use>
void draw_see_through(const std::vector<GlMesh>& items, const SurfaceProgram& program, const Use& use) {
  glDepthFunc(GL_GREATER);
  glDepthMask(GL_FALSE);
  glEnable(GL_BLEND);
  glBlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ZERO, GL_ONE);
  const auto use_through = [&](GLuint one) {
    use(one);
    set_uniform("through", kQuickShare);
  };
  draw_items(items_that(items, is_seen_mark), program, use_through);
  if (has_hidden_inclusions(items))
    glEnable(GL_STENCIL_TEST), glStencilFunc(GL_EQUAL, kFreeStencil, kFreeStencil);
  draw_items(items_that(items, is_inclusion), program, use_through);
  glDisable(GL_STENCIL_TEST);
  glDisable(GL_BLEND);
  glDepthMask(GL_TRUE);
  glDepthFunc(GL_LESS);
}

// Draws items and cut faces of a quick picture in its bound framebuffer.
void draw_quick_items(GlObjects& objects, const MeshPrograms& programs, const GlScene& scene,
                      MeshStyle style) {
  const View& view = scene.view;
  const GLuint color_map = new_color_map(objects);
  const auto use = [&](GLuint program) {
    glUseProgram(program);
    set_uniform("to_clip", camera_matrix(view));
    set_uniform("eye", Vec3(view.eye));
    set_lights(view);
    set_texture("color_map", 0, color_map);
    set_uniform("through", 1.0f);
  };
  if (style == MeshStyle::kSurface && has_hidden_inclusions(scene.items)) {
    draw_items(items_that(scene.items, is_opaque), programs.quick, use, style);
    mark_inclusions(programs.shadow, scene.items, view);
    draw_items(items_that(scene.items, std::not_fn(is_opaque)), programs.quick, use, style);
  } else {
    draw_items(scene.items, programs.quick, use, style);
  }
  if (style != MeshStyle::kSurface) return;
  if (!scene.cut_faces.empty()) {
    use(programs.quick.cut);
    draw_cut_faces(programs.shadow.cut, programs.quick.cut, scene.cut_faces, view);
  }
  draw_see_through(scene.items, programs.quick, use);
}

GLuint draw_quickly(GlObjects& objects, const MeshDrawing& drawing, const GlScene& scene, MeshStyle style) {
  const QuickTargets& targets = *drawing.quick;
  const int width = targets.width, height = targets.height;
  glBindFramebuffer(GL_READ_FRAMEBUFFER, targets.backdrop);
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, targets.picture);
  glBlitFramebuffer(0, 0, width, height, 0, 0, width, height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
  glBindFramebuffer(GL_FRAMEBUFFER, targets.picture);
  glViewport(0, 0, width, height);
  glEnable(GL_DEPTH_TEST);
  glClear(GL_DEPTH_BUFFER_BIT);
  draw_quick_items(objects, drawing.programs, scene, style);
  return targets.picture;
}

}  // namespace

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
  const GlScene scene = upload_scene(objects, items, camera, double(width) / height, quality);
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
