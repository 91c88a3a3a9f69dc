// What a run leaves behind besides its report: pictures, meshes, the deformed CT, a video. Filled snapshot by
// snapshot, the same way while simulating and when a recording is drawn again. It reads, and changes nothing
// of what is simulated.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/core/timing.hpp"
#include "turgor/io/mesh/mesh_files.hpp"
#include "turgor/io/mesh/vtkhdf.hpp"
#include "turgor/pictures/motion.hpp"
#include "turgor/pictures/picture_parts.hpp"
#include "turgor/sim/pressed.hpp"
#include "turgor/sim/report/report.hpp"
#include "turgor/sim/scene/scene.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

/// From where pictures are drawn: the whole body, or one cut from near.
struct SurfaceView {
  std::string name;     // of its files
  std::string caption;  // "the skin", "midline from near"
  Camera camera;
  bool colored = false;      // by output.color; else skin and wound as one sees them
  bool before_after = true;  // the first snapshot, as one sees it, beside the last
};

/// A video: one from near for every cut; without cuts, or where the scene has cameras, one of the last view.
struct Film {
  std::string file;  // "video.mp4", or with the view's name where there are several
  std::size_t view = 0;
  std::vector<std::filesystem::path> frames;  // in a hidden folder
};

struct Outputs {
  const Exec* exec = nullptr;
  const Scene* scene = nullptr;
  std::filesystem::path folder;
  RunFacts facts;
  std::vector<SurfaceView> views;
  WorldSnapshot first;                         // snapshot, where a view wants it beside the last
  std::vector<lattice::State> at_rest;         // lattices as in the CT, for pictures of before
  std::vector<PvdEntry> series;                // of meshes
  std::map<std::string, VtkHdfSeries> vtkhdf;  // by file
  std::vector<Film> films;                     // none, unless the scene asks for a video and ffmpeg is there
  double video_begin = 0, video_end = 0;       // when their first and their latest frame were [s]
  Motion motion;                               // for the page
  bool can_draw = true;                        // OpenGL works
};

/// Adds the wall time of its life to a sum [s].
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

/// Cameras for the world at its first snapshot, and the folders.
Result<Outputs> make_outputs(const Exec& exec, const Scene& scene, const World& world,
                             const WorldSnapshot& snapshot, std::filesystem::path folder);
/// views.cpp: from where it is seen; the whole first.
Result<std::vector<SurfaceView>> make_views(const Scene& scene, const World& world,
                                            const WorldSnapshot& snapshot,
                                            const std::vector<lattice::State>& at_rest);
/// views.cpp: the camera of the first view, around all that these two moments show.
Camera camera_of_both(const Outputs& outputs, const WorldSnapshot& first, const WorldSnapshot& last);
bool shows_skin(const WorldSnapshot& snapshot);
/// Pictures and meshes of the world now.
Status add_snapshot(const WorldSnapshot& snapshot, Outputs& outputs);
/// Is now a moment for the 3D view of the page, and for the video if there is one?
bool wants_moment(const World& world, const Outputs& outputs);
Status take_moment(const WorldSnapshot& snapshot, Outputs& outputs);
/// Before and after, bodies under the largest forces, sections, volume rendering, deformed CT, OBJ, video.
Status finish_outputs(const World& world, const WorldSnapshot& snapshot, const std::vector<Pressed>& pressed,
                      Outputs& outputs);

/// What the page shows in three dimensions, so that it stays below 8 MB with its pictures.
std::string motion_of_page(Outputs& outputs);

/// Also bodies as a whole and in colours: where the scene asks for them, or the page shows nothing in three
/// dimensions.
bool draws_all(const Outputs& outputs);

/// Draws what was put together; nothing and a warning, once, when OpenGL is missing.
std::optional<Image> draw_parts(const PictureParts& parts, const Camera& camera, Outputs& outputs,
                                MeshCare care = MeshCare::kFull);
/// A camera for pictures with a legend, which stands beside the body and not over it.
Camera beside_legend(const Camera& camera, const Outputs& outputs);
/// Writes a picture and lists it in the report.
Status add_picture(Outputs& outputs, const std::string& file, const std::string& caption, const Image& image,
                   bool large);
/// The same colours at every snapshot, so that pictures can be compared.
ColorScale color_scale(const Scene& scene, SkinColor color);

/// pressed_pictures.cpp: every body under the largest force of its tools.
Status add_pressed_pictures(const std::vector<Pressed>& pressed, Outputs& outputs);
/// mesh_outputs.cpp: surfaces for ParaView, one file a body and snapshot or a body alone, as the scene asks,
/// and as OBJ at the end.
Status write_meshes(const WorldSnapshot& snapshot, Outputs& outputs);
Status finish_meshes(Outputs& outputs);
Status write_objs(const WorldSnapshot& snapshot, const std::vector<Pressed>& pressed, Outputs& outputs);
/// ct_outputs.cpp: the CT as it would be scanned now, in sections, volume rendering and files.
Status finish_ct_outputs(const World& world, Outputs& outputs);

}  // namespace turgor
