// Items of one picture: meshes with their colors, and labels at positions. All data comes from a
// WorldSnapshot; outputs.cpp draws them.
#pragma once

#include <deque>
#include <string>
#include <vector>

#include "turgor/sim/scene/scene.hpp"
#include "turgor/sim/snapshot.hpp"
#include "turgor/view/annotate.hpp"
#include "turgor/view/draw.hpp"

namespace turgor {

/// Natural colors.
constexpr Rgb kWallColor{166, 58, 50}, kToolColor{176, 190, 204}, kInsideColor{236, 214, 150},
    kThreadColor{38, 60, 130}, kObstacleColor{188, 180, 168};
/// Color of the section of a body that is cut away.
Rgb section_color(const BodySnapshot& body);
/// True if pictures show a film of water on the body: by the scene, else on organs of sfem and rhombus.
bool is_wet(const BodySnapshot& body, const LookScene& look);
/// The part of a body that is not drawn.
Cutaway cutaway_of(const BodySnapshot& body, const LookScene& look);
/// Color of a body by its look; of an organ by its name, or by its index among the bodies of its model.
Rgb natural_color(const BodySnapshot& body);

/// Text beside a position.
struct PictureLabel {
  Vec3d position;  // [m]
  std::string text;
};

struct PictureItems {
  std::deque<TriMesh> meshes;  // deques, because items point to them
  std::deque<std::vector<Rgb>> colors;
  std::vector<RenderItem> items;
  std::vector<PictureLabel> labels;
  std::vector<NameRow> names;  // of bodies and inclusions, by color

  const TriMesh& add(TriMesh mesh, Rgb color, const ColorScale* scale = nullptr) {
    meshes.push_back(std::move(mesh));
    items.push_back({&meshes.back(), color, scale, nullptr});
    return meshes.back();
  }
};

/// Length scale of force arrows.
struct ArrowScale {
  double force = 1;  // force of an arrow of length `length` [N]
  double length =
      0;  // [m]; the longest arrow has kLongestArrow times this length, the shortest a quarter of it
};
constexpr double kLongestArrow = 1.5;

/// Quantity at every vertex that a color shows: displacement [m], stretches [1] or pressure [Pa]. Empty if
/// the body does not have it.
std::vector<float> shown_values(const BodySnapshot& body, SkinColor color);
/// A body's surface with its normals: the vertices and triangles of the snapshot, for files.
TriMesh surface_mesh(const BodySnapshot& body);
/// The same for pictures: the smooth surface if the body has one.
TriMesh shown_mesh(const BodySnapshot& body);
/// Walls of wounds with a vertex color for each layer of tissue.
struct ColoredWalls {
  TriMesh mesh;  // empty: no layer has a color
  std::vector<Rgb> colors;
};
ColoredWalls colored_walls(const BodySnapshot& body);
/// A tool's surface at its current pose.
TriMesh posed_mesh(const ToolSnapshot& tool);

/// A surface in its natural look, or colored by the scale if the body has the quantity.
void add_body(const BodySnapshot& body, SkinColor color, const ColorScale* scale, PictureItems& items,
              const LookScene& look = {});
/// A tool, and an arrow with the force on it in newtons, placed so that the eye [m] sees it.
void add_tool(const ToolSnapshot& tool, ArrowScale arrows, Vec3d eye, PictureItems& items);
/// Arrows of the forces between bodies, seen through the tissue, with names and newtons.
void add_organ_forces(const WorldSnapshot& snapshot, PictureItems& items);
/// All bodies, their first `tools` tools, and obstacles under cloth.
void add_world(const WorldSnapshot& snapshot, SkinColor color, const ColorScale* scale, Vec3d eye,
               PictureItems& items, const LookScene& look = {}, std::size_t tools = std::size_t(-1));

/// Names for a legend: none unless at least two colors have names.
std::vector<NameRow> shown_names(const PictureItems& items);
/// Draws the labels at positions that the camera sees.
void draw_labels(const std::vector<PictureLabel>& labels, const Camera& camera, Image& image);

}  // namespace turgor
