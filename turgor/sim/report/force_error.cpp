#include "turgor/sim/report/force_error.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "turgor/core/assert.hpp"

namespace turgor {

namespace {

constexpr double kMuch = 0.10;  // warning threshold, relative

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
      tool.name,
      error > sfem::kForceUnknown ? fmt::format("more than {:.0f}", 100 * sfem::kForceUnknown)
                                  : fmt::format("up to {:.0f}", 100 * error),
      1e3 * touched->edge, touched->refinement, 1e3 * touched->contact, advice, 100 * kMuch);
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

std::vector<std::string> force_error_warnings(const World& world) {
  std::vector<std::string> sentences;
  for (const TouchingTool& tool : world.tools)
    if (std::string coarse = force_error_warning(world, tool); !coarse.empty())
      sentences.push_back(std::move(coarse));
  return sentences;
}

}  // namespace turgor
