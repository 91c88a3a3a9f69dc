#include "turgor/sim/report/lattice_warnings.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <fmt/format.h>

#include "turgor/geometry/body_location.hpp"
#include "turgor/geometry/ct_sampler.hpp"
#include "turgor/models/lattice/mechanics/inverted_cells.hpp"
#include "turgor/sim/report/report_suture.hpp"

namespace turgor {

namespace {

using lattice::Model;

/// larger offsets from the skin, in addition to a lattice spacing, are probably mistakes [m]
constexpr double kOffSkin = 0.005;
constexpr double kCellsBelow = 3;  // required below a cut

Vec3d in_patient(const Model& model, Vec3d x) {
  return model.anatomy.grid.origin + model.anatomy.grid.axes * x;
}

/// Distance from a point of the scene to the blade's path on the skin [m].
double off_skin(const Model& model, const lattice::BladePath& path, Vec3d point) {
  double nearest = std::numeric_limits<double>::max();
  for (const Vec3d x : path.points) nearest = std::min(nearest, norm(in_patient(model, x) - point));
  return nearest;
}

/// Rounded to a hundredth of a millimeter.
std::string patient_position_text(const Model& model, Vec3d x) {
  constexpr double kFine = 1e-5;  // [m]
  Vec3d position = in_patient(model, x);
  for (int axis = 0; axis < 3; axis++) position[axis] = kFine * std::round(position[axis] / kFine) + 0.0;
  return position_text(position);
}

const char* kind_of(const Cut& cut) { return cut.blade.excision ? "excision" : "incision"; }

void warn_about_blade(const Cut& cut, const Model& model, std::vector<std::string>& warnings) {
  const lattice::BladePath& path = *cut.path;

  // distance of the blade from the given positions
  const double from = off_skin(model, path, cut.blade.from), to = off_skin(model, path, cut.blade.to);
  const Vec3 step = model.anatomy.lattice.spacing;
  if (std::max(from, to) > kOffSkin + double(std::max({step.x, step.y, step.z})))
    warnings.push_back(fmt::format(
        "{} '{}': its ends, {} and {}, are {:.0f} and {:.0f} mm off the skin: the blade was moved to "
        "the "
        "skin between {} and {}",
        kind_of(cut), cut.blade.name, position_text(cut.blade.from), position_text(cut.blade.to), 1e3 * from,
        1e3 * to, patient_position_text(model, path.points.front()),
        patient_position_text(model, path.points.back())));

  // cells below the cut
  double below = kCellsBelow;
  for (std::size_t n = 0; n + 1 < path.points.size(); n++)
    below = std::min(below, lattice::cells_below(model, path.points[n] + path.inward[n] * path.depths[n],
                                                 path.points[n + 1] + path.inward[n + 1] * path.depths[n + 1],
                                                 path.inward[n], kCellsBelow));
  if (below < kCellsBelow)
    warnings.push_back(fmt::format(
        "{} '{}': {} of body below the cut, expected at least {:.0f} cells: the support of its bottom "
        "depends on "
        "the lattice; use a smaller spacing or a shallower cut",
        kind_of(cut), cut.blade.name,
        below > 0 ? fmt::format("less than {:.2g} cells", below + 0.25) : "nothing", kCellsBelow));
}

/// First bone that a blade meets.
struct BoneUnderBlade {
  Vec3d point;       // patient frame [m]
  double depth = 0;  // below the skin [m]
};

/// The shallowest bone of the CT between the skin and the bottom of the cut; empty without bone.
std::optional<BoneUnderBlade> bone_under_blade(const LatticeBody& body, const lattice::BladePath& path) {
  const Grid& grid = body.ct.grid;
  const CtSampler sample(body.ct);
  const double step = 0.5 * std::min({grid.spacing.x, grid.spacing.y, grid.spacing.z});
  std::optional<BoneUnderBlade> first;
  for (std::size_t n = 0; n < path.points.size(); n++)
    for (double depth = 0; depth <= (first ? first->depth - step : path.depth); depth += step) {
      const Vec3d point = in_patient(body.model, path.points[n] + path.inward[n] * depth);
      if (double(sample(Vec3(index_at(grid, point)))) < body.model.params.tissue.bone_min) continue;
      first = {point, depth};
      break;
    }
  return first;
}

void warn_about_bone(const Cut& cut, const LatticeBody& body, std::vector<std::string>& warnings) {
  const std::optional<BoneUnderBlade> bone = bone_under_blade(body, *cut.path);
  if (!bone) return;
  Vec3d point = bone->point;
  for (int axis = 0; axis < 3; axis++) point[axis] = 1e-4 * std::round(1e4 * point[axis]) + 0.0;
  warnings.push_back(
      fmt::format("{} '{}': the blade meets bone at {}, {:.1f} mm below the skin, and {}: "
                  "a smaller depth or another position stays in soft tissue",
                  kind_of(cut), cut.blade.name, position_text(point), 1e3 * bone->depth,
                  cut.blade.through_bone ? "cuts through it" : "stops there"));
}

void warn_of_inverted_cells(const Exec& exec, const LatticeBody& body, std::vector<std::string>& warnings) {
  const lattice::InvertedCells inverted = lattice::find_inverted_cells(exec, body.model, body.state);
  if (inverted.count == 0) return;
  const Vec3d first(position(body.model, body.state->motion, inverted.first));
  warnings.push_back(fmt::format(
      "{}: {} {} at the end, one at {}: measures near them are invalid; more sweeps, tissue.volume or "
      "tissue.law = \"solid\" prevent inverted cells",
      body.name, inverted.count, inverted.count == 1 ? "cell is inverted" : "cells are inverted",
      position_text(in_patient(body.model, first))));
}

}  // namespace

std::vector<std::string> lattice_warnings(const Exec& exec, const World& world) {
  std::vector<std::string> warnings;
  for (const Cut& cut : world.cuts)
    if (cut.path) {
      const LatticeBody& body = world.lattice_bodies[std::size_t(cut.body)];
      warn_about_blade(cut, body.model, warnings);
      warn_about_bone(cut, body, warnings);
    }
  for (const LatticeBody& body : world.lattice_bodies) warn_of_inverted_cells(exec, body, warnings);
  for (const std::string& warning : suture_warnings(world)) warnings.push_back(warning);
  return warnings;
}

}  // namespace turgor
