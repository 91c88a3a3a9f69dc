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

constexpr double kVideoRate = 20, kMotionRate = 10, kCutRate = 3;  // frames per second of simulated time

/// Empty, with a single warning, if OpenGL is missing.
std::optional<Image> draw_world(const WorldSnapshot& snapshot, Outputs& outputs, const Camera& camera,
                                bool colored, RenderQuality quality = RenderQuality::kFull) {
  const SkinColor color = colored ? outputs.scene->output.color : SkinColor::kNone;
  const ColorScale scale = color_scale(*outputs.scene, color);
  PictureItems items;
  add_world(snapshot, color, color == SkinColor::kNone ? nullptr : &scale, camera.eye, items,
            outputs.scene->look);
  return draw_items(items, camera, outputs, quality);
}

/// Adds a close-up of a cut in colors, unless the page shows it in 3D.
Status add_colored_view(const WorldSnapshot& snapshot, Outputs& outputs, const SurfaceView& view) {
  const SkinColor color = outputs.scene->output.color;
  if (view.colored || color == SkinColor::kNone) return Done{};
  if (color == SkinColor::kDisplacement && !draws_all(outputs)) return Done{};
  const std::optional<Image> image = draw_world(snapshot, outputs, beside_legend(view.camera, outputs), true);
  if (!image) return Done{};
  return add_picture(outputs, view.name + "-colored.png", view.caption + ", in colors", *image, false);
}

/// True if the wound of a scene is an excision, or is closed by stitches.
bool is_closed_wound(const Scene& scene, std::size_t wound) {
  const bool is_sutured =
      std::any_of(scene.sutures.begin(), scene.sutures.end(),
                  [wound](const SutureScene& suture) { return suture.incision == int(wound); });
  return is_sutured || scene.incisions[wound].blade.excision.has_value();
}

/// Adds a close-up with the stretch of the skin around an excised or sutured wound. Those of the cuts come
/// second in the list of views.
Status add_stretch_view(const WorldSnapshot& snapshot, Outputs& outputs, std::size_t view) {
  const Scene& scene = *outputs.scene;
  if (view < 1 || view > scene.incisions.size() || !is_closed_wound(scene, view - 1)) return Done{};
  const SurfaceView& wound = outputs.views[view];
  const Camera camera = beside_legend(wound.camera, outputs);
  const ColorScale scale = color_scale(scene, SkinColor::kPrincipalStretch);
  PictureItems items;
  add_world(snapshot, SkinColor::kPrincipalStretch, &scale, camera.eye, items);
  const std::optional<Image> image = draw_items(items, camera, outputs);
  if (!image) return Done{};
  return add_picture(outputs, wound.name + "-stretch.png", wound.caption + ", largest stretch of the skin",
                     *image, false);
}

/// True if pictures under the largest forces suffice, because the tools are retracted at the end.
bool shows_touch_alone(const World& world) {
  const bool all_touched = std::all_of(world.lattice_bodies.begin(), world.lattice_bodies.end(),
                                       [](const LatticeBody& body) { return !body.tool_indices.empty(); });
  return all_touched && world.cuts.empty() && world.cloth_bodies.empty();
}

std::string seconds_text(double seconds) { return fmt::format("{:.2f} s", seconds); }

/// Draws nothing more, and warns of it. A run goes on without its pictures.
void stop_drawing(Outputs& outputs, const Error& reason) {
  outputs.can_draw = false;
  outputs.facts.warnings.push_back("no further pictures: " + reason.message);
}

/// The close-up views, one for every cut, come second.
std::vector<Film> make_films(const Outputs& outputs, std::size_t cuts) {
  std::vector<Film> films;
  if (!outputs.scene->output.video || !has_ffmpeg()) return films;
  for (std::size_t view = 1; view <= cuts; view++) films.push_back({.file = {}, .view = view, .frames = {}});
  if (cuts == 0 || outputs.views.size() > cuts + 1)
    films.push_back({.file = {}, .view = outputs.views.size() - 1, .frames = {}});
  for (Film& film : films)
    film.file = films.size() == 1 ? "video.mp4" : fmt::format("video-{}.mp4", outputs.views[film.view].name);
  return films;
}

void film_moment(const WorldSnapshot& snapshot, Film& film, Outputs& outputs) {
  const RenderQuality quality =
      outputs.scene->output.video_full ? RenderQuality::kFull : RenderQuality::kQuick;
  const std::optional<Image> image =
      draw_world(snapshot, outputs, outputs.views[film.view].camera, !shows_skin(snapshot), quality);
  if (!image) return;
  const fs::path file =
      outputs.folder / kVideoFolder / fmt::format("{}-{:06}.png", film.view, film.frames.size());
  const AddTime time(outputs.facts.file_seconds);
  if (const Status written = write_png(file, *image); !written) return stop_drawing(outputs, written.error());
  film.frames.push_back(file);
}

