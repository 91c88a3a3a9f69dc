// A disc cut out of dog skin, along and across the lines of tension (arXiv 1609.07267): a flat lattice of fat
// under tense skin that loses a disc. Two tensions are fitted to the specimen, and predict the wound.
#include <cmath>

#include <fmt/format.h>

#include "app/commands.hpp"
#include "app/measured_table.hpp"
#include "turgor/models/lattice/build/block_body.hpp"
#include "turgor/models/lattice/cutting/excision.hpp"
#include "turgor/models/lattice/lattice.hpp"
#include "turgor/models/lattice/specimen.hpp"

namespace turgor {

namespace {

constexpr const char* kDiscSource =
    "Deroy, Destrade, Mc Alinden, Ní Annaidh 2017 (Skin Research and Technology 23, 326; arXiv 1609.07267)";

/// Tensions fitted to the shrinkage of the specimen, with the default fiber law [N/m].
constexpr double kDiscTension[2] = {106, 37};
constexpr double kFatModulus = 1590;  // preset `fat` [Pa]
constexpr double kDiscDiameter = 0.04, kDiscDepth = 0.006, kFatThickness = 0.016, kPatchSide = 0.32;  // [m]

/// Flat patch of skin on fat, fixed at its sides and below.
lattice::Model disc_patch(double spacing) {
  lattice::Params params;
  params.tissue = {.law = lattice::TissueLaw::kSolid, .poisson = 0.45};
  params.skin.tension_along = kDiscTension[0], params.skin.tension_across = kDiscTension[1];
  params.skin.direction = {1, 0, 0};
  params.solver = {.sweeps = 5, .damping = 3};
  const int wide = int(std::lround(kPatchSide / spacing)) + 1,
            high = int(std::lround(kFatThickness / spacing)) + 1;
  lattice::Block block{.size = {wide, wide, high}, .spacing = spacing, .young = kFatModulus};
  block.is_fixed = [wide](Int3 p) {
    return p.x == 0 || p.y == 0 || p.z == 0 || p.x == wide - 1 || p.y == wide - 1;
  };
  return lattice::block_model(block, params);
}

/// Changes of size along and across, relative to the skin before the cut [%].
struct DiscChange {
  double along = 0, across = 0;
};
DiscChange disc_change(const lattice::OutlineSize& now, const lattice::OutlineSize& before) {
  return {100 * (now.length / before.length - 1), 100 * (now.width / before.width - 1)};
}

struct DiscChanges {
  DiscChange wound, specimen;
};
DiscChanges excise_disc(const Exec& exec, double spacing) {
  const lattice::Model model = disc_patch(spacing);
  lattice::State state = lattice::make_state(model);
  // outline, off the nodes of the lattice
  const Int3 size = model.anatomy.lattice.size;
  const double top = std::lround(kFatThickness / spacing) * spacing;
  const lattice::Excision disc{.center = {(size.x / 2 + 0.31) * spacing, (size.y / 2 + 0.17) * spacing, top},
                               .direction = {1, 0, 0},
                               .length = kDiscDiameter,
                               .width = kDiscDiameter};
  lattice::Incision blade{.name = "disc", .depth = kDiscDepth};
  blade.path = required(lattice::excision_outline(model, state, disc));
  blade.excision = disc;
  const lattice::BladePath path = required(lattice::lay_blade(model, state, blade));
  // cut at once; the specimen and the wound come to rest
  lattice::cut_edges(model, state, path, 0, 1, 0);
  const lattice::OutlineSize marked = lattice::opening_of(model, state, path).value().size;
  const lattice::Specimen specimen = required(lattice::excise_piece(exec, model, state, path, 0));
  for (int n = 0; n < 60; n++) lattice::step(exec, model, state, {}, 1.0 / 60);
  const lattice::OutlineSize wound = lattice::opening_of(model, state, path).value().size;
  return {disc_change(wound, marked), disc_change(specimen.free, specimen.in_place)};
}

}  // namespace

void add_disc(const Exec& exec, bool quick, MeasuredResult& result) {
  const double spacing = quick ? 0.005 : 0.004;  // [m]
  const DiscChanges found = excise_disc(exec, spacing);
  const auto add = [&](const char* subject, double measured, double predicted) {
    constexpr double kPoints = 4;  // half the band [%]
    result.rows.push_back(band_row(fmt::format("excised disc, fiber law, {} and {} N/m, cells of {} mm: {}",
                                               kDiscTension[0], kDiscTension[1], 1e3 * spacing, subject),
                                   kDiscSource, "%", measured, kPoints, predicted));
  };
  add("specimen along (fitted)", -23, found.specimen.along);
  add("specimen across (fitted)", -10, found.specimen.across);
  add("wound along", 16, found.wound.along);
  add("wound across", -10, found.wound.across);
}

}  // namespace turgor
