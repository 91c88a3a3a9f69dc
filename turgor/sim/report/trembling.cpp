#include "turgor/sim/report/trembling.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/format.h>

namespace turgor {

namespace {

constexpr double kTrembles = 0.05;         // warning threshold, relative to the mean force
constexpr std::size_t kFewestSamples = 8;  // of a rest
constexpr double kSlowest = 3;             // samples between two reversals: vibrations of a body are slower
constexpr double kStill = 1e-9;            // motion of a tool between two samples that rest [m]

struct Reading {
  double time = 0, force = 0;  // [s] [N]
};

bool is_at_rest(const ForceSample& a, const ForceSample& b) {
  return a.contacts > 0 && b.contacts > 0 && a.hold == b.hold && norm(b.position - a.position) < kStill;
}

/// Trembling of consecutive readings, without the first third, in which the body settles.
std::optional<Trembling> trembling_of(const std::vector<Reading>& rest) {
  const std::size_t first = rest.size() / 3, count = rest.size() - first;
  if (count < kFewestSamples) return {};
  Trembling found{.from = rest[first].time, .to = rest.back().time};
  // sum of the changes from one reversal to the next one
  double change = 0, at_reversal = rest[first].force;
  int reversals = 0;
  for (std::size_t n = first; n < rest.size(); n++) {
    const double force = rest[n].force;
    found.mean += force / double(count);
    if (n == first || n + 1 == rest.size()) continue;
    if ((force - rest[n - 1].force) * (rest[n + 1].force - force) >= 0) continue;
    if (reversals++ > 0) change += std::abs(force - at_reversal);
    at_reversal = force;
  }
  if (reversals < 3 || double(count) / reversals > kSlowest) return {};
  found.swing = 0.5 * change / (reversals - 1);
  return found;
}

}  // namespace

std::optional<Trembling> force_trembling(const TouchingTool& tool) {
  if (tool.body.kind != BodyKind::kLattice || tool.tool.needle) return {};
  std::optional<Trembling> most;
  std::vector<Reading> rest;
  const auto end_rest = [&] {
    const std::optional<Trembling> found = trembling_of(rest);
    if (found && found->swing > (most ? most->swing / most->mean : kTrembles) * found->mean) most = found;
    rest.clear();
  };
  const ForceSample* before = nullptr;
  for (const ForceSample& sample : tool.samples) {
    if (before && !is_at_rest(*before, sample)) end_rest();
    rest.push_back({sample.time, norm(sample.force)});
    before = &sample;
  }
  end_rest();
  return most;
}

std::string trembling_note(const World& world, const TouchingTool& tool) {
  const std::optional<Trembling> trembling = force_trembling(tool);
  if (!trembling) return {};
  const LatticeBody& body = world.lattice_bodies[std::size_t(tool.body.index)];
  return fmt::format(
      "{}: its force trembles by {:.0f} % around {:.3g} N while it rests, from {:.3g} to {:.3g} s: {} sweeps "
      "a "
      "frame do not converge; more body.{}.solver.sweeps",
      tool.name, 100 * trembling->swing / trembling->mean, trembling->mean, trembling->from, trembling->to,
      body.model.params.solver.sweeps, body.name);
}

}  // namespace turgor
