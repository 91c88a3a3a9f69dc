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
constexpr Rgb kSkin{224, 172, 145}, kWall{166, 58, 50};

lattice::Shown shown_scalar(SkinColor color) {
  switch (color) {
    case SkinColor::kDisplacement:
      return lattice::Shown::kDisplacement;
    case SkinColor::kStretch:
      return lattice::Shown::kStretch;
    case SkinColor::kNone:
      break;
  }
  return lattice::Shown::kNothing;
}

/// The same colours at every snapshot, so that pictures can be compared.
ColorScale scale_of(const OutputScene& output) {
  const bool stretch = output.color == SkinColor::kStretch;
  const auto [low, high] = output.color_range.value_or(stretch ? std::pair(-0.2, 0.2) : std::pair(0.0, 0.01));
  constexpr float kFar =
      std::numeric_limits<float>::max();  // up to the next float, so that 0.01 m is not below 10 mm
  ColorScale scale{float(low), std::nextafter(float(high), kFar),
                   stretch ? "area strain of the skin [%]" : "displacement [mm]", 1000};
  if (stretch) scale.factor = 100;
  return scale;
}

Vec3d to_patient(const Grid& grid, Vec3d local) { return grid.origin + grid.axes * local; }

Box grown(Box box, double margin) {
  const Vec3d m{margin, margin, margin};
  return {box.low - m, box.high + m};
}

/// Looks at a cut from outside, a little from below, its line upright or lying as in the patient.
SurfaceView view_of_cut(const World& world, const Cut& cut, const lattice::BladePath& path, double aspect) {
  const Grid& grid = world.lattices[std::size_t(cut.body)].model.grid;
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

SurfaceView view_of_bodies(const World& world, Vec3d outward, double aspect) {
  const BodyBox first = body_box(world.lattices[0].model);
  Box box{first.low, first.high};
  for (const LatticeBody& body : world.lattices) {
    const BodyBox more = body_box(body.model);
    box = {min(box.low, more.low), max(box.high, more.high)};
  }
  const Vec3d direction = normalized(outward) + Vec3d{0.45, 0, 0.2};
  return {"skin", "the skin", frame_box(box, direction, {0, 0, 1}, aspect), true, {}, {}};
}

/// The skin and the walls of wounds as two meshes that share vertices.
struct DrawnMeshes {
  TriMesh skin, walls;
};
DrawnMeshes drawn_meshes(const LatticeBody& body, DrawnBody& drawn, SkinColor color) {
  if (!drawn.made || drawn.cut_edges != body.state.cut_edges.size()) {
    drawn.surface = lattice::build_surface(body.model, body.state);
    drawn.cut_edges = body.state.cut_edges.size();
    drawn.made = true;
  }
  DrawnMeshes meshes;
  meshes.skin = lattice::deformed_surface(body.model, body.state, drawn.surface, shown_scalar(color));
  meshes.walls = meshes.skin;
  const auto split = std::ptrdiff_t(drawn.surface.skin_triangles);
  meshes.walls.triangles.erase(meshes.walls.triangles.begin(), meshes.walls.triangles.begin() + split);
  meshes.skin.triangles.resize(std::size_t(split));
  return meshes;
}

Status write_meshes(const World& world, Outputs& outputs) {
  for (std::size_t b = 0; b < world.lattices.size(); b++) {
    const LatticeBody& body = world.lattices[b];
    const TriMesh moved = lattice::deformed_surface(body.model, body.state, outputs.bodies[b].surface,
                                                    lattice::Shown::kStretch);
    std::vector<Vec3> displacement(moved.vertices.size());
    for (std::size_t v = 0; v < displacement.size(); v++) {
      const Vec3d rest = to_patient(body.model.grid, Vec3d(outputs.bodies[b].surface.rest[v]));
      displacement[v] = moved.vertices[v] - Vec3(rest);
    }
    const std::string file = fmt::format("meshes/{}-{:04}.vtu", body.name, world.frame);
    const Status status = write_vtu(
        outputs.folder / file, moved,
        {vertex_field("displacement [m]", displacement), vertex_field("area strain [1]", moved.scalars)});
    if (!status) return status;
    outputs.series.push_back({time_of(world), file, body.name});
  }
  return Done{};
}

/// A cut from near once more, in colours.
Status add_colored_view(const World& world, Outputs& outputs, const SurfaceView& view) {
  if (view.colored || outputs.scene->output.color == SkinColor::kNone) return Done{};
  const std::optional<Image> image = draw_bodies(world, outputs, view.camera, true);
  if (!image) return Done{};
  return add_picture(outputs, view.name + "-colored.png", view.caption + ", in colours", *image, false);
}

std::string seconds_text(double seconds) { return fmt::format("{:.2f} s", seconds); }

Status write_objs(const World& world, Outputs& outputs) {
  for (std::size_t b = 0; b < world.lattices.size(); b++) {
    const LatticeBody& body = world.lattices[b];
    const std::string file = body.name + ".obj";
    const TriMesh mesh = lattice::deformed_surface(body.model, body.state, outputs.bodies[b].surface,
                                                   lattice::Shown::kNothing);
    if (const Status status = write_obj(outputs.folder / file, mesh); !status) return status;
    outputs.facts.files.push_back(file);
  }
  return Done{};
}

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
  Vec3d outward{0, -1, 0};  // the front of a patient
  std::vector<SurfaceView> cuts;
  for (const LatticeBody& body : world.lattices) {
    outputs.bodies.emplace_back();
    outputs.bodies.back().rest = lattice::make_state(body.model);
  }
  for (const Cut& cut : world.cuts) {
    const auto body = std::size_t(cut.body);
    const auto path = lattice::lay_blade(world.lattices[body].model, outputs.bodies[body].rest, cut.blade);
    if (!path) return path.error();
    if (cuts.empty()) outward = -(world.lattices[body].model.grid.axes * path->into);
    cuts.push_back(view_of_cut(world, cut, *path, aspect));
  }
  outputs.views.push_back(view_of_bodies(world, outward, aspect));
  std::move(cuts.begin(), cuts.end(), std::back_inserter(outputs.views));
  return outputs;
}

