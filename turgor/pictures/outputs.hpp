// Outputs of a run besides its report: pictures, meshes, the deformed CT, a video. They are written snapshot
// by snapshot, in the same way during a simulation and a replay. Outputs never change the simulation.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/core/timing.hpp"
#include "turgor/io/mesh/mesh_files.hpp"
#include "turgor/io/mesh/surface_animation.hpp"
#include "turgor/io/mesh/vtkhdf.hpp"
#include "turgor/pictures/motion.hpp"
#include "turgor/pictures/picture_items.hpp"
#include "turgor/sim/pressed.hpp"
#include "turgor/sim/report/report.hpp"
#include "turgor/sim/scene/scene.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

/// A view for pictures: the whole body, or a close-up of a cut.
struct SurfaceView {
  std::string name;     // of its files
  std::string caption;  // "the skin", "midline from near"
  Camera camera;
  bool colored = false;      // by output.color; else natural colors of skin and wound
  bool before_after = true;  // pair of the first snapshot (natural colors) and the last
};

/// A video: a close-up for every cut; without cuts, or with cameras in the scene, one of the last view.
struct Film {
  std::string file;  // "video.mp4", or with the view's name if there are several
  std::size_t view = 0;
  std::vector<std::filesystem::path> frames;  // in a hidden folder
};

struct Outputs {
  const Exec* exec = nullptr;
  const Scene* scene = nullptr;
  std::filesystem::path folder;
  RunFacts facts;
  std::vector<SurfaceView> views;
  WorldSnapshot first;                         // first snapshot, if a view shows it beside the last
  std::vector<lattice::State> at_rest;         // undeformed lattices, for pictures of the initial state
  std::vector<PvdEntry> series;                // of meshes
  std::map<std::string, VtkHdfSeries> vtkhdf;  // by file
  SurfaceAnimation animation;                  // of the snapshots, for USD and glTF
  bool animation_ended = false;                // only glTF is requested, and cannot hold more
  std::vector<Film> films;                // empty unless the scene requests a video and ffmpeg is installed
  double video_begin = 0, video_end = 0;  // times of the first and the latest frame [s]
  Motion motion;                          // for the page
  std::string motion_text;                // of it, if the page has been made
  bool can_draw = true;                   // OpenGL works
  std::map<std::size_t, CtVolume> deformed_cts;  // by body, until their sections are drawn
};

/// Hidden folder for the frames of videos, in that of the outputs.
constexpr const char* kVideoFolder = ".video";

/// Adds the wall time of its lifetime to a sum [s].
class AddTime {
 public:
  explicit AddTime(double& sum) : sum_(sum) {}
  ~AddTime() { sum_ += timer_.seconds(); }
  AddTime(const AddTime&) = delete;
  AddTime& operator=(const AddTime&) = delete;

 private:
  double& sum_;
  Timer timer_;
};

/// Creates the cameras for the first snapshot, and the folders.
Result<Outputs> make_outputs(const Exec& exec, const Scene& scene, const World& world,
                             const WorldSnapshot& snapshot, std::filesystem::path folder);
/// views.cpp: the views, the whole scene first.
Result<std::vector<SurfaceView>> make_views(const Scene& scene, const World& world,
                                            const WorldSnapshot& snapshot,
                                            const std::vector<lattice::State>& at_rest);
/// views.cpp: camera of the first view that covers both snapshots.
Camera camera_of_both(const Outputs& outputs, const WorldSnapshot& first, const WorldSnapshot& last);
bool shows_skin(const WorldSnapshot& snapshot);
/// Adds the meshes of the current snapshot, and the snapshot to the 3D view of the page.
Status add_snapshot(const WorldSnapshot& snapshot, Outputs& outputs);
/// Draws the current snapshot, if the scene requests its pictures. If that fails, the outputs warn of it, and
/// nothing more is drawn.
void draw_frames(const WorldSnapshot& snapshot, Outputs& outputs);
/// True if a frame is due for the 3D view of the page or the video.
bool wants_moment(const World& world, const Outputs& outputs);
/// Adds the frame to the 3D view and to the videos; a failed drawing is handled as by draw_frames.
void take_moment(const WorldSnapshot& snapshot, Outputs& outputs);
/// Writes all files that need no drawing: tables, deformed CT, meshes, OBJ.
Status write_outputs(const World& world, const WorldSnapshot& snapshot, const std::vector<Pressed>& pressed,
                     Outputs& outputs);
/// Draws pairs before and after, bodies under the largest forces, sections, volume renderings, videos.
Status draw_outputs(const World& world, const WorldSnapshot& snapshot, const std::vector<Pressed>& pressed,
                    Outputs& outputs);

/// JSON of the page's 3D view, limited so that the page stays below 8 MB including its pictures.
std::string motion_of_page(Outputs& outputs);

/// True if whole bodies and colored pictures are drawn too: if the scene requests them, or the page has no 3D
/// view.
bool draws_all(const Outputs& outputs);

/// Draws the items; empty, with a single warning, if OpenGL is missing.
std::optional<Image> draw_items(const PictureItems& items, const Camera& camera, Outputs& outputs,
                                RenderQuality quality = RenderQuality::kFull);
/// Camera for pictures with a legend, which is beside the body and not over it.
Camera beside_legend(const Camera& camera, const Outputs& outputs);
/// Writes a picture and lists it in the report.
Status add_picture(Outputs& outputs, const std::string& file, const std::string& caption, const Image& image,
                   bool large);
/// The same color scale for every snapshot, so that pictures can be compared.
ColorScale color_scale(const Scene& scene, SkinColor color);

/// pressed_pictures.cpp: every body under the largest force of its tools.
Status add_pressed_pictures(const std::vector<Pressed>& pressed, Outputs& outputs);
/// mesh_outputs.cpp: surfaces for ParaView (one file per body and snapshot, or one per body, as the scene
/// requests), and as OBJ at the end. `most_glb_bytes`: largest .glb.
Status write_meshes(const WorldSnapshot& snapshot, Outputs& outputs,
                    std::uint64_t most_glb_bytes = kMostGlbBytes);
Status finish_meshes(Outputs& outputs);
Status write_objs(const WorldSnapshot& snapshot, const std::vector<Pressed>& pressed, Outputs& outputs);
/// mesh_outputs.cpp: surfaces of all snapshots in one file, as USD and glTF. If that fails, the outputs warn
/// of it.
void finish_animation(Outputs& outputs, std::uint64_t most_glb_bytes = kMostGlbBytes);
/// ct_outputs.cpp: the deformed CT and its fields as files; then its sections and volume renderings.
Status write_ct_outputs(const World& world, Outputs& outputs);
Status draw_ct_outputs(const World& world, Outputs& outputs);

}  // namespace turgor
