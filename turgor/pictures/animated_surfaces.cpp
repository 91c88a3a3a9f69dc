#include "turgor/pictures/animated_surfaces.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "turgor/pictures/picture_items.hpp"

namespace turgor {

namespace {

constexpr float kInsideOpacity = 0.4f;

SurfaceLook surface_look(Rgb color, float opacity = 1, bool two_sided = false) {
  return {linear_color(color), opacity, two_sided};
}

/// Surface of that name. A new one is empty at all earlier times.
AnimatedSurface& surface_of(const std::string& name, const SurfaceLook& look, SurfaceAnimation& animation) {
  const auto found = std::find_if(animation.surfaces.begin(), animation.surfaces.end(),
                                  [&](const AnimatedSurface& surface) { return surface.name == name; });
  if (found != animation.surfaces.end()) return *found;
  AnimatedSurface surface{.name = name, .look = look, .triangulations = {}, .colors = {}, .samples = {}};
  for (std::size_t s = 0; s < animation.times.size(); s++) add_sample({}, surface);
  animation.surfaces.push_back(std::move(surface));
  return animation.surfaces.back();
}

/// Triangles of a mesh from `begin` on, with their vertices only.
TriMesh rest_of(const TriMesh& mesh, std::size_t begin) {
  TriMesh out;
  std::vector<int> index(mesh.vertices.size(), -1);
  for (std::size_t t = begin; t < mesh.triangles.size(); t++) {
    Int3 triangle = mesh.triangles[t];
    for (int corner = 0; corner < 3; corner++) {
      const auto vertex = std::size_t(triangle[corner]);
      if (index[vertex] < 0) {
        index[vertex] = int(out.vertices.size());
        out.vertices.push_back(mesh.vertices[vertex]);
        if (!mesh.normals.empty()) out.normals.push_back(mesh.normals[vertex]);
      }
      triangle[corner] = index[vertex];
    }
    out.triangles.push_back(triangle);
  }
  return out;
}

void add_body_surfaces(const BodySnapshot& body, SurfaceAnimation& animation) {
  TriMesh surface = surface_mesh(body);
  const std::size_t walls = std::min(body.wall_begin, surface.triangles.size());
  const bool two_sided = body.look == Look::kCloth;
  AnimatedSurface& wound = surface_of(body.name + " wound", surface_look(kWallColor), animation);
  if (ColoredWalls colored = colored_walls(body); colored.mesh.triangles.empty()) {
    add_sample(rest_of(surface, walls), wound);
  } else {
    std::vector<Vec3> colors;
    for (const Rgb color : colored.colors) colors.push_back(linear_color(color));
    add_sample(std::move(colored.mesh), wound, std::move(colors));
  }
  surface.triangles.resize(walls);
  add_sample(std::move(surface),
             surface_of(body.name, surface_look(natural_color(body), 1, two_sided), animation));
  add_sample(body.inside,
             surface_of(body.name + " inside", surface_look(kInsideColor, kInsideOpacity), animation));
}

void add_meshes(const std::vector<TriMesh>& meshes, const std::string& name, Rgb color,
                SurfaceAnimation& animation) {
  for (std::size_t m = 0; m < meshes.size(); m++)
    add_sample(meshes[m], surface_of(fmt::format("{} {}", name, m + 1), surface_look(color), animation));
}

/// Name of a tool's surface. A body may have the name of the tool.
std::string surface_name(const ToolSnapshot& tool, const WorldSnapshot& snapshot) {
  const bool is_taken = std::any_of(snapshot.bodies.begin(), snapshot.bodies.end(),
                                    [&](const BodySnapshot& body) { return body.name == tool.name; });
  return is_taken ? tool.name + " tool" : tool.name;
}

}  // namespace

void add_surfaces(const WorldSnapshot& snapshot, SurfaceAnimation& animation) {
  if (!animation.times.empty() && animation.times.back() >= snapshot.time) return;
  for (const BodySnapshot& body : snapshot.bodies) add_body_surfaces(body, animation);
  for (const ToolSnapshot& tool : snapshot.tools)
    add_sample(posed_mesh(tool),
               surface_of(surface_name(tool, snapshot), surface_look(kToolColor), animation));
  add_meshes(snapshot.threads, "thread", kThreadColor, animation);
  add_meshes(snapshot.obstacles, "obstacle", kObstacleColor, animation);
  animation.times.push_back(snapshot.time);
  // a surface that is missing is empty
  for (AnimatedSurface& surface : animation.surfaces)
    if (surface.samples.size() < animation.times.size()) add_sample({}, surface);
}

void remove_empty_surfaces(SurfaceAnimation& animation) {
  std::erase_if(animation.surfaces, [](const AnimatedSurface& surface) {
    return std::all_of(surface.triangulations.begin(), surface.triangulations.end(),
                       [](const std::vector<Int3>& triangles) { return triangles.empty(); });
  });
}

}  // namespace turgor
