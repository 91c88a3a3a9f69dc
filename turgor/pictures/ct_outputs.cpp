#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "turgor/io/ct.hpp"
#include "turgor/models/lattice/resample/image_mass.hpp"
#include "turgor/pictures/deformed_volume.hpp"
#include "turgor/pictures/outputs.hpp"
#include "turgor/view/sample.hpp"

namespace turgor {

namespace {

namespace fs = std::filesystem;

/// Location of a cut, for its sections, in the patient frame.
struct CutLocation {
  Vec3d middle;          // on the skin [m]
  Vec3d line, into;      // unit
  double length, depth;  // [m]
};
CutLocation location_of(const Grid& grid, const lattice::BladePath& path) {
  const Vec3d middle = path.points[path.points.size() / 2];
  const std::size_t n = path.points.size() / 2;
  return {grid.origin + grid.axes * middle, grid.axes * tangent_at(path, n), grid.axes * path.inward[n],
          path_length(path), path.depth};
}

/// Anatomical plane most perpendicular to a cut.
Plane plane_across(Vec3d line) {
  const Vec3d size{std::abs(line.x), std::abs(line.y), std::abs(line.z)};
  if (size.x >= size.y && size.x >= size.z) return Plane::kSagittal;
  return size.y >= size.z ? Plane::kCoronal : Plane::kAxial;
}

/// A fine grid around a point, along the patient's axes.
Grid close_up_grid(Vec3d middle, double side, int samples) {
  Grid grid;
  grid.size = {samples, samples, samples};
  const double spacing = side / samples;
  grid.spacing = {spacing, spacing, spacing};
  grid.origin = middle - Vec3d{1, 1, 1} * (0.5 * (side - spacing));
  return grid;
}

/// A slice of that grid, one sample thick across the plane.
Grid slice_of(Grid grid, Plane plane) {
  const int axis = plane == Plane::kAxial ? 2 : plane == Plane::kCoronal ? 1 : 0;
  grid.origin[axis] += grid.spacing[axis] * (grid.size[axis] / 2);
  grid.size[axis] = 1;
  return grid;
}

/// CT values at the points of a grid; air outside the CT.
CtVolume sampled(const CtVolume& ct, const Grid& grid) {
  CtVolume result;
  result.grid = grid;
  result.samples.reserve(sample_count(grid));
  for (int k = 0; k < grid.size.z; k++)
    for (int j = 0; j < grid.size.y; j++)
      for (int i = 0; i < grid.size.x; i++) {
        const Vec3d index = index_at(ct.grid, point_at(grid, {double(i), double(j), double(k)}));
        result.samples.push_back(inside_samples(ct.grid, index)
                                     ? std::int16_t(std::lround(sample_clamped(ct, Vec3(index))))
                                     : kAirHu);
      }
  return result;
}

/// Close-up sections across the cut, before and after.
Status add_close_sections(const LatticeBody& body, const Cut& cut, Window window, Outputs& outputs) {
  const CutLocation location = location_of(body.model.anatomy.grid, *cut.path);
  const Plane plane = plane_across(location.line);
  const double side = std::max(0.06, 6 * location.depth);
  const Vec3d middle = location.middle + location.into * (0.25 * side);
  constexpr int kSamples = 240, kHeight = 480;
  const Grid grid = slice_of(close_up_grid(middle, side, kSamples), plane);
  const Vec3d at = point_at(grid, Vec3d(grid.size - Int3{1, 1, 1}) * 0.5);
  std::vector<Image> images;
  {
    const AddTime time(outputs.facts.drawing_seconds);
    images.push_back(draw_section(sampled(body.ct, grid), plane, at, window, kHeight));
    const CtVolume now = body.state.resample(*outputs.exec, body.model, body.ct, grid).ct;
    images.push_back(draw_section(now, plane, at, window, kHeight));
  }
  const std::string name = cut.blade.name;
  return add_picture(outputs, name + "-across.png", "section across " + name + ", before and after",
                     side_by_side(images, {"before", "after"}), true);
}

Status add_sections(const LatticeBody& body, const CtVolume& now, const Cut& cut, Window window,
                    Outputs& outputs) {
  const CutLocation location = location_of(body.model.anatomy.grid, *cut.path);
  const Vec3d point = location.middle + location.into * (0.5 * location.depth);
  constexpr int kHeight = 420;
  const auto three = [&](const CtVolume& ct) {
    const AddTime time(outputs.facts.drawing_seconds);
    std::vector<Image> images;
    for (const Plane plane : {Plane::kAxial, Plane::kCoronal, Plane::kSagittal})
      images.push_back(draw_section(ct, plane, point, window, kHeight));
    return side_by_side(images, {"axial", "coronal", "sagittal"});
  };
  const std::string name = cut.blade.name;
  const std::string caption = "sections through " + name;
  if (const Status status =
          add_picture(outputs, name + "-sections-before.png", caption + ", before", three(body.ct), true);
      !status)
    return status;
  return add_picture(outputs, name + "-sections-after.png", caption + ", after", three(now), true);
}

/// Only the body: a table would block the view.
Status add_volume_rendering(const LatticeBody& body, const lattice::State& rest, Outputs& outputs) {
  const OutputScene& output = outputs.scene->output;
  const Camera& camera = outputs.views.front().camera;
  std::vector<Image> images;
  {
    const AddTime time(outputs.facts.drawing_seconds);
    const lattice::ResampledCt alone = lattice::resample_ct(*outputs.exec, body.model, rest, body.ct,
                                                            body.ct.grid, {.keep_surroundings = false});
    images.push_back(
        draw_volume(*outputs.exec, alone.ct, output.volume_rendering, camera, output.width, output.height));
    images.push_back(draw_deformed_volume(*outputs.exec, body, output.volume_rendering, camera, output.width,
                                          output.height));
  }
  return add_picture(
      outputs, body.name + "-volume.png",
      fmt::format("volume rendering of {} ({}), before and after", body.name, output.volume_rendering),
      side_by_side(images, {"before", "after"}), true);
}

/// File name, prefixed with the body's name if there are several bodies.
std::string file_of(const Outputs& outputs, const LatticeBody& body, const std::string& name) {
  return outputs.at_rest.size() == 1 ? name : body.name + "-" + name;
}

/// Writes a file, or a folder for a DICOM series.
Status write_deformed(const LatticeBody& body, const CtVolume& now, const std::string& file,
                      Outputs& outputs) {
  const AddTime time(outputs.facts.file_seconds);
  const fs::path goal = outputs.folder / file;
  const Status status = goal.has_extension() ? write_ct(goal, now, *outputs.exec)
                                             : write_dicom(*outputs.exec, goal, now, body.ct_origin);
  if (status) outputs.facts.files.push_back(file);
  return status;
}

Status write_fields(const LatticeBody& body, const Grid& grid, Outputs& outputs) {
  const AddTime time(outputs.facts.file_seconds);
  const OutputScene& output = outputs.scene->output;
  if (!output.displacement.empty()) {
    const std::string file = file_of(outputs, body, output.displacement);
    const VectorVolume field = lattice::resample_warp(*outputs.exec, body.model, body.state, grid);
    if (const Status status = write_displacement(outputs.folder / file, field); !status) return status;
    outputs.facts.files.push_back(file);
  }
  if (!output.jacobian.empty()) {
    const std::string file = file_of(outputs, body, output.jacobian);
    const ScalarVolume field = body.state.resample_jacobian(*outputs.exec, body.model, grid);
    if (const Status status = write_scalars(outputs.folder / file, field); !status) return status;
    outputs.facts.files.push_back(file);
  }
  return Done{};
}

bool is_cut(const World& world, std::size_t body) {
  return std::any_of(world.cuts.begin(), world.cuts.end(),
                     [body](const Cut& cut) { return std::size_t(cut.body) == body && cut.path; });
}

/// The whole deformed CT, as a scan would show it. `rest`: the body without displacements.
Result<CtVolume> deformed_ct(const LatticeBody& body, lattice::State rest, const Grid& grid,
                             Outputs& outputs) {
  const OutputScene& output = outputs.scene->output;
  lattice::ResampledCt now =
      body.state.resample(*outputs.exec, body.model, body.ct, grid, {.conserve_mass = output.conserve_mass});
  const std::string file = output.deformed_ct.empty() ? "" : file_of(outputs, body, output.deformed_ct);
  rest.cuts = body.state.cuts();
  const double mass_error = lattice::image_mass_error(*outputs.exec, body.model, rest, body.ct, now.ct);
  outputs.facts.deformed.push_back(
      {body.name, file, grid.size, now.report.seconds, mass_error, now.report.inverted_tets});
  outputs.facts.drawing_seconds += now.report.seconds;
  if (!file.empty())
    if (const Status status = write_deformed(body, now.ct, file, outputs); !status) return status.error();
  return std::move(now.ct);
}

bool draws_sections(const World& world, std::size_t body, const OutputScene& output) {
  return output.sections && is_cut(world, body);
}

Status write_body(const World& world, std::size_t index, Outputs& outputs) {
  const OutputScene& output = outputs.scene->output;
  const LatticeBody& body = world.lattice_bodies[index];
  const Grid grid =
      output.deformed_size ? lattice::resized(body.ct.grid, *output.deformed_size) : body.ct.grid;
  if (const Status status = write_fields(body, grid, outputs); !status) return status;
  const bool sections = draws_sections(world, index, output);
  if (output.deformed_ct.empty() && !(sections && output.all_pictures)) return Done{};
  Result<CtVolume> now = deformed_ct(body, outputs.at_rest[index], grid, outputs);
  if (!now) return now.error();
  if (sections) outputs.deformed_cts[index] = std::move(*now);
  return Done{};
}

Status draw_body_ct(const World& world, std::size_t index, Outputs& outputs) {
  const LatticeBody& body = world.lattice_bodies[index];
  if (!outputs.scene->output.volume_rendering.empty())
    if (const Status status = add_volume_rendering(body, outputs.at_rest[index], outputs); !status)
      return status;
  const auto now = outputs.deformed_cts.find(index);
  if (now == outputs.deformed_cts.end()) return Done{};
  const Result<Window> window = window_preset(outputs.scene->output.window);
  if (!window) return window.error();
  for (const Cut& cut : world.cuts) {
    if (std::size_t(cut.body) != index || !cut.path) continue;
    if (const Status s = add_close_sections(body, cut, *window, outputs); !s) return s;
    if (const Status s = add_sections(body, now->second, cut, *window, outputs); !s) return s;
  }
  outputs.deformed_cts.erase(now);
  return Done{};
}

}  // namespace

Status write_ct_outputs(const World& world, Outputs& outputs) {
  for (std::size_t b = 0; b < world.lattice_bodies.size(); b++)
    if (const Status status = write_body(world, b, outputs); !status) return status;
  return Done{};
}

Status draw_ct_outputs(const World& world, Outputs& outputs) {
  for (std::size_t b = 0; b < world.lattice_bodies.size(); b++)
    if (const Status status = draw_body_ct(world, b, outputs); !status) return status;
  return Done{};
}

}  // namespace turgor