std::optional<Image> draw_bodies(const World& world, Outputs& outputs, const Camera& camera, bool colored) {
  const OutputScene& output = outputs.scene->output;
  const SkinColor color = colored ? output.color : SkinColor::kNone;
  const ColorScale scale = scale_of(output);
  std::vector<DrawnMeshes> meshes;
  for (std::size_t b = 0; b < world.lattices.size(); b++)
    meshes.push_back(drawn_meshes(world.lattices[b], outputs.bodies[b], color));
  if (!outputs.can_draw) return std::nullopt;
  std::vector<MeshPart> parts;
  for (const DrawnMeshes& m : meshes) {
    parts.push_back({&m.skin, kSkin, color == SkinColor::kNone ? nullptr : &scale, nullptr});
    if (!m.walls.triangles.empty()) parts.push_back({&m.walls, kWall, nullptr, nullptr});
  }
  Result<Image> image = draw_meshes(parts, camera, output.width, output.height);
  if (image) return std::move(*image);
  outputs.can_draw = false;
  outputs.facts.warnings.push_back("no pictures of the skin: " + image.error().message);
  return std::nullopt;
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
  return outputs.scene->output.meshes ? write_meshes(world, outputs) : Done{};
}

int video_interval(const Outputs& outputs) {
  if (!outputs.scene->output.video || !outputs.can_draw || !has_ffmpeg()) return 0;
  return std::max(1, int(std::lround(outputs.scene->frame_rate / kVideoRate)));
}

Status add_video_frame(const World& world, Outputs& outputs) {
  const std::optional<Image> image = draw_bodies(world, outputs, outputs.views.back().camera, false);
  if (!image) return Done{};
  const fs::path file = outputs.folder / kVideoFolder / fmt::format("{:06}.png", outputs.video_frames.size());
  outputs.video_frames.push_back(file);
  return write_png(file, *image);
}

Status finish_outputs(const World& world, Outputs& outputs) {
  for (std::size_t v = outputs.views.size(); v-- > 0;) {  // wounds first, then the whole
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
    if (const Status status = write_pvd(outputs.folder / "meshes.pvd", outputs.series); !status)
      return status;
    outputs.facts.files.push_back("meshes.pvd");
  }
  if (outputs.scene->output.obj)
    if (const Status status = write_objs(world, outputs); !status) return status;
  return finish_video(outputs);
}

}  // namespace turgor