Status finish_films(Outputs& outputs) {
  const AddTime time(outputs.facts.file_seconds);
  for (const Film& film : outputs.films) {
    if (film.frames.size() < 2) continue;
    const double seconds = (outputs.video_end - outputs.video_begin) / outputs.scene->output.video_speed;
    const double rate = double(film.frames.size() - 1) / seconds;
    const Status written = write_video(film.frames, rate, outputs.folder / film.file);
    if (written)
      outputs.facts.files.push_back(film.file);
    else
      outputs.facts.warnings.push_back("no video: " + written.error().message);
  }
  std::error_code ignored;
  fs::remove_all(outputs.folder / kVideoFolder, ignored);
  return Done{};
}

/// Command for the pictures that were not drawn.
std::string more_pictures(const OutputScene& output) {
  return output.recording ? "turgor run --replay recording.h5 --set output.pictures=all"
                          : "the same run with --set output.pictures=all";
}

}  // namespace

bool shows_skin(const WorldSnapshot& snapshot) {
  return std::any_of(snapshot.bodies.begin(), snapshot.bodies.end(),
                     [](const BodySnapshot& body) { return body.look == Look::kSkin; });
}

Result<Outputs> make_outputs(const Exec& exec, const Scene& scene, const World& world,
                             const WorldSnapshot& snapshot, fs::path folder) {
  Outputs outputs;
  outputs.exec = &exec, outputs.scene = &scene, outputs.folder = std::move(folder);
  std::error_code error;
  std::vector<const char*> folders{"meshes", kVideoFolder};
  if (scene.output.frames) folders.push_back("frames");
  if (!snapshot.tools.empty()) folders.insert(folders.end(), {"meshes/tools", "meshes/forces"});
  for (const char* name : folders)
    if (!fs::create_directory(outputs.folder / name, error))
      return Error{
          fmt::format("{}: cannot create the folder: {}", (outputs.folder / name).string(), error.message())};
  for (const LatticeBody& body : world.lattice_bodies)
    outputs.at_rest.push_back(lattice::make_state(body.model));
  Result<std::vector<SurfaceView>> views = make_views(scene, world, snapshot, outputs.at_rest);
  if (!views) return views.error();
  outputs.views = std::move(*views);
  const std::size_t automatic = outputs.views.size() - scene.cameras.size();
  for (std::size_t v = 0; v < automatic && shows_touch_alone(world); v++)
    outputs.views[v].before_after = false;
  const bool seen_from_near = !world.cuts.empty() || !world.tools.empty();
  if (seen_from_near && !draws_all(outputs)) outputs.views[0].before_after = false;
  for (SurfaceView& view : outputs.views)
    if (view.colored && scene.output.color != SkinColor::kNone)
      view.camera = beside_legend(view.camera, outputs);
  outputs.films = make_films(outputs, world.cuts.size());
  if (!draws_all(outputs)) outputs.facts.more_pictures = more_pictures(scene.output);
  return outputs;
}

bool draws_all(const Outputs& outputs) { return outputs.scene->output.all_pictures || !has_motion_view(); }

Camera beside_legend(const Camera& camera, const Outputs& outputs) {
  const OutputScene& output = outputs.scene->output;
  return with_margin_right(camera, double(output.width) / output.height, kLegendFraction);
}

ColorScale color_scale(const Scene& scene, SkinColor color) {
  const bool stretch = color == SkinColor::kStretch, pressure = color == SkinColor::kPressure,
             principal = color == SkinColor::kPrincipalStretch;
  std::pair<double, double> range = stretch     ? std::pair(-0.2, 0.2)
                                    : principal ? std::pair(1.0, 1.3)
                                                : std::pair(0.0, 0.01);
  if (pressure) range = {0, scene.sfem_bodies[0].material.young};
  if (scene.output.color == color) range = scene.output.color_range.value_or(range);
  constexpr float kFar = std::numeric_limits<float>::max();  // next float, so that 0.01 m is not below 10 mm
  const float low = float(range.first), high = std::nextafter(float(range.second), kFar);
  if (stretch) return {low, high, "area strain of the skin [%]", 100};
  if (principal) return {low, high, "largest stretch of the skin [1]", 1};
  if (pressure) return {low, high, "contact pressure [kPa]", 1e-3f};
  return {low, high, "displacement [mm]", 1000};
}

