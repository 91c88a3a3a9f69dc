#include "turgor/contact/facing_point.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/core/sort_unique.hpp"

namespace turgor::contact {

namespace {

constexpr double kFacing = -0.4;  // cosine between the normals of surfaces that can touch
constexpr double kFacingFace =
    -0.9;                            // the same of one triangle at a sharp corner: less than 26 degrees apart
constexpr double kAtEdge = 1e-3;     // of an edge: distance below which the normal is that of a triangle
constexpr double kBesideEdge = 0.1;  // of an edge: largest depth below a triangle beside the nearest one

/// Normals of a vertex.
struct VertexNormals {
  const SearchedSurface& surface;
  int vertex = 0;
  Vec3d mean;  // unit
};

/// Normal of the triangle, of length twice its area [m²].
Vec3d area_normal(const PairSurface& surface, Int3 t) {
  const Vec3d a = surface.x[std::size_t(t.x)];
  return cross(surface.x[std::size_t(t.y)] - a, surface.x[std::size_t(t.z)] - a);
}

/// Angle of a triangle at one of its corners [rad].
double angle_at(const PairSurface& surface, Int3 t, int corner) {
  const Vec3d a = surface.x[std::size_t(t[corner])];
  const Vec3d ab = surface.x[std::size_t(t[(corner + 1) % 3])] - a;
  const Vec3d ac = surface.x[std::size_t(t[(corner + 2) % 3])] - a;
  return std::atan2(norm(cross(ab, ac)), dot(ab, ac));
}

/// True if surfaces of these normals can touch: by the mean normal of the vertex, or by one of its triangles.
bool can_touch(const VertexNormals& own, Vec3d normal) {
  if (dot(own.mean, normal) < kFacing) return true;
  const auto v = std::size_t(own.vertex);
  for (std::size_t n = own.surface.around[v]; n < own.surface.around[v + 1]; n++)
    if (dot(own.surface.faces[std::size_t(own.surface.triangles[n])], normal) < kFacingFace) return true;
  return false;
}

/// True if a triangle has all corners that carry a point on an edge or a corner.
bool carries(Int3 t, Int3 of, Vec3d weights) {
  for (int corner = 0; corner < 3; corner++)
    if (weights[corner] > 0 && t.x != of[corner] && t.y != of[corner] && t.z != of[corner]) return false;
  return true;
}

/// Normal of the triangle at a surface point that faces a direction most. A point on an edge or a corner is
/// in several triangles.
Vec3d facing_normal(const SearchedSurface& other, const TrianglePoint& point, Vec3d direction) {
  const Int3 t = other.surface.triangles[std::size_t(point.triangle)];
  const Vec3d w = point.weights;
  Vec3d best = other.faces[std::size_t(point.triangle)];
  if (w.x > 0 && w.y > 0 && w.z > 0) return best;
  const auto v = std::size_t(w.x > 0 ? t.x : w.y > 0 ? t.y : t.z);
  for (std::size_t n = other.around[v]; n < other.around[v + 1]; n++) {
    const int neighbor = other.triangles[n];
    const Vec3d normal = other.faces[std::size_t(neighbor)];
    if (carries(other.surface.triangles[std::size_t(neighbor)], t, w) &&
        dot(normal, direction) < dot(best, direction))
      best = normal;
  }
  return best;
}

/// The nearest point of the surface, with its signed height and its normal.
FacingPoint nearest(const SearchedSurface& other, Vec3d x, const VertexNormals& own) {
  FacingPoint near{.point = nearest_point(other.tree, x), .normal = {}};
  const Int3 t = other.surface.triangles[std::size_t(near.point.triangle)];
  // signed height, by the mean normal of the vertices where the point is on an edge
  const Vec3d w = near.point.weights;
  Vec3d mean = other.faces[std::size_t(near.point.triangle)];
  if (!(w.x > 0 && w.y > 0 && w.z > 0)) {
    mean = {};
    for (int corner = 0; corner < 3; corner++)
      mean += normalized(other.normals[std::size_t(t[corner])]) * w[corner];
  }
  const Vec3d apart = x - near.point.position;
  const double sign = dot(apart, mean) < 0 ? -1 : 1;
  near.height = sign * near.point.distance;
  // normal along the line between the points where they are apart
  const Vec3d facing = facing_normal(other, near.point, own.mean);
  near.normal = near.point.distance > kAtEdge * other.edge ? apart * (sign / near.point.distance) : facing;
  near.faces = can_touch(own, near.normal) && can_touch(own, facing);
  return near;
}

/// The nearest point on triangles that face the vertex, within a distance. It does not face if there is none
/// above or below it.
FacingPoint nearest_facing(const SearchedSurface& other, Vec3d x, const VertexNormals& own, double within) {
  FacingPoint near;
  const auto& vertices = other.tree.vertices;
  nearest_item(other.tree.boxes, x, within * within, [&](int item, double best) {
    if (!can_touch(own, other.faces[std::size_t(item)])) return best;
    const auto [a, b, c] = other.tree.triangles[std::size_t(item)];
    TrianglePoint at =
        nearest_on_triangle(x, vertices[std::size_t(a)], vertices[std::size_t(b)], vertices[std::size_t(c)]);
    const double squared = at.distance * at.distance;
    if (squared < best) near.point = at, near.point.triangle = item;
    return squared;
  });
  if (near.point.triangle < 0) return near;
  near.normal = other.faces[std::size_t(near.point.triangle)];
  const Vec3d apart = x - near.point.position;
  near.height = dot(apart, near.normal);
  near.faces = norm(apart - near.normal * near.height) <= kAtEdge * other.edge;
  return near;
}

}  // namespace

SearchedSurface searched_surface(const PairSurface& surface) {
  SearchedSurface s{.surface = surface,
                    .vertices = {},
                    .normals = {},
                    .around = {},
                    .triangles = {},
                    .faces = {},
                    .tree = {}};
  // vertices and their normals
  s.normals.resize(surface.x.size()), s.around.resize(surface.x.size() + 1);
  for (const Int3 t : surface.triangles) {
    const Vec3d normal = normalized(area_normal(surface, t));
    s.faces.push_back(normal);
    for (int corner = 0; corner < 3; corner++) {
      s.normals[std::size_t(t[corner])] += normal * angle_at(surface, t, corner);
      s.around[std::size_t(t[corner]) + 1]++;
      s.vertices.push_back(t[corner]);
    }
  }
  sort_unique(s.vertices);
  // triangles around each vertex
  for (std::size_t v = 0; v < surface.x.size(); v++) s.around[v + 1] += s.around[v];
  std::vector<std::size_t> next(s.around.begin(), s.around.end() - 1);
  s.triangles.resize(3 * surface.triangles.size());
  for (std::size_t t = 0; t < surface.triangles.size(); t++)
    for (int corner = 0; corner < 3; corner++)
      s.triangles[next[std::size_t(surface.triangles[t][corner])]++] = int(t);
  s.tree = build_triangle_tree({surface.x.begin(), surface.x.end()},
                               {surface.triangles.begin(), surface.triangles.end()});
  s.edge = mean_edge(surface.x, surface.triangles);
  return s;
}

FacingPoint facing_point(const SearchedSurface& other, Vec3d x, const SearchedSurface& own, int vertex) {
  const VertexNormals normals{own, vertex, normalized(own.normals[std::size_t(vertex)])};
  const FacingPoint near = nearest(other, x, normals);
  if (near.faces || near.height > kAtEdge * other.edge) return near;
  const double within = kBesideEdge * std::min(own.edge, other.edge);
  if (near.point.distance > within) return near;
  const FacingPoint beside = nearest_facing(other, x, normals, within);
  return beside.faces ? beside : near;
}

}  // namespace turgor::contact
