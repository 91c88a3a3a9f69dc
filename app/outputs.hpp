// What a run leaves behind besides its report: pictures, meshes, the deformed CT, a video. Filled snapshot by
// snapshot, the same way while simulating and when a recording is drawn again.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/io/mesh_files.hpp"
#include "turgor/models/lattice/surface.hpp"
#include "turgor/pictures/picture_parts.hpp"
#include "turgor/sim/report/report.hpp"
#include "turgor/sim/scene/scene.hpp"
#include "turgor/sim/world.hpp"
#include "turgor/view/draw.hpp"

namespace turgor {

/// A picture that is drawn at every snapshot: the whole body, or one cut from near.
struct SurfaceView {
  std::string name;     // of its files
  std::string caption;  // "the skin", "midline from near"
  Camera camera;
  bool colored = false;  // by output.color; else skin and wound as one sees them
  Image first, last;     // the first snapshot, as one sees it, and the latest
};

/// The drawn surface of a body, made anew when it was cut further.
struct DrawnBody {
  lattice::BodySurface surface;
  std::size_t cut_edges = 0;
  bool made = false;
  lattice::State rest;  // as in the CT, for pictures of before
};

struct Outputs {
  const Exec* exec = nullptr;
  const Scene* scene = nullptr;
  std::filesystem::path folder;
  RunFacts facts;
  std::vector<SurfaceView> views;
  std::vector<DrawnBody> bodies;
  std::vector<PvdEntry> series;                     // of meshes
  std::vector<std::filesystem::path> video_frames;  // in a hidden folder
  bool can_draw = true;                             // OpenGL works
};

/// Cameras for the world at its first snapshot, and the folders.
Result<Outputs> make_outputs(const Exec& exec, const Scene& scene, const World& world,
                             std::filesystem::path folder);
/// Pictures and meshes of the world now.
Status add_snapshot(const World& world, Outputs& outputs);
/// Every how many frames the video takes a picture; 0 = there is none.
int video_interval(const Outputs& outputs);
Status add_video_frame(const World& world, Outputs& outputs);
/// Before and after, sections, volume rendering, deformed CT, OBJ, video.
Status finish_outputs(const World& world, Outputs& outputs);

/// Draws all bodies; nothing and a warning, once, when OpenGL is missing.
std::optional<Image> draw_bodies(const World& world, Outputs& outputs, const Camera& camera, bool colored);
/// Writes a picture and lists it in the report.
Status add_picture(Outputs& outputs, const std::string& file, const std::string& caption, const Image& image,
                   bool large);

/// Draws what was put together; nothing and a warning, once, when OpenGL is missing.
std::optional<Image> draw_parts(const PictureParts& parts, const Camera& camera, Outputs& outputs);
/// The same colours at every snapshot, so that pictures can be compared.
ColorScale color_scale(const Scene& scene, SkinColor color);

/// outputs_skin.cpp: lattice bodies.
void add_skin(const World& world, Outputs& outputs, SkinColor color, const ColorScale* scale,
              PictureParts& parts);
Status write_skin_meshes(const World& world, Outputs& outputs);
Status write_skin_objs(const World& world, Outputs& outputs);

/// outputs_touched.cpp: bodies that tools touch. Puts their surfaces as they lie now into SfemBody::shown.
void show_touched(const Exec& exec, World& world);
void add_touched(const World& world, const Scene& scene, SkinColor color, const ColorScale* scale,
                 PictureParts& parts);
Status write_touched_meshes(const World& world, Outputs& outputs);
/// Pictures under the largest force, their surface as OBJ, forces.csv.
Status finish_touched_outputs(const World& world, Outputs& outputs);

/// outputs_cloth.cpp: cloth, and what it lies on.
void add_clothes(const World& world, SkinColor color, const ColorScale* scale, PictureParts& parts);
Status write_cloth_meshes(const World& world, Outputs& outputs);
Status write_cloth_objs(const World& world, Outputs& outputs);

/// outputs_ct.cpp: the CT as it would be scanned now, in sections, volume rendering and files.
Status finish_ct_outputs(const World& world, Outputs& outputs);

}  // namespace turgor
