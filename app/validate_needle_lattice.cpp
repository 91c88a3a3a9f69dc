#include "app/validate_needle_lattice.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <tuple>

#include <fmt/format.h>

#include "app/commands.hpp"
#include "app/needle_block.hpp"
#include "app/needle_in_lattice.hpp"

namespace turgor {

namespace {

constexpr double kSlow = 1e-4;  // of the tip in a frame [m]

double balance_error(const contact::NeedleWork& work) {
  return (work.cutting + work.friction + work.spreading + work.elastic) / work.hand - 1;
}

/// A needle, its direction and the cells of the block.
struct LatticeInsertion {
  const char* name;
  double toughness, diameter, tilt, around;  // [J/m²] [m] [rad]
  Int3 nodes;
  double spacing;  // [m]
};
constexpr LatticeInsertion kLatticeInsertions[] = {
    {"1.0 mm, upright, cells of 4 mm", 90, 0.0010, 0, 0, {15, 15, 11}, 0.004},
    {"1.3 mm, tilted by 17 degrees, cells of 4 mm", 70, 0.0013, 0.3, -0.8, {15, 15, 11}, 0.004},
    {"0.8 mm, tilted by 23 degrees, cells of 5 mm", 120, 0.0008, 0.4, 1.9, {13, 13, 10}, 0.005}};

/// Two insertions into one hole, 24 mm deep, and withdrawals.
void add_loops(const Exec& exec, const LatticeInsertion& c, std::vector<Figure>& figures) {
  LatticeUnderNeedles body = build_block({.nodes = c.nodes, .spacing = c.spacing});
  const double width = (c.nodes.x - 1) * c.spacing;
  const contact::Needle needle{.diameter = c.diameter,
                               .toughness = c.toughness,
                               .entry_toughness = 1.6 * c.toughness,
                               .spreading = 2e4};
  std::vector<LatticeNeedlePush> pushes{
      needle_above(needle, {0.52 * width, 0.47 * width, top_of(body)}, c.tilt, c.around)};
  LatticeNeedlePush& push = pushes[0];
  step_needles(exec, body, pushes);
  std::array<double, 2> mean{}, error{};
  for (std::size_t pass = 0; pass < 2; pass++) {
    int frames = 0;
    push_to(exec, body, pushes, 0.024, kSlow, [&] {
      if (depth_of(push) > 0.015 && depth_of(push) < 0.022) mean[pass] += force_on(push), frames++;
    });
    mean[pass] /= frames;
    push_to(exec, body, pushes, -0.003, kSlow);
    error[pass] = balance_error(push.state.work);
  }
  const std::string name = fmt::format("needle in a lattice, {}: ", c.name);
  figures.push_back(near_figure(name + "force of the puncture", "entry toughness times diameter",
                                push.state.entry_force, 1.6 * c.toughness * c.diameter, 1e-6));
  figures.push_back(near_figure(name + "toughness from two insertions", "toughness of the tissue",
                                (mean[0] - mean[1]) / c.diameter, c.toughness, 0.05));
  figures.push_back(
      most_figure(name + "energy after a loop", "the hand's work", "1", std::abs(error[0]), 0.01));
  figures.push_back(
      most_figure(name + "energy after two loops", "the hand's work", "1", std::abs(error[1]), 0.02));
}

/// Friction of a shaft without spreading in its old track: f times the length, in and out.
void add_friction(const Exec& exec, std::vector<Figure>& figures) {
  LatticeUnderNeedles body = build_block({});
  const contact::Needle needle{.toughness = 60, .entry_toughness = 90, .friction = 2.3, .spreading = 0};
  std::vector<LatticeNeedlePush> pushes{needle_above(needle, {0.030, 0.026, top_of(body)}, 0.25, 2.2)};
  LatticeNeedlePush& push = pushes[0];
  step_needles(exec, body, pushes);
  for (const double depth : {0.02, -0.004}) push_to(exec, body, pushes, depth, 5e-4);
  for (const auto& [to, at, sign] : {std::tuple(0.015, 0.0155, 1.0), std::tuple(0.008, 0.0075, -1.0)}) {
    // the last frames are short, because a frame has the length of the one before
    push_to(exec, body, pushes, to, 5e-4), push_to(exec, body, pushes, at, 2.5e-5);
    figures.push_back(near_figure(
        fmt::format("needle in a lattice, in an old track, pushed {}: friction", sign > 0 ? "in" : "out"),
        "f times the length", force_on(push), sign * needle.friction * push.state.inserted, 0.01));
  }
}

/// A held needle for a minute.
void add_lattice_rest(const Exec& exec, bool quick, std::vector<Figure>& figures) {
  const int seconds = quick ? 10 : 60;
  LatticeUnderNeedles body = build_block({});
  std::vector<LatticeNeedlePush> pushes{
      needle_above({.toughness = 60, .entry_toughness = 90}, {0.030, 0.026, top_of(body)}, 0.2, 0.3)};
  const contact::LatticeNeedle& needle = pushes[0].state;
  step_needles(exec, body, pushes);
  for (const double depth : {0.02, 0.0192}) push_to(exec, body, pushes, depth, 2.5e-4);
  const auto hold = [&](int frames) {
    for (int i = 0; i < frames; i++) step_needles(exec, body, pushes);
  };
  hold(80);
  const Vec3d before = needle.force;
  const double inserted = needle.inserted;
  hold(60 * seconds);
  figures.push_back(
      most_figure(fmt::format("needle in a lattice, held for {} s: change of the force", seconds), "no creep",
                  "1", norm(needle.force - before) / norm(before), 1e-5));
  figures.push_back(most_figure("needle in a lattice, held: creep", "no creep", "m",
                                std::abs(needle.inserted - inserted), 1e-9));
}

/// Mean force between two depths of a first insertion, and the puncture's.
struct InsertionForce {
  double puncture = 0, mean = 0;  // [N]
};

/// Force over depth of the same needle in the same block of finite elements, in shorter steps, because its
/// largest force is that of the tick before the puncture.
void add_comparison(const Exec& exec, std::vector<Figure>& figures) {
  constexpr double kFrom = 0.012, kTo = 0.024;
  const contact::Needle needle{.toughness = 60, .entry_toughness = 120, .spreading = 2e4};
  struct Case {
    Int3 nodes;
    double spacing, edge, tilt;
  };
  for (const Case c : {Case{{15, 15, 11}, 0.004, 0.008, 0}, Case{{13, 13, 9}, 0.005, 0.01, 0.3}}) {
    LatticeUnderNeedles body = build_block({.nodes = c.nodes, .spacing = c.spacing});
    const Vec3d size{(c.nodes.x - 1) * c.spacing, (c.nodes.y - 1) * c.spacing, (c.nodes.z - 1) * c.spacing};
    const Vec3d at{0.54 * size.x, 0.47 * size.y, 0};
    // lattice
    std::vector<LatticeNeedlePush> pushes{needle_above(needle, at + Vec3d{0, 0, top_of(body)}, c.tilt, 0.7)};
    LatticeNeedlePush& push = pushes[0];
    step_needles(exec, body, pushes);
    std::array<InsertionForce, 2> found;
    int frames = 0;
    push_to(exec, body, pushes, 0.03, kSlow, [&] {
      if (push.state.inserted > kFrom && push.state.inserted < kTo) found[0].mean += force_on(push), frames++;
    });
    found[0] = {push.state.entry_force, found[0].mean / std::max(1, frames)};
    // finite elements
    const sfem::InnerGreen inner =
        required(inner_green_of(exec, {.size = size, .edge = c.edge, .young = 1e4}));
    NeedlePush reference = needle_above(inner, needle, at + Vec3d{0, 0, size.z}, c.tilt, 0.7);
    int ticks = 0;
    push_to(reference, 0.03, kSlow / 10, [&](double, double force) {
      if (reference.state.punctures == 0) found[1].puncture = widest(found[1].puncture, force);
      if (reference.state.inserted > kFrom && reference.state.inserted < kTo) found[1].mean += force, ticks++;
    });
    found[1].mean /= std::max(1, ticks);
    const std::string name =
        fmt::format("needle in a lattice of {} mm, tilted by {:.0f} degrees: ", 1e3 * c.spacing,
                    c.tilt * 180 / std::numbers::pi);
    const char* against = "the same block of finite elements";
    figures.push_back(
        near_figure(name + "force of the puncture", against, found[0].puncture, found[1].puncture, 0.01));
    figures.push_back(
        near_figure(name + "mean force at 12 to 24 mm", against, found[0].mean, found[1].mean, 0.05));
  }
}

/// A needle far into a long block whose sides are held: antiplane shear.
void add_lattice_wire(const Exec& exec, std::vector<Figure>& figures) {
  const LatticeNeedleBlock block{
      .nodes = {9, 9, 21}, .spacing = 0.006, .are_sides_fixed = true, .sweeps = 20};
  LatticeUnderNeedles body = build_block(block);
  const double width = (block.nodes.x - 1) * block.spacing;
  const contact::Needle needle{.length = 0.15,
                               .diameter = 0.0009,
                               .toughness = 5,
                               .entry_toughness = 5,
                               .friction = 0,
                               .spreading = 0};
  std::vector<LatticeNeedlePush> pushes{
      needle_above(needle, {0.52 * width, 0.47 * width, top_of(body)}, 0, 0)};
  LatticeNeedlePush& push = pushes[0];
  step_needles(exec, body, pushes);
  push_to(exec, body, pushes, 0.118, 1e-3);
  push.needle.friction = 1e9;
  for (int frame = 0; frame < 5; frame++) step_needles(exec, body, pushes);
  push_to(exec, body, pushes, depth_of(push) + 1e-4, 1e-5);
  for (int frame = 0; frame < 60; frame++) step_needles(exec, body, pushes);
  double force = 0, engaged = 0;
  for (const contact::LatticeNeedlePoint& point : push.state.tracks[std::size_t(push.state.track)].points)
    if (point.arc > 0.04 && point.arc < 0.08 && point.engaged > 0)
      force -= point.force.z, engaged += point.engaged;
  const double shear = block.young / (2 * (1 + block.poisson));
  figures.push_back(near_figure("needle as a wire in a lattice of 6 mm: stiffness per length",
                                "2 pi G/ln(1.0787 b/a)", force / 1e-4 / engaged,
                                2 * std::numbers::pi * shear / std::log(1.0787 * width / needle.diameter),
                                0.1));
}

/// Two needles at mirrored positions of one block.
void add_two_needles(const Exec& exec, std::vector<Figure>& figures) {
  const LatticeNeedleBlock block{};
  LatticeUnderNeedles body = build_block(block);
  const double width = (block.nodes.x - 1) * block.spacing;
  const contact::Needle needle{.toughness = 60, .entry_toughness = 120, .spreading = 2e4};
  std::vector<LatticeNeedlePush> pushes;
  for (const double side : {-1.0, 1.0})
    pushes.push_back(needle_above(needle, {width / 2 + side * 0.009, width / 2, top_of(body)}, 0.2,
                                  side > 0 ? 0 : std::numbers::pi));
  step_needles(exec, body, pushes);
  double apart = 0, most = 0;
  push_to(exec, body, pushes, 0.02, kSlow, [&] {
    apart = widest(apart, std::abs(force_on(pushes[0]) - force_on(pushes[1])));
    most = widest(most, force_on(pushes[0]));
  });
  figures.push_back(most_figure("two needles in a lattice: difference of their forces over the largest",
                                "mirror symmetry", "1", apart / most, 0.02));
}

}  // namespace

void add_lattice_needles(const Exec& exec, bool quick, std::vector<Figure>& figures) {
  for (const LatticeInsertion& c : kLatticeInsertions) add_loops(exec, c, figures);
  add_friction(exec, figures);
  add_lattice_rest(exec, quick, figures);
  add_comparison(exec, figures);
  add_lattice_wire(exec, figures);
  add_two_needles(exec, figures);
}

}  // namespace turgor
