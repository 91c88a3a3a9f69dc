#include "turgor/view/mesh_items.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/geometry/loop_subdivision.hpp"

namespace turgor {

namespace {

template <class T>
void upload(GlObjects& objects, GLuint attribute, int components, GLenum type, const std::vector<T>& values) {
  glBindBuffer(GL_ARRAY_BUFFER, objects.new_buffer());
  glBufferData(GL_ARRAY_BUFFER, GLsizeiptr(values.size() * sizeof(T)), values.data(), GL_STREAM_DRAW);
  glVertexAttribPointer(attribute, components, type, type == GL_UNSIGNED_BYTE, 0, nullptr);
  glEnableVertexAttribArray(attribute);
}

// Vertices outside the picture, by bits: bit n = outside the n-th side, and a margin around it.
std::vector<std::uint8_t> vertices_beyond(const TriMesh& mesh, const Mat4& to_clip) {
  constexpr float kMargin = 1.3f;  // of the picture's half sides
  std::vector<std::uint8_t> beyond;
  beyond.reserve(mesh.vertices.size());
  for (const Vec3 p : mesh.vertices) {
    const auto row = [&](std::size_t r) {
      return to_clip[r] * p.x + to_clip[4 + r] * p.y + to_clip[8 + r] * p.z + to_clip[12 + r];
    };
    const float x = row(0), y = row(1), side = kMargin * row(3);
    beyond.push_back(std::uint8_t((x > side) | (x < -side) << 1 | (y > side) << 2 | (y < -side) << 3));
  }
  return beyond;
}

// True if a triangle clearly shows its back to the eye. Triangles seen edge-on are left to OpenGL.
bool shows_back(const TriMesh& mesh, Int3 t, Vec3 eye) {
  constexpr float kEdgeOn = 1e-3f;  // cosine
  const Vec3 a = mesh.vertices[std::size_t(t.x)];
  const Vec3 normal = cross(mesh.vertices[std::size_t(t.y)] - a, mesh.vertices[std::size_t(t.z)] - a),
             to_eye = eye - a;
  const float facing = dot(normal, to_eye);
  return facing < 0 && facing * facing > kEdgeOn * kEdgeOn * dot(normal, normal) * dot(to_eye, to_eye);
}

// Triangles of a large mesh that the camera may show. In full quality, also those that may cast shadows into
// the picture: back faces, and a margin around it. If a quick picture would show very many of a subdivided
// surface, they cover few pixels each, and the triangles before its last subdivision are shown.
std::vector<Int3> shown_triangles(const RenderItem& item, const View& view, RenderQuality quality) {
  constexpr std::size_t kLarge = 20'000, kMostQuick = 60'000;
  const TriMesh& mesh = *item.mesh;
  if (mesh.triangles.size() < kLarge) return mesh.triangles;
  const std::vector<std::uint8_t> beyond = vertices_beyond(mesh, camera_matrix(view));
  const bool only_front = quality == RenderQuality::kQuick && item.closed && item.cutaway.planes == 0;
  const Vec3 eye(view.eye);
  std::vector<Int3> shown;
  shown.reserve(mesh.triangles.size());
  const auto add = [&](Int3 t) {
    if (!(beyond[std::size_t(t.x)] & beyond[std::size_t(t.y)] & beyond[std::size_t(t.z)]) &&
        !(only_front && shows_back(mesh, t, eye)))
      shown.push_back(t);
  };
  for (const Int3 t : mesh.triangles) add(t);
  if (quality != RenderQuality::kQuick || !item.in_fours || shown.size() <= kMostQuick) return shown;
  shown.clear();
  for (std::size_t t = 0; t + 3 < mesh.triangles.size(); t += 4) add(triangle_of_four(&mesh.triangles[t]));
  return shown;
}

GlMesh upload_item(GlObjects& objects, const RenderItem& item, const View& view, RenderQuality quality) {
  const TriMesh& mesh = *item.mesh;
  const std::vector<Int3> triangles = shown_triangles(item, view, quality);
  GlMesh held{.array = objects.new_array(),
              .indices = GLsizei(3 * triangles.size()),
              .color = Vec3{float(item.color.r), float(item.color.g), float(item.color.b)} / 255,
              .use_map = item.scale != nullptr,
              .see_through = item.see_through,
              .opaque = item.opaque,
              .is_mark = item.is_mark,
              .closed = item.closed,
              .wet = item.wet,
              .cutaway = item.cutaway};
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

// Square in a plane that covers a box, as a strip of four vertices. It depends on plane and box only, so that
// faces of several bodies in one plane have equal depths.
GLuint upload_face(GlObjects& objects, const CutawayPlane& plane, const Box& box) {
  const Vec3d middle = (box.low + box.high) * 0.5, normal = plane.outward;
  const Vec3d center = middle + normal * dot(plane.point - middle, normal);
  const Vec3d other = std::abs(normal.x) < 0.7 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0};
  const Vec3d right = normalized(cross(other, normal)) * norm(box.high - box.low), up = cross(normal, right);
  const GLuint array = objects.new_array();
  glBindVertexArray(array);
  upload(objects, 0, 3, GL_FLOAT,
         std::vector<Vec3>{Vec3(center - right - up), Vec3(center + right - up), Vec3(center - right + up),
                           Vec3(center + right + up)});
  upload(objects, 1, 3, GL_FLOAT, std::vector<Vec3>(4, Vec3(normal)));
  return array;
}

// Uploads the picture of a face, with coordinates from 0 to 1 between its outer borders.
void upload_picture(GlObjects& objects, const FacePicture& picture, int face, GlMesh& held) {
  const Image& image = picture.image;
  const GLuint texture = objects.new_texture();
  held.pictures[face] = texture;
  glBindTexture(GL_TEXTURE_2D, texture);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGB8, image.width, image.height, 0, GL_RGB, GL_UNSIGNED_BYTE,
               image.pixels.data());
  for (const GLenum filter : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
    glTexParameteri(GL_TEXTURE_2D, filter, GL_LINEAR);
  for (const GLenum wrap : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T})
    glTexParameteri(GL_TEXTURE_2D, wrap, GL_CLAMP_TO_EDGE);
  const Vec3d steps[2] = {picture.right, picture.up};
  const double counts[2] = {double(image.width), double(image.height)};
  for (int i = 0; i < 2; i++) {
    const Vec3d row = steps[i] / (dot(steps[i], steps[i]) * counts[i]);
    held.to_picture[face][i] = Vec3(row);
    held.offset[face][i] = float(0.5 / counts[i] - dot(row, picture.corner));
  }
}

// Draws only points with dot(normal, x) + offset ≥ 0.
void clip_to(Vec3d normal, double offset) {
  set_uniform("kept_side", Vec3(normal), float(offset));
  glEnable(GL_CLIP_DISTANCE0);
}
void clip_to_kept(const CutawayPlane& plane) { clip_to(-plane.outward, dot(plane.outward, plane.point)); }
void clip_to_removed(const CutawayPlane& plane) { clip_to(plane.outward, -dot(plane.outward, plane.point)); }

void draw_triangles(const GlMesh& item) {
  glDrawElements(GL_TRIANGLES, item.indices, GL_UNSIGNED_INT, nullptr);
}

// Sets the attributes and uniforms of the item that are constant.
void set_item(const GlMesh& item) {
  glVertexAttrib3f(2, item.color.x, item.color.y, item.color.z);  // for vertices without colors
  set_uniform("use_map", item.use_map);
  set_uniform("wet", item.wet);
  set_uniform("use_picture", false);
}

void set_picture(const GlMesh& item, int face) {
  if (!item.pictures[face]) return;
  set_uniform("use_picture", true);
  set_uniform("picture_right", item.to_picture[face][0], item.offset[face][0]);
  set_uniform("picture_up", item.to_picture[face][1], item.offset[face][1]);
  set_texture("face_picture", 6, item.pictures[face]);
}

// Counts the surfaces of the item on the kept side of the plane: a stencil above kNone is inside.
constexpr GLint kNone = 64;
constexpr GLuint kCounter = 0xFF & ~kFreeStencil;
void count_surfaces(GLuint counting, const GlMesh& item, const CutawayPlane& plane, const Mat4& to_clip) {
  glStencilMask(kCounter);
  glClearStencil(kNone);
  glClear(GL_STENCIL_BUFFER_BIT);
  glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
  glDisable(GL_DEPTH_TEST);
  glStencilFunc(GL_ALWAYS, 0, kCounter);
  glStencilOpSeparate(GL_BACK, GL_KEEP, GL_KEEP, GL_INCR);
  glStencilOpSeparate(GL_FRONT, GL_KEEP, GL_KEEP, GL_DECR);
  glUseProgram(counting);
  set_uniform("to_clip", to_clip);
  clip_to_kept(plane);
  glBindVertexArray(item.array);
  draw_triangles(item);
  glDisable(GL_CLIP_DISTANCE0);
  glEnable(GL_DEPTH_TEST);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
}

// Draws the square in a plane where it is inside the item and beside the wedge's other plane.
void fill_face(GLuint program, const GlMesh& item, int plane) {
  glStencilFunc(GL_LESS, kNone, kCounter);
  glStencilOp(GL_KEEP, GL_KEEP, GL_KEEP);
  glDepthFunc(GL_LEQUAL);
  glUseProgram(program);
  set_item(item);
  set_uniform("use_map", false);
  set_picture(item, plane);
  if (item.cutaway.planes == 2)
    clip_to_removed(item.cutaway.plane[1 - plane]);
  else
    clip_to({}, 1);
  glBindVertexArray(item.faces[plane]);
  glDrawArrays(GL_TRIANGLE_STRIP, 0, 4);
  glDisable(GL_CLIP_DISTANCE0);
  glDepthFunc(GL_LESS);
}

}  // namespace

