#include "turgor/sim/report/lattice_warnings.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "turgor/geometry/where_is.hpp"
#include "turgor/models/lattice/mechanics/inverted_cells.hpp"

namespace turgor {

namespace {

using lattice::Model;

/// A blade given so much farther from the skin than a lattice step is one that somebody misplaced [m].
constexpr double kOffSkin = 0.005;
constexpr double kCellsBelow = 3;  // that a cut needs below it

Vec3d in_patient(const Model& model, Vec3d x) { return model.grid.origin + model.grid.axes * x; }

/// How far a point of the scene lies from where the blade was set on the skin [m].
double off_skin(const Model& model, const lattice::BladePath& path, Vec3d point) {
  double nearest = std::numeric_limits<double>::max();
  for (const Vec3d x : path.skin) nearest = std::min(nearest, norm(in_patient(model, x) - point));
  return nearest;
}

/// To a hundredth of a millimetre: what is next to nothing is 0.
std::string place_on_skin(const Model& model, Vec3d x) {
  constexpr double kFine = 1e-5;  // [m]
  Vec3d place = in_patient(model, x);
  for (int axis = 0; axis < 3; axis++) place[axis] = kFine * std::round(place[axis] / kFine) + 0.0;
  return place_text(place);
}

void warn_of_blade(const Cut& cut, const Model& model, std::vector<std::string>& warnings) {
  const lattice::BladePath& path = *cut.path;
  const double from = off_skin(model, path, cut.blade.from), to = off_skin(model, path, cut.blade.to);
  const Vec3 step = model.lattice.step;
  if (std::max(from, to) > kOffSkin + double(std::max({step.x, step.y, step.z})))
    warnings.push_back(fmt::format(
        "incision '{}': its ends, {} and {}, are {:.0f} and {:.0f} mm off the skin: the blade was set on the "
        "skin between {} and {}",
        cut.blade.name, place_text(cut.blade.from), place_text(cut.blade.to), 1e3 * from, 1e3 * to,
        place_on_skin(model, path.skin.front()), place_on_skin(model, path.skin.back())));
  double below = kCellsBelow;
  for (std::size_t n = 0; n + 1 < path.skin.size(); n++)
    below = std::min(below, lattice::cells_below(model, path.skin[n] + path.into[n] * path.depth,
                                                 path.skin[n + 1] + path.into[n + 1] * path.depth,
                                                 path.into[n], kCellsBelow));
  if (below < kCellsBelow)
    warnings.push_back(fmt::format(
        "incision '{}': {} of body below the cut, expected at least {:.0f} cells: what holds its bottom is "
        "the lattice's as much as the tissue's; take a smaller step or a shallower cut",
        cut.blade.name, below > 0 ? fmt::format("less than {:.2g} cells", below + 0.25) : "nothing",
        kCellsBelow));
}

void warn_of_folds(const Exec& exec, const LatticeBody& body, std::vector<std::string>& warnings) {
  const lattice::InvertedCells folded = lattice::find_folded_cells(exec, body.model, body.state);
  if (folded.count == 0) return;
  const Vec3d place(position(body.model, body.state, folded.first));
  warnings.push_back(fmt::format(
      "{}: {} {} at the end, one at {}: what is measured there means nothing; more sweeps, tissue.volume or "
      "tissue.law = \"solid\" keep cells from folding",
      body.name, folded.count,
      folded.count == 1 ? "cell is turned inside out" : "cells are turned inside out",
      place_text(in_patient(body.model, place))));
}

}  // namespace

std::vector<std::string> lattice_warnings(const Exec& exec, const World& world) {
  std::vector<std::string> warnings;
  for (const Cut& cut : world.cuts)
    if (cut.path) warn_of_blade(cut, world.lattice_bodies[std::size_t(cut.body)].model, warnings);
  for (const LatticeBody& body : world.lattice_bodies) warn_of_folds(exec, body, warnings);
  return warnings;
}

}  // namespace turgor
