// What one picture shows: meshes with their colours, and words at places. Everything comes from a ShownWorld;
// outputs.cpp draws it.
#pragma once

#include <deque>
#include <string>
#include <vector>

#include "turgor/sim/scene/scene.hpp"
#include "turgor/sim/snapshot.hpp"
#include "turgor/view/draw.hpp"

namespace turgor {

/// Words beside a place.
struct PictureLabel {
  Vec3d place;  // [m]
  std::string text;
};

struct PictureParts {
  std::deque<TriMesh> meshes;  // a deque: parts point at them
  std::vector<MeshPart> parts;
  std::vector<PictureLabel> labels;

  const TriMesh& add(TriMesh mesh, Rgb color, const ColorScale* scale = nullptr) {
    meshes.push_back(std::move(mesh));
    parts.push_back({&meshes.back(), color, scale, nullptr});
    return meshes.back();
  }
};

/// How long the arrows of forces are.
struct ArrowScale {
  double force = 1;   // an arrow of `length` is this many newtons [N]
  double length = 0;  // [m]; the longest is kLongestArrow times, the shortest a quarter of it
};
constexpr double kLongestArrow = 1.5;

/// The quantity at every vertex that a colour shows: displacement [m], stretch [1] or pressure [Pa]. Empty:
/// the body knows none.
std::vector<float> shown_values(const BodySnapshot& body, SkinColor color);
/// A body's surface with its normals.
TriMesh shown_mesh(const BodySnapshot& body);
/// A tool's surface where it is.
TriMesh placed_mesh(const ToolSnapshot& tool);

/// A surface as its look is, or coloured by the scale where the body knows the quantity.
void add_body(const BodySnapshot& body, SkinColor color, const ColorScale* scale, PictureParts& parts);
/// A tool, and an arrow for the force on it, with its newtons, where it is not hidden from the eye [m].
void add_tool(const ToolSnapshot& tool, ArrowScale arrows, Vec3d eye, PictureParts& parts);
/// All bodies, their tools, and what cloth lies on.
void add_world(const WorldSnapshot& snapshot, SkinColor color, const ColorScale* scale, Vec3d eye,
               PictureParts& parts);

/// Writes the labels where the camera sees their places.
void draw_labels(const std::vector<PictureLabel>& labels, const Camera& camera, Image& image);

}  // namespace turgor