GlScene upload_scene(GlObjects& objects, const std::vector<RenderItem>& items, const Camera& camera,
                     double aspect, RenderQuality quality) {
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  std::vector<Box> boxes;
  for (const RenderItem& item : items)
    if (!item.mesh->triangles.empty()) boxes.push_back(bounding_box(*item.mesh));
  GlScene scene{boxes, make_view(boxes, camera, aspect), {}, {}};
  for (const RenderItem& item : items) {
    if (item.mesh->triangles.empty()) continue;
    GlMesh held = upload_item(objects, item, scene.view, quality);
    if (!item.is_cut_face) {
      scene.items.push_back(held);
      continue;
    }
    Box all = boxes.front();
    for (const Box& box : boxes) all = joined(all, box);
    for (int p = 0; p < item.cutaway.planes; p++) {
      held.faces[p] = upload_face(objects, item.cutaway.plane[p], all);
      if (std::size_t(p) < item.face_pictures.size())
        upload_picture(objects, item.face_pictures[std::size_t(p)], p, held);
    }
    scene.cut_faces.push_back(held);
  }
  return scene;
}

void draw_whole_items(const std::vector<GlMesh>& items, MeshStyle style) {
  glPolygonMode(GL_FRONT_AND_BACK, style == MeshStyle::kWires ? GL_LINE : GL_FILL);
  for (const GlMesh& item : items) {
    glBindVertexArray(item.array);
    set_item(item);
    (item.closed ? glEnable : glDisable)(GL_CULL_FACE);
    draw_triangles(item);
  }
  glDisable(GL_CULL_FACE);
  glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
}

