#include "app/outputs.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

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
  const double length = norm(path.skin.back() - path.skin.front());
  const Vec3d outward = -(grid.axes * path.into);
  const Vec3d direction = outward + Vec3d{0.15, 0, -0.35};
  return {cut.blade.name,
          cut.blade.name + " from near",
          frame_box(grown(box, std::max(0.01, 0.08 * length)), direction, {0, 0, 1}, aspect),
          {},
          {}};
}

Box world_box(const World& world) {
  constexpr double kFar = std::numeric_limits<double>::max();
  Box box{{kFar, kFar, kFar}, {-kFar, -kFar, -kFar}};
  for (const LatticeBody& body : world.lattice_bodies) {
    const BodyBox more = body_box(body.model);
    box = {min(box.low, more.low), max(box.high, more.high)};
  }
  for_each_touched(world, [&box](BodyId, const TouchedBody& body) {
    for (const Vec3 x : body.shown.rest) box = {min(box.low, Vec3d(x)), max(box.high, Vec3d(x))};
  });
  for (const ClothBody& body : world.cloth_bodies)
    for (std::size_t v = 0; v < std::size_t(body.model.count); v++)
      box = {min(box.low, Vec3d(body.state.x[v])), max(box.high, Vec3d(body.state.x[v]))};
  return box;
}

/// The side from which the first tool comes; none without tools.
std::optional<Vec3d> side_of_tools(const World& world) {
  const Box box = world_box(world);
  std::optional<Vec3d> side;
  for_each_touched(world, [&](BodyId, const TouchedBody& body) {
    if (!side && !body.shown.tools.empty())
      side = body.shown.tools[0].pose.position - (box.low + box.high) * 0.5;
  });
  return side;
}

SurfaceView view_of_bodies(const World& world, Vec3d outward, double aspect) {
  const Vec3d out = normalized(outward);
  const bool from_head = std::abs(out.z) > 0.8;  // then one sees more from the front
  const Vec3d direction = out + (from_head ? Vec3d{0.5, -1.1, 0} : Vec3d{0.45, 0, 0.2});
  const bool skin = !world.lattice_bodies.empty();
  return {skin ? "skin" : "body",
          skin ? "the skin" : "the body",
          frame_box(world_box(world), direction, {0, 0, 1}, aspect),
          true,
          {},
          {}};
}

/// A cut from near once more, in colours.
Status add_colored_view(const World& world, Outputs& outputs, const SurfaceView& view) {
  if (view.colored || outputs.scene->output.color == SkinColor::kNone) return Done{};
  const std::optional<Image> image = draw_bodies(world, outputs, view.camera, true);
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

Result<Outputs> make_outputs(const Exec& exec, const Scene& scene, const World& world, fs::path folder) {
  Outputs outputs;
  outputs.exec = &exec, outputs.scene = &scene, outputs.folder = std::move(folder);
  std::error_code error;
  for (const char* name : {"frames", "meshes", kVideoFolder})
    if (!fs::create_directory(outputs.folder / name, error))
      return Error{
          fmt::format("{}: cannot make the folder: {}", (outputs.folder / name).string(), error.message())};
  const double aspect = double(scene.output.width) / scene.output.height;
  Vec3d outward = side_of_tools(world).value_or(Vec3d{0, -1, 0});  // else the front of a patient
  std::vector<SurfaceView> cuts;
  for (const LatticeBody& body : world.lattice_bodies) {
    outputs.bodies.emplace_back();
    outputs.bodies.back().rest = lattice::make_state(body.model);
  }
  for (const Cut& cut : world.cuts) {
    const auto body = std::size_t(cut.body);
    const auto path =
        lattice::lay_blade(world.lattice_bodies[body].model, outputs.bodies[body].rest, cut.blade);
    if (!path) return path.error();
    if (cuts.empty()) outward = -(world.lattice_bodies[body].model.grid.axes * path->into);
    cuts.push_back(view_of_cut(world, cut, *path, aspect));
  }
  outputs.views.push_back(view_of_bodies(world, outward, aspect));
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

std::optional<Image> draw_bodies(const World& world, Outputs& outputs, const Camera& camera, bool colored) {
  const SkinColor color = colored ? outputs.scene->output.color : SkinColor::kNone;
  const ColorScale scale = color_scale(*outputs.scene, color);
  const ColorScale* used = color == SkinColor::kNone ? nullptr : &scale;
  PictureParts parts;
  add_skin(world, outputs, color, used, parts);
  add_touched(world, *outputs.scene, color, used, parts);
  add_clothes(world, color, used, parts);
  return draw_parts(parts, camera, outputs);
}

Status add_picture(Outputs& outputs, const std::string& file, const std::string& caption, const Image& image,
                   bool large) {
  if (const Status status = write_png(outputs.folder / file, image); !status) return status;
  outputs.facts.pictures.push_back({file, caption, large});
  return Done{};
}

Status add_snapshot(const World& world, Outputs& outputs) {
  for (SurfaceView& view : outputs.views) {
    std::optional<Image> image = draw_bodies(world, outputs, view.camera, view.colored);
    if (!image) continue;
    const std::string file = fmt::format("frames/{}-{:04}.png", view.name, world.frame);
    if (const Status status = write_png(outputs.folder / file, *image); !status) return status;
    if (view.first.width == 0) view.first = draw_bodies(world, outputs, view.camera, false).value_or(*image);
    view.last = std::move(*image);
  }
  if (!outputs.scene->output.meshes) return Done{};
  if (const Status status = write_skin_meshes(world, outputs); !status) return status;
  if (const Status status = write_touched_meshes(world, outputs); !status) return status;
  return write_cloth_meshes(world, outputs);
}

int video_interval(const Outputs& outputs) {
  if (!outputs.scene->output.video || !outputs.can_draw || !has_ffmpeg()) return 0;
  return std::max(1, int(std::lround(outputs.scene->frame_rate / kVideoRate)));
}

Status add_video_frame(const World& world, Outputs& outputs) {
  const bool colored = world.lattice_bodies.empty();
  const std::optional<Image> image = draw_bodies(world, outputs, outputs.views.back().camera, colored);
  if (!image) return Done{};
  const fs::path file = outputs.folder / kVideoFolder / fmt::format("{:06}.png", outputs.video_frames.size());
  outputs.video_frames.push_back(file);
  return write_png(file, *image);
}

Status finish_outputs(const World& world, Outputs& outputs) {
  if (const Status status = finish_touched_outputs(world, outputs); !status) return status;
  for (std::size_t v = outputs.views.size(); v-- > 0 && !shows_touch_alone(world);) {  // wounds first
    const SurfaceView& view = outputs.views[v];
    if (view.first.width == 0) continue;
    const Image pair =
        side_by_side({view.first, view.last}, {"before", "after " + seconds_text(time_of(world))});
    const Status status = add_picture(outputs, view.name + "-before-after.png",
                                      view.caption + ", before and after", pair, true);
    if (!status) return status;
    if (const Status colored = add_colored_view(world, outputs, view); !colored) return colored;
  }
  if (const Status status = finish_ct_outputs(world, outputs); !status) return status;
  if (outputs.scene->output.meshes) {
    const MeshSpace space = outputs.scene->output.mesh_space;
    if (const Status status = write_pvd(outputs.folder / "meshes.pvd", outputs.series, space); !status)
      return status;
    outputs.facts.files.push_back("meshes.pvd");
  }
  if (outputs.scene->output.obj)
    for (const auto write : {write_skin_objs, write_cloth_objs})
      if (const Status status = write(world, outputs); !status) return status;
  return finish_video(outputs);
}

}  // namespace turgor
