// What one picture shows: meshes with their colours, and words at places. Bodies of every model add their
// part; outputs.cpp draws it.
#pragma once

#include <deque>
#include <string>
#include <vector>

#include "turgor/sim/world.hpp"
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
  double length = 0;  // [m]; the longest is three times, the shortest a quarter of it
};

/// A body's surface, if it has one, with the tools on it as they are, and an arrow for the force on each,
/// with its newtons.
void add_body(const ShownSurface& surface, const std::vector<TriMesh>& tools, ArrowScale arrows,
              SkinColor color, const ColorScale* scale, PictureParts& parts);

/// The deformed surface with the quantity that colours it: displacement [m] or pressure [Pa].
TriMesh deformed_mesh(const ShownSurface& surface, SkinColor color);

/// Writes the labels where the camera sees their places.
void draw_labels(const std::vector<PictureLabel>& labels, const Camera& camera, Image& image);

}  // namespace turgor