void draw_cut_items(const std::vector<GlMesh>& items, MeshStyle style) {
  glPolygonMode(GL_FRONT_AND_BACK, style == MeshStyle::kWires ? GL_LINE : GL_FILL);
  for (const GlMesh& item : items) {
    glBindVertexArray(item.array);
    set_item(item);
    for (int p = 0; p < item.cutaway.planes; p++) {  // what one plane of a wedge removes, the other may keep
      clip_to_kept(item.cutaway.plane[p]);
      draw_triangles(item);  // both sides: the inside is visible, and casts shadows
    }
  }
  glDisable(GL_CLIP_DISTANCE0);
  glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
}

void draw_cut_faces(GLuint counting, GLuint program, const std::vector<GlMesh>& faces, const View& view) {
  if (faces.empty()) return;
  glEnable(GL_STENCIL_TEST);
  for (const GlMesh& item : faces)
    for (int p = 0; p < item.cutaway.planes; p++) {
      const CutawayPlane& plane = item.cutaway.plane[p];
      if (!removes(plane, view.eye)) continue;  // the body hides this face
      count_surfaces(counting, item, plane, camera_matrix(view));
      fill_face(program, item, p);
    }
  glDisable(GL_STENCIL_TEST);
  glStencilMask(0xFF);
}

}  // namespace turgor