std::optional<Image> draw_items(const PictureItems& items, const Camera& camera, Outputs& outputs,
                                RenderQuality quality) {
  if (!outputs.can_draw) return std::nullopt;
  const AddTime time(outputs.facts.drawing_seconds);
  const OutputScene& output = outputs.scene->output;
  Result<Image> image = draw_meshes(items.items, camera, output.width, output.height, quality);
  if (image) {
    draw_labels(items.labels, camera, *image);
    draw_scale_bar(*image, camera);
    if (output.legend) draw_names(*image, shown_names(items));
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

namespace {

void keep_first(const WorldSnapshot& snapshot, Outputs& outputs) {
  const auto wants_it = [](const SurfaceView& view) { return view.before_after; };
  if (!outputs.first.bodies.empty() || std::none_of(outputs.views.begin(), outputs.views.end(), wants_it))
    return;
  outputs.first = snapshot;
  for (BodySnapshot& body : outputs.first.bodies) body.cache.reset();
}

/// Picture of a single snapshot, if the scene requests it.
void add_frame(const WorldSnapshot& snapshot, const SurfaceView& view, Outputs& outputs) {
  if (!outputs.scene->output.frames) return;
  const std::optional<Image> image = draw_world(snapshot, outputs, view.camera, view.colored);
  if (!image) return;
  const AddTime time(outputs.facts.file_seconds);
  const fs::path file = outputs.folder / fmt::format("frames/{}-{:04}.png", view.name, snapshot.frame);
  if (const Status written = write_png(file, *image); !written) stop_drawing(outputs, written.error());
}

void add_to_motion(const WorldSnapshot& snapshot, Outputs& outputs) {
  const AddTime time(outputs.facts.drawing_seconds);
  outputs.motion_text.clear();
  add_moment(snapshot, outputs.motion);
}

}  // namespace

std::string motion_of_page(Outputs& outputs) {
  const AddTime time(outputs.facts.drawing_seconds);
  constexpr std::uintmax_t kPage = 8'000'000, kRest = 1'500'000;  // [bytes]; three.js, the video and the text
  std::uintmax_t pictures = 0;
  for (const ReportPicture& picture : outputs.facts.pictures) {
    std::error_code none;
    const std::uintmax_t size = fs::file_size(outputs.folder / picture.file, none);
    pictures += none ? 0 : size * 4 / 3;
  }
  const std::uintmax_t taken = pictures + kRest;
  if (taken >= kPage) return {};
  // pictures are only added, so that a text that still fits is the one that would be made again
  std::string& text = outputs.motion_text;
  if (text.empty() || text.size() > kPage - taken) text = motion_json(outputs.motion, kPage - taken);
  return motion_html(text);
}

Status add_snapshot(const WorldSnapshot& snapshot, Outputs& outputs) {
  add_to_motion(snapshot, outputs);
  keep_first(snapshot, outputs);
  return write_meshes(snapshot, outputs);
}

void draw_frames(const WorldSnapshot& snapshot, Outputs& outputs) {
  for (const SurfaceView& view : outputs.views) add_frame(snapshot, view, outputs);
}

bool wants_moment(const World& world, const Outputs& outputs) {
  // while a blade moves the surface changes in every frame, and is expensive
  const bool cuts = std::any_of(world.cuts.begin(), world.cuts.end(),
                                [](const Cut& cut) { return cut.path && cut.done < 1; });
  const OutputScene& output = outputs.scene->output;
  const double rate = output.video ? kVideoRate / output.video_speed : cuts ? kCutRate : kMotionRate;
  return world.frame % std::max(1, int(std::lround(outputs.scene->frame_rate / rate))) == 0;
}

void take_moment(const WorldSnapshot& snapshot, Outputs& outputs) {
  add_to_motion(snapshot, outputs);
  if (outputs.films.empty() || !outputs.can_draw) return;
  if (outputs.films[0].frames.empty()) outputs.video_begin = snapshot.time;
  for (Film& film : outputs.films) film_moment(snapshot, film, outputs);
  if (outputs.can_draw) outputs.video_end = snapshot.time;
}

namespace {

/// Pictures of every view before and at the end; wounds first.
Status add_before_after(const WorldSnapshot& snapshot, Outputs& outputs) {
  for (std::size_t v = outputs.views.size(); v-- > 0;) {
    const SurfaceView& view = outputs.views[v];
    if (!view.before_after) continue;
    const Camera camera = v == 0 ? camera_of_both(outputs, outputs.first, snapshot) : view.camera;
    const std::optional<Image> before = draw_world(outputs.first, outputs, camera, false),
                               last = draw_world(snapshot, outputs, camera, view.colored);
    if (!before || !last) continue;
    const Image pair = side_by_side({*before, *last}, {"before", "after " + seconds_text(snapshot.time)});
    const Status status = add_picture(outputs, view.name + "-before-after.png",
                                      view.caption + ", before and after", pair, true);
    if (!status) return status;
    if (const Status colored = add_colored_view(snapshot, outputs, view); !colored) return colored;
    if (const Status stretch = add_stretch_view(snapshot, outputs, v); !stretch) return stretch;
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
  return finish_meshes(outputs);
}

}  // namespace

Status write_outputs(const World& world, const WorldSnapshot& snapshot, const std::vector<Pressed>& pressed,
                     Outputs& outputs) {
  Status status = write_ct_outputs(world, outputs);
  if (status) status = finish_tables(world, outputs);
  if (!status) return status;
  finish_animation(outputs);
  return outputs.scene->output.obj ? write_objs(snapshot, pressed, outputs) : status;
}

Status draw_outputs(const World& world, const WorldSnapshot& snapshot, const std::vector<Pressed>& pressed,
                    Outputs& outputs) {
  Status status = add_pressed_pictures(pressed, outputs);
  if (status) status = add_before_after(snapshot, outputs);
  if (status) status = draw_ct_outputs(world, outputs);
  return status ? finish_films(outputs) : status;
}

}  // namespace turgor
