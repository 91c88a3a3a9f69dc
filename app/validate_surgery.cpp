#include "app/validate_surgery.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "app/commands.hpp"
#include "app/needle_block.hpp"
#include "app/validate_needle_lattice.hpp"
#include "app/validate_sutures.hpp"
#include "turgor/io/files/file.hpp"
#include "turgor/sim/report/plot.hpp"

namespace turgor {

namespace {

constexpr double kStep = 4e-5;  // of the tip in a tick [m]

/// A needle, its direction and the elements of the block.
struct InsertionCase {
  const char* name;
  double toughness, diameter, tilt, around;  // [J/m²] [m] [rad]
  bool is_quadratic;
};
constexpr InsertionCase kInsertions[] = {
    {"1.0 mm, upright, hexahedra", 164, 0.0010, 0, 0, false},
    {"1.8 mm, tilted by 17 degrees, hexahedra", 90, 0.0018, 0.3, 1.9, false},
    {"0.6 mm, tilted by 26 degrees, hexahedra", 260, 0.0006, 0.45, -0.8, false},
    {"1.2 mm, tilted by 11 degrees, quadratic", 130, 0.0012, 0.2, 2.5, true}};

/// Two insertions into one hole; mean forces between 15 and 25 mm.
struct DoubleInsertion {
  double found = 0;  // toughness [J/m²]
  double error_inside = 0, error_after = 0;
  double peak = 0;  // largest force before the puncture [N]
  double drop = 1;  // smallest force after it, relative to the peak
};
DoubleInsertion insert_twice(const sfem::InnerGreen& inner, const contact::Needle& needle,
                             const InsertionCase& c) {
  NeedlePush push = needle_above(inner, needle, {0.031, 0.028, 0.06}, c.tilt, c.around);
  DoubleInsertion result;
  std::array<double, 2> work{}, length{};
  for (std::size_t pass = 0; pass < 2; pass++) {
    double before = 0;
    push_to(push, 0.03, kStep, [&](double depth, double force) {
      if (depth > 0.015 && depth < 0.025)
        work[pass] += force * (depth - before), length[pass] += depth - before;
      before = depth;
      if (push.state.punctures == 0) result.peak = widest(result.peak, force);
      if (pass == 0 && push.state.inserted > 0.003) result.drop = narrowest(result.drop, force / result.peak);
    });
    if (pass == 0) result.error_inside = energy_error(push.state.work);
    push_to(push, -0.001, kStep);
  }
  result.error_after = energy_error(push.state.work);
  result.found = (work[0] / length[0] - work[1] / length[1]) / needle.diameter;
  return result;
}

void add_insertions(const Exec& exec, std::vector<Figure>& figures) {
  for (const InsertionCase& c : kInsertions) {
    const sfem::InnerGreen inner = required(inner_green_of(exec, {.is_quadratic = c.is_quadratic}));
    const contact::Needle needle{
        .diameter = c.diameter, .toughness = c.toughness, .entry_toughness = 1.6 * c.toughness};
    const DoubleInsertion found = insert_twice(inner, needle, c);
    const std::string name = fmt::format("needle of {}: ", c.name);
    figures.push_back(near_figure(name + "toughness from two insertions", "toughness of the tissue",
                                  found.found, c.toughness, 0.05));
    figures.push_back(near_figure(name + "force of the puncture", "entry toughness times diameter",
                                  found.peak, 1.6 * c.toughness * c.diameter, 0.03));
    figures.push_back(most_figure(name + "force after the puncture", "its peak", "1", found.drop, 0.95));
    for (const auto& [when, error] :
         {std::pair("30 mm deep", found.error_inside), std::pair("after two loops", found.error_after)})
      figures.push_back(most_figure(name + "energy " + when, "the hand's work", "1", std::abs(error), 0.01));
  }
}

/// Shares of the force in liver, 40 mm deep, separated by a second insertion as in the experiment.
void add_liver(const Exec& exec, const std::filesystem::path& folder, std::vector<Figure>& figures) {
  const sfem::InnerGreen inner = required(inner_green_of(exec, {}));
  NeedlePush push = needle_above(inner, {}, {0.031, 0.028, 0.06}, 0, 0);
  Plot plot{"A needle of 1 mm in liver", "depth of the tip [mm]", "force along the needle [N]", {}};
  const auto curve = [&](const char* name, double depth) {
    plot.curves.push_back({name, {}});
    double force = 0;
    push_to(push, depth, kStep, [&](double at, double f) {
      plot.curves.back().points.emplace_back(1e3 * at, f);
      if (std::abs(at - 0.036) < kStep) force = f;
    });
    return force;
  };
  // forces at one depth: tearing is the difference of two insertions, friction half of that between second
  // and out
  const double first = curve("first insertion", 0.04);
  (void)curve("withdrawal", -0.002);
  const double second = curve("second insertion", 0.04), out = curve("second withdrawal", -0.002);
  const double tearing = first - second, friction = (second - out) / 2, spreading = second - friction;
  const char* source = "bovine liver, Barnett 2015";
  figures.push_back({"liver: share of tearing", source, "%", 100 * tearing / first, 56, 66});
  figures.push_back({"liver: share of spreading", source, "%", 100 * spreading / first, 13, 23});
  figures.push_back({"liver: share of friction", source, "%", 100 * friction / first, 16, 26});
  plot.curves.resize(3);
  required(write_file(folder / "needle.svg", plot_svg_file(plot)));
}

/// A held needle for a minute.
void add_rest(const Exec& exec, bool quick, std::vector<Figure>& figures) {
  const sfem::InnerGreen inner = required(inner_green_of(exec, {}));
  NeedlePush push = needle_above(inner, {}, {0.031, 0.028, 0.06}, 0.25, 1.2);
  for (const double depth : {0.03, 0.029, 0.0293}) push_to(push, depth, kStep);
  const auto hold = [&](int ticks) {
    for (int i = 0; i < ticks; i++) tick_needle(inner, push.needle, {}, push.pose, 1, push.state);
  };
  hold(200);
  const Vec3d before = push.state.force;
  const double inserted = push.state.inserted;
  hold(quick ? 20000 : 60000);
  const char* name =
      quick ? "needle held for 20 s: change of the force" : "needle held for 60 s: change of the force";
  figures.push_back(most_figure(name, "no creep", "1", norm(push.state.force - before) / norm(before), 1e-5));
  figures.push_back(
      most_figure("needle held: creep", "no creep", "m", std::abs(push.state.inserted - inserted), 1e-9));
}

/// Suture needles through a sheet of skin whose toughness was measured with other needles. 0.5 and 0.7 mm are
/// usual with threads of 4-0 and 2-0.
void add_suture_needles(const Exec& exec, std::vector<Figure>& figures) {
  constexpr double kSkin = 1136, kThickness = 0.003;  // [J/m²] [m]
  NeedleBlock sheet{
      .size = {0.02, 0.02, kThickness}, .edge = kThickness / 2, .young = 1e6, .are_sides_held = true};
  const sfem::InnerGreen inner = required(inner_green_of(exec, sheet));
  for (const double diameter : {0.0005, 0.0007}) {
    const contact::Needle needle{
        .diameter = diameter, .toughness = kSkin, .entry_toughness = kSkin, .exit_toughness = kSkin};
    NeedlePush push = needle_above(inner, needle, {0.0105, 0.0092, kThickness}, 0, 0);
    double largest = 0;
    push_to(push, 0.01, kStep / 4, [&](double, double force) { largest = widest(largest, force); });
    const bool is_through = push.state.tracks[std::size_t(push.state.track)].is_through;
    figures.push_back({fmt::format("suture needle of {} mm through skin: largest force", 1e3 * diameter),
                       "human abdominal skin, Maloney", "N", is_through ? largest : 0, 0.48, 1.0});
    figures.push_back(most_figure(fmt::format("suture needle of {} mm through skin: energy", 1e3 * diameter),
                                  "the hand's work", "1", std::abs(energy_error(push.state.work)), 0.01));
  }
}

/// A needle as a wire in a long block whose sides are held: antiplane shear far from its ends.
void add_wire(const Exec& exec, bool quick, std::vector<Figure>& figures) {
  constexpr double kWidth = 0.048, kLength = 0.12, kPull = 1e-5;
  for (const double edge : quick ? std::vector<double>{0.012} : std::vector<double>{0.012, 0.008, 0.006}) {
    const Vec3d entry{kWidth / 2 + 0.3 * edge, kWidth / 2 + 0.55 * edge, kLength};
    NeedleBlock block{.size = {kWidth, kWidth, kLength}, .edge = edge, .are_sides_held = true, .axis = entry};
    const sfem::InnerGreen inner = required(inner_green_of(exec, block));
    for (const double diameter : {0.0005, 0.001}) {
      contact::Needle needle{.length = 0.15,
                             .diameter = diameter,
                             .toughness = 1e-3,
                             .entry_toughness = 1e-3,
                             .exit_toughness = 1e-3,
                             .friction = 0,
                             .spreading = 0};
      NeedlePush push = needle_above(inner, needle, entry, 0, 0);
      push_to(push, kLength + 0.004, 1e-4);
      push.needle.friction = 1e9;
      push_to(push, kLength + 0.004 + kPull, kPull / 10);
      double force = 0, engaged = 0;
      const contact::NeedleTrack& track = push.state.tracks[std::size_t(push.state.track)];
      for (std::size_t i = 1; i < track.points.size(); i++)
        if (track.points[i].arc > kLength / 3 && track.points[i].arc < 2 * kLength / 3)
          force -= track.force[i].z, engaged += track.points[i].engaged;
      const double shear = block.young / (2 * (1 + block.poisson));
      figures.push_back(near_figure(
          fmt::format("wire of {} mm, elements of {} mm: stiffness per length", 1e3 * diameter, 1e3 * edge),
          "2 pi G/ln(1.0787 b/a)", force / kPull / engaged,
          2 * std::numbers::pi * shear / std::log(1.0787 * kWidth / diameter), 0.05));
    }
  }
}

}  // namespace

std::vector<Figure> validate_surgery(const Exec& exec, bool quick, const std::filesystem::path& folder) {
  std::vector<Figure> figures;
  add_insertions(exec, figures);
  add_liver(exec, folder, figures);
  add_rest(exec, quick, figures);
  add_suture_needles(exec, figures);
  add_wire(exec, quick, figures);
  add_lattice_needles(exec, quick, figures);
  add_sutures(exec, quick, figures);
  return figures;
}

}  // namespace turgor
