#include "turgor/pictures/outputs.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "turgor/sim/report/forces_csv.hpp"
#include "turgor/view/video.hpp"

namespace turgor {

namespace {

namespace fs = std::filesystem;

constexpr const char* kVideoFolder = ".video";
constexpr double kVideoRate = 20;  // pictures a second, of simulated and of shown time
Vec3d to_patient(const Grid& grid, Vec3d local) { return grid.origin + grid.axes * local; }

Box grown(Box box, double margin) {
  const Vec3d m{margin, margin, margin};
  return {box.low - m, box.high + m};
}

/// Looks at a cut from outside, a little from below, its line upright or lying as in the patient.
SurfaceView view_of_cut(const World& world, const Cut& cut, const lattice::BladePath& path, double aspect) {
  const Grid& grid = world.lattice_bodies[std::size_t(cut.body)].model.grid;
  Box box{to_patient(grid, path.skin.front()), to_patient(grid, path.skin.front())};
  for (const Vec3d p : path.skin)
    box = {min(box.low, to_patient(grid, p)), max(box.high, to_patient(grid, p))};
  const double length = norm(box.high - box.low);
  const Vec3d outward = -(grid.axes * mean_into(path));
  const Vec3d direction = outward + Vec3d{0.15, 0, -0.35};
  return {cut.blade.name,
          cut.blade.name + " from near",
          frame_box(grown(box, std::max(0.01, 0.08 * length)), direction, {0, 0, 1}, aspect),
          {},
          {}};
}

Box box_of(const ShownWorld& shown) {
  constexpr double kFar = std::numeric_limits<double>::max();
  Box box{{kFar, kFar, kFar}, {-kFar, -kFar, -kFar}};
  for (const ShownBody& body : shown.bodies)
    if (!body.rest.empty()) box = {min(box.low, body.box.low), max(box.high, body.box.high)};
  return box;
}

/// The side from which a tool comes to the first body that has one; none without tools.
std::optional<Vec3d> side_of_tools(const ShownWorld& shown) {
  const Box box = box_of(shown);
  for (const ShownBody& body : shown.bodies)
    for (const ShownTool& tool : shown.tools)
      if (tool.body == body.id) return tool.pose.position - (box.low + box.high) * 0.5;
  return {};
}

bool shows_skin(const ShownWorld& shown) {
  return std::any_of(shown.bodies.begin(), shown.bodies.end(),
                     [](const ShownBody& body) { return body.look == Look::kSkin; });
}

SurfaceView view_of_bodies(const ShownWorld& shown, Vec3d outward, double aspect) {
  const Vec3d out = normalized(outward);
  const bool from_head = std::abs(out.z) > 0.8;  // then one sees more from the front
  const Vec3d direction = out + (from_head ? Vec3d{0.5, -1.1, 0} : Vec3d{0.45, 0, 0.2});
  const bool skin = shows_skin(shown);
  return {skin ? "skin" : "body",
          skin ? "the skin" : "the body",
          frame_box(box_of(shown), direction, {0, 0, 1}, aspect),
          true,
          {},
          {}};
}

/// Nothing and a warning, once, when OpenGL is missing.
std::optional<Image> draw_world(const ShownWorld& shown, Outputs& outputs, const Camera& camera,
                                bool colored) {
  const SkinColor color = colored ? outputs.scene->output.color : SkinColor::kNone;
  const ColorScale scale = color_scale(*outputs.scene, color);
  PictureParts parts;
  add_world(shown, color, color == SkinColor::kNone ? nullptr : &scale, parts);
  return draw_parts(parts, camera, outputs);
}

/// A cut from near once more, in colours.
Status add_colored_view(const ShownWorld& shown, Outputs& outputs, const SurfaceView& view) {
  if (view.colored || outputs.scene->output.color == SkinColor::kNone) return Done{};
  const std::optional<Image> image = draw_world(shown, outputs, view.camera, true);
  if (!image) return Done{};
  return add_picture(outputs, view.name + "-colored.png", view.caption + ", in colours", *image, false);
}

/// Then the pictures under the largest forces say it all: in the end the tools are away.
bool shows_touch_alone(const World& world) {
  const bool all_touched = std::all_of(world.lattice_bodies.begin(), world.lattice_bodies.end(),
                                       [](const LatticeBody& body) { return !body.tool_indices.empty(); });
  return all_touched && world.cuts.empty() && world.cloth_bodies.empty();
}

std::string seconds_text(double seconds) { return fmt::format("{:.2f} s", seconds); }

Status finish_video(Outputs& outputs) {
  const AddTime time(outputs.facts.file_seconds);
  if (outputs.video_frames.size() > 1) {
    const Status written = write_video(outputs.video_frames, kVideoRate, outputs.folder / "video.mp4");
    if (written)
      outputs.facts.files.push_back("video.mp4");
    else
      outputs.facts.warnings.push_back("no video: " + written.error().message);
  }
  std::error_code ignored;
  fs::remove_all(outputs.folder / kVideoFolder, ignored);
  return Done{};
}

}  // namespace

Result<Outputs> make_outputs(const Exec& exec, const Scene& scene, const World& world,
                             const ShownWorld& shown, fs::path folder) {
  Outputs outputs;
  outputs.exec = &exec, outputs.scene = &scene, outputs.folder = std::move(folder);
  std::error_code error;
  for (const char* name : {"frames", "meshes", kVideoFolder})
    if (!fs::create_directory(outputs.folder / name, error))
      return Error{
          fmt::format("{}: cannot make the folder: {}", (outputs.folder / name).string(), error.message())};
  const double aspect = double(scene.output.width) / scene.output.height;
  Vec3d outward = side_of_tools(shown).value_or(Vec3d{0, -1, 0});  // else the front of a patient
  std::vector<SurfaceView> cuts;
  for (const LatticeBody& body : world.lattice_bodies)
    outputs.at_rest.push_back(lattice::make_state(body.model));
  for (const Cut& cut : world.cuts) {
    const auto body = std::size_t(cut.body);
    const auto path = lattice::lay_blade(world.lattice_bodies[body].model, outputs.at_rest[body], cut.blade);
    if (!path) return path.error();
    if (cuts.empty()) outward = -(world.lattice_bodies[body].model.grid.axes * mean_into(*path));
    cuts.push_back(view_of_cut(world, cut, *path, aspect));
  }
  outputs.views.push_back(view_of_bodies(shown, outward, aspect));
  std::move(cuts.begin(), cuts.end(), std::back_inserter(outputs.views));
  return outputs;
}

ColorScale color_scale(const Scene& scene, SkinColor color) {
  const bool stretch = color == SkinColor::kStretch, pressure = color == SkinColor::kPressure;
  std::pair<double, double> range = stretch ? std::pair(-0.2, 0.2) : std::pair(0.0, 0.01);
  if (pressure) range = {0, scene.sfem_bodies[0].material.young};
  if (scene.output.color == color) range = scene.output.color_range.value_or(range);
  constexpr float kFar =
      std::numeric_limits<float>::max();  // up to the next float, so that 0.01 m is not below 10 mm
  const float low = float(range.first), high = std::nextafter(float(range.second), kFar);
  if (stretch) return {low, high, "area strain of the skin [%]", 100};
  if (pressure) return {low, high, "contact pressure [kPa]", 1e-3f};
  return {low, high, "displacement [mm]", 1000};
}

std::optional<Image> draw_parts(const PictureParts& parts, const Camera& camera, Outputs& outputs) {
  if (!outputs.can_draw) return std::nullopt;
  const AddTime time(outputs.facts.drawing_seconds);
  const OutputScene& output = outputs.scene->output;
  Result<Image> image = draw_meshes(parts.parts, camera, output.width, output.height);
  if (image) {
    draw_labels(parts.labels, camera, *image);
    return std::move(*image);
  }
  outputs.can_draw = false;
  outputs.facts.warnings.push_back("no pictures of surfaces: " + image.error().message);
  return std::nullopt;
}

Status add_picture(Outputs& outputs, const std::string& file, const std::string& caption, const Image& image,
                   bool large) {
  const AddTime time(outputs.facts.file_seconds);
  if (const Status status = write_png(outputs.folder / file, image); !status) return status;
  outputs.facts.pictures.push_back({file, caption, large});
  return Done{};
}

Status add_snapshot(const ShownWorld& shown, Outputs& outputs) {
  for (SurfaceView& view : outputs.views) {
    std::optional<Image> image = draw_world(shown, outputs, view.camera, view.colored);
    if (!image) continue;
    const std::string file = fmt::format("frames/{}-{:04}.png", view.name, shown.frame);
    {
      const AddTime time(outputs.facts.file_seconds);
      if (const Status status = write_png(outputs.folder / file, *image); !status) return status;
    }
    if (view.first.width == 0) view.first = draw_world(shown, outputs, view.camera, false).value_or(*image);
    view.last = std::move(*image);
  }
  return outputs.scene->output.meshes ? write_meshes(shown, outputs) : Done{};
}

int video_interval(const Outputs& outputs) {
  if (!outputs.scene->output.video || !outputs.can_draw || !has_ffmpeg()) return 0;
  return std::max(1, int(std::lround(outputs.scene->frame_rate / kVideoRate)));
}

Status add_video_frame(const ShownWorld& shown, Outputs& outputs) {
  const std::optional<Image> image =
      draw_world(shown, outputs, outputs.views.back().camera, !shows_skin(shown));
  if (!image) return Done{};
  const fs::path file = outputs.folder / kVideoFolder / fmt::format("{:06}.png", outputs.video_frames.size());
  outputs.video_frames.push_back(file);
  const AddTime time(outputs.facts.file_seconds);
  return write_png(file, *image);
}

namespace {

/// Every view, before and at the end; wounds first.
Status add_before_after(const ShownWorld& shown, Outputs& outputs) {
  for (std::size_t v = outputs.views.size(); v-- > 0;) {
    const SurfaceView& view = outputs.views[v];
    if (view.first.width == 0) continue;
    const Image pair = side_by_side({view.first, view.last}, {"before", "after " + seconds_text(shown.time)});
    const Status status = add_picture(outputs, view.name + "-before-after.png",
                                      view.caption + ", before and after", pair, true);
    if (!status) return status;
    if (const Status colored = add_colored_view(shown, outputs, view); !colored) return colored;
  }
  return Done{};
}

Status finish_tables(const World& world, Outputs& outputs) {
  const AddTime time(outputs.facts.file_seconds);
  if (!world.tools.empty()) {
    if (const Status status = write_forces(outputs.folder / "forces.csv", world.tools); !status)
      return status;
    outputs.facts.files.push_back("forces.csv");
  }
  if (!outputs.scene->output.meshes) return Done{};
  outputs.facts.files.push_back("meshes.pvd");
  return write_pvd(outputs.folder / "meshes.pvd", outputs.series, outputs.scene->output.mesh_space);
}

}  // namespace

Status finish_outputs(const World& world, const ShownWorld& shown, const std::vector<Pressed>& pressed,
                      Outputs& outputs) {
  Status status = add_pressed_pictures(pressed, outputs);
  if (status && !shows_touch_alone(world)) status = add_before_after(shown, outputs);
  if (status) status = finish_ct_outputs(world, outputs);
  if (status) status = finish_tables(world, outputs);
  if (status && outputs.scene->output.obj) status = write_objs(shown, pressed, outputs);
  return status ? finish_video(outputs) : status;
}

}  // namespace turgor
