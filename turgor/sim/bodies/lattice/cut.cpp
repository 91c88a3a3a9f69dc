#include "turgor/sim/bodies/lattice/cut.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/models/lattice/model/halo.hpp"

namespace turgor {

namespace {

/// First intersection of a ray from `point` with the body; `point` if it misses.
Vec3d first_body_point(const lattice::Model& model, Vec3d point, Vec3d direction, double length) {
  const Grid& grid = model.anatomy.grid;
  TURGOR_CHECK(is_unit(direction), "the direction of a search is a unit vector");
  const double stride = 0.5 * std::min({grid.spacing.x, grid.spacing.y, grid.spacing.z});
  for (double t = 0; t <= length; t += stride) {
    const Vec3d index = index_at(grid, point + direction * t);
    const Int3 node{int(std::lround(index.x)), int(std::lround(index.y)), int(std::lround(index.z))};
    if (!contains(grid, node)) continue;
    if (lattice::is_body(model.anatomy.tissue[std::size_t(node_slot(model.anatomy.lattice, node))]))
      return point + direction * t;
  }
  return point;
}

Vec3d placed_point(const lattice::Model& model, const Box& box, Vec3d fraction) {
  const Vec3d extent = box.high - box.low;
  Vec3d point = box.low + hadamard(fraction, extent);
  for (int axis = 0; axis < 3; axis++) {
    if (fraction[axis] != 0 && fraction[axis] != 1) continue;
    Vec3d inwards;
    inwards[axis] = fraction[axis] == 0 ? 1 : -1;
    return first_body_point(model, point, inwards, extent[axis]);
  }
  return point;
}

/// Fraction of the path that the blade has cut at the end of a frame. A moving blade that starts at that
/// moment, up to the rounding of frame times (step), starts in the next frame.
double blade_fraction(const Cut& cut, double time) {
  constexpr double kRounding = 2e-12;
  if (time < cut.blade.start) return 0;
  if (cut.blade.duration > 0 && time - cut.blade.start <= kRounding * time) return 0;
  return cut.blade.duration > 0 ? std::min(1.0, (time - cut.blade.start) / cut.blade.duration) : 1;
}

/// Sets the path of an excision.
Status outline_excision(const LatticeBody& body, std::span<const Cut> others, Cut& cut) {
  lattice::Incision& blade = cut.blade;
  Result<std::vector<Vec3d>> outline = lattice::excision_outline(body.model, *body.state, *blade.excision);
  if (!outline) return outline.error();
  blade.path = std::move(*outline);
  blade.from = blade.path.front(), blade.to = blade.path[blade.path.size() / 2];
  for (const Cut& other : others)
    if (other.body == cut.body && other.blade.excision &&
        lattice::outlines_overlap(blade.path, other.blade.path))
      return Error{fmt::format("excision '{}' overlaps excision '{}': expected pieces that are apart",
                               blade.name, other.blade.name)};
  return Done{};
}

}  // namespace

Box body_box(const lattice::Model& model) {
  // start with an empty box
  constexpr double kFar = std::numeric_limits<double>::max();
  Box box{{kFar, kFar, kFar}, {-kFar, -kFar, -kFar}};
  const Int3 size = model.anatomy.lattice.size;
  // extend the box by all body nodes
  for (int k = 0; k < size.z; k++)
    for (int j = 0; j < size.y; j++)
      for (int i = 0; i < size.x; i++) {
        if (!lattice::is_body(model.anatomy.tissue[std::size_t(node_slot(model.anatomy.lattice, i, j, k))]))
          continue;
        const Vec3d point = point_at(model.anatomy.grid, {double(i), double(j), double(k)});
        box = {min(box.low, point), max(box.high, point)};
      }
  TURGOR_CHECK(box.low.x <= box.high.x && box.low.y <= box.high.y && box.low.z <= box.high.z,
               "a body has nodes");
  return box;
}

lattice::Incision blade_from_fractions(const lattice::Model& model, const lattice::Incision& fractions) {
  const Box box = body_box(model);
  lattice::Incision blade = fractions;
  blade.from = placed_point(model, box, fractions.from);
  blade.to = placed_point(model, box, fractions.to);
  for (Vec3d& point : blade.path) point = placed_point(model, box, point);
  if (blade.excision) blade.excision->center = placed_point(model, box, blade.excision->center);
  return blade;
}

Result<Cut> load_cut(const IncisionScene& scene, const LatticeBody& body, std::span<const Cut> others) {
  Cut cut;
  cut.body = scene.body;
  cut.blade = scene.by_fraction ? blade_from_fractions(body.model, scene.blade) : scene.blade;
  if (cut.blade.excision)
    if (const Status outlined = outline_excision(body, others, cut); !outlined)
      return Error{fmt::format("{}: {}", scene.source_location, outlined.error().message)};
  const Result<lattice::BladePath> trial = lattice::lay_blade(body.model, body.state, cut.blade);
  if (!trial) return Error{fmt::format("{}: {}", scene.source_location, trial.error().message)};
  return cut;
}

Status advance_blade(const Exec& exec, LatticeBody& body, std::span<Cut> cuts, int index, double time,
                     const lattice::HaloExchange* halo) {
  TURGOR_ASSERT(is_index(index, cuts.size()), "the blade of a cut advances");
  Cut& cut = cuts[std::size_t(index)];
  const double fraction = blade_fraction(cut, time);
  if (fraction <= cut.done) return Done{};
  if (halo) halo->refresh();
  if (!cut.path) {
    std::vector<lattice::LaidBlade> laid;
    for (const Cut& other : cuts)
      if (other.body == cut.body && other.path) laid.push_back({other.blade, *other.path});
    Result<lattice::BladePath> path = lattice::lay_blade(body.model, body.state, cut.blade, halo, laid);
    if (!path) return path.error();
    cut.path = std::move(*path);
    if (cut.blade.width > 0) cut.edges = body.state.cut_region(body.model, *cut.path);
  }
  if (cut.blade.width == 0)
    cut.edges += body.state.cut_edges(body.model, *cut.path, cut.done, fraction, index);
  TURGOR_CHECK(fraction <= 1, "a blade ends with its path");
  cut.done = fraction;
  if (cut.blade.excision && fraction >= 1) {
    Result<lattice::Specimen> specimen =
        lattice::excise_piece(exec, body.model, body.state.change(), *cut.path, index);
    if (!specimen) return Error{fmt::format("excision '{}': {}", cut.blade.name, specimen.error().message)};
    cut.specimen = *specimen;
  }
  if (halo) halo->refresh();
  return Done{};
}

}  // namespace turgor
