#include "turgor/sim/report/force_error.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "turgor/core/assert.hpp"

namespace turgor {

namespace {

constexpr double kMuch = 0.10;          // warning threshold, relative
constexpr double kMuchOnLattice = 0.2;  // the same for lattices
constexpr double kLatticeError = 0.05, kSpacingError = 0.4, kSpacingOrder = 2.5;  // of lattice_force_error

/// Radius of a ball or a capsule; 0 for other shapes [m].
double radius_of(const contact::Shape& shape) {
  if (const auto* ball = std::get_if<contact::Sphere>(&shape)) return ball->radius;
  if (const auto* rod = std::get_if<contact::Capsule>(&shape)) return rod->radius;
  return 0;
}

double deepest(const TouchingTool& tool) {
  double depth = 0;
  for (const ForceSample& s : tool.samples) depth = std::max(depth, s.depth);
  return depth;
}

/// Lattice under a ball or a capsule at its deepest.
struct TouchedLattice {
  double spacing = 0;  // the largest one [m]
  double contact = 0;  // contact radius: √(tool radius · depth) [m]
};

/// Empty for other shapes, other models and tools without contact.
std::optional<TouchedLattice> touched_lattice(const World& world, const TouchingTool& tool) {
  const double radius = radius_of(tool.tool.shape), depth = deepest(tool);
  if (tool.body.kind != BodyKind::kLattice || tool.tool.needle || depth <= 0 || radius <= 0) return {};
  const Vec3d h(world.lattice_bodies[std::size_t(tool.body.index)].model.anatomy.lattice.spacing);
  return TouchedLattice{std::max({h.x, h.y, h.z}), std::sqrt(radius * depth)};
}

/// Expected error in percent; only a bound where it has no meaning.
std::string error_text(double error) {
  return error > sfem::kForceUnknown ? fmt::format("more than {:.0f}", 100 * sfem::kForceUnknown)
                                     : fmt::format("up to {:.0f}", 100 * error);
}

/// Smallest refinement with an acceptable error; 0 = none.
int sufficient_refinement(sfem::TouchedElements touched) {
  constexpr int kFinest = 4;
  for (touched.refinement++; touched.refinement <= kFinest; touched.refinement++)
    if (sfem::expected_error(touched) <= kMuch) return touched.refinement;
  return 0;
}

/// Empty if the error is acceptable or unknown.
std::string force_error_warning(const World& world, const TouchingTool& tool) {
  const auto touched = touched_elements(world, tool);
  if (!touched) return {};
  const double error = sfem::expected_error(*touched);
  if (error <= kMuch) return {};
  const int finer = sufficient_refinement(*touched);
  const std::string advice = finer > 0 ? fmt::format("patch.refinement = {} reduces that below", finer)
                                       : std::string("a finer mesh reduces that below");
  return fmt::format(
      "{}: the expected force error is {} %: element edges under it are {:.3g} mm, split into {} "
      "segments, for a contact radius of {:.3g} mm; {} {:.0f} %",
      tool.name, error_text(error), 1e3 * touched->edge, touched->refinement, 1e3 * touched->contact, advice,
      100 * kMuch);
}

/// Empty if the error is acceptable or unknown. The advised spacing keeps the error below the threshold.
std::string lattice_error_warning(const World& world, const TouchingTool& tool) {
  const auto touched = touched_lattice(world, tool);
  if (!touched) return {};
  const double error = lattice_force_error(touched->spacing, touched->contact);
  if (error <= kMuchOnLattice) return {};
  const double finer =
      touched->contact * std::pow((kMuchOnLattice - kLatticeError) / kSpacingError, 1 / kSpacingOrder);
  return fmt::format(
      "{}: the expected force error is {} %: the lattice's spacing is {:.3g} mm, for a contact radius of "
      "{:.3g} mm, and the force depends on where nodes are; "
      "a spacing of {:.2g} mm reduces that below {:.0f} %",
      tool.name, error_text(error), 1e3 * touched->spacing, 1e3 * touched->contact, 1e3 * finer,
      100 * kMuchOnLattice);
}

}  // namespace

std::optional<sfem::TouchedElements> touched_elements(const World& world, const TouchingTool& tool) {
  // only a loaded finite-element body has touched elements
  const double radius = radius_of(tool.tool.shape), depth = deepest(tool);
  if (tool.body.kind != BodyKind::kSfem || tool.tool.needle || depth <= 0 || radius <= 0) return {};
  const SfemBody& body = world.sfem_bodies[std::size_t(tool.body.index)];
  // contact radius by Hertz: sqrt(radius * depth)
  return sfem::touched_elements(body.model, body.now.patch->elements, body.refinement, body.follow.radius,
                                std::sqrt(radius * depth));
}

double lattice_force_error(double spacing, double contact) {
  TURGOR_CHECK(spacing > 0 && contact > 0, "a touched lattice has a spacing and a contact");
  return kLatticeError + kSpacingError * std::pow(spacing / contact, kSpacingOrder);
}

std::optional<double> expected_force_error(const World& world, const TouchingTool& tool) {
  if (const auto touched = touched_elements(world, tool)) return sfem::expected_error(*touched);
  if (const auto touched = touched_lattice(world, tool))
    return lattice_force_error(touched->spacing, touched->contact);
  return {};
}

std::vector<std::string> force_error_warnings(const World& world) {
  std::vector<std::string> sentences;
  for (const TouchingTool& tool : world.tools)
    for (std::string coarse : {force_error_warning(world, tool), lattice_error_warning(world, tool)})
      if (!coarse.empty()) sentences.push_back(std::move(coarse));
  return sentences;
}

}  // namespace turgor
