// Reference scene: a block of 48×48×10 nodes, 4 mm apart, 5 kPa, sides and bottom fixed, skin on top, one
// straight cut of 15 cells, 2.5 cells deep. Results of an independent program: area law 36.8 mm; fiber law
// 12.0, 7.2 and 17.5 mm.
#include <cmath>
#include <cstdio>
#include <tuple>

#include <gtest/gtest.h>

#include "tests/models/lattice/block_body.hpp"
#include "turgor/models/lattice/cutting/incision.hpp"
#include "turgor/models/lattice/lattice.hpp"

namespace turgor::lattice {
namespace {

constexpr int kN = 48, kDepthNodes = 10, kCutSteps = 15;
constexpr double kStep = 0.004;

/// Tension in the CT of the reference's skin, which is given by its rest stretch r = 1 − T/K with an
/// amplification of 2.
double tension_of(SkinLaw law, double reference) {
  const double e = reference / 300, r = 1 - e;
  return law == SkinLaw::kFiber ? 300 * e * (1 + 2 * e / r) : 300 * e / r * (1 + 2 * e / r);
}

Model reference_model(SkinLaw law, double along, double across, int sweeps) {
  Block block{.size = {kN, kN, kDepthNodes}, .spacing = kStep, .young = 5e3};
  block.is_fixed = [](Int3 p) { return p.z == 0 || p.x == 0 || p.y == 0 || p.x == kN - 1 || p.y == kN - 1; };
  Params params;
  params.skin = {.law = law,
                 .tension_along = tension_of(law, along),
                 .tension_across = tension_of(law, across),
                 .stiffness = 300,
                 .shear = 100,
                 .amplification = 2,
                 .direction = {1, 0, 0}};
  params.solver = {.sweeps = sweeps, .damping = -60 * std::log(0.98)};
  Model model = block_model(block, params);
  // The reference has springs of 0.4 E h / √(number of axes) instead of calibrated ones, and 1000 kg/m³
  // everywhere.
  for (std::size_t f = 0; f < kFamilyCount; f++)
    model.springs.scale[f] = Real(0.4 * kStep * kStep / double(model.springs.rest_length[f]));
  // The reference's skin lies in the outermost nodes, so the drawn skin, where lips are measured, is moved to
  // them.
  for (int j = 0; j < kN; j++)
    for (int i = 0; i < kN; i++)
      model.anatomy.hu[std::size_t(node_slot(model.anatomy.lattice, i, j, kDepthNodes - 1))] =
          std::int16_t(params.tissue.air_max);
  return model;
}

struct Settled {
  double largest_gape;  // at the skin, perpendicular to the cut, as in the reference [m]
  Wound wound;
};

Settled settle(const Model& model, double seconds) {
  const Exec exec(2);
  State state = make_state(model);
  const double y = (kN / 2 - 0.5) * kStep, x = (kN / 2 - kCutSteps / 2 - 0.5) * kStep,
               z = (kDepthNodes - 1) * kStep;
  // The reference does not cut edges that only touch the blade's border, so the blade is slightly smaller.
  constexpr double kHair = 0.01 * kStep;
  const Incision incision{
      .from = {x + kHair, y, z}, .to = {x + kCutSteps * kStep - kHair, y, z}, .depth = 2.5 * kStep - kHair};
  const BladePath path = lay_blade(model, state, incision).value();
  cut_edges(model, state, path, 0, 1, 0);
  for (int frame = 0; frame < seconds * 60; frame++) step(exec, model, state, {}, 1.0 / 60);
  Settled settled{0, measure_wound(model, state, path, 0)};
  for (int i = 0; i < kN; i++) {
    const Vec3 a = position(model, state.motion, {i, kN / 2 - 1, kDepthNodes - 1});
    const Vec3 b = position(model, state.motion, {i, kN / 2, kDepthNodes - 1});
    settled.largest_gape = std::max(settled.largest_gape, double(b.y - a.y) - kStep);
  }
  return settled;
}

/// Duration after which a wound has come to rest [s].
double time_of_rest(int sweeps) { return sweeps > 20 ? 1 : 3; }

// Area skin gapes as the reference for any number of sweeps.
TEST(LatticeWound, AreaSkinMatchesReference) {
  for (const int sweeps : {5, 20, 100}) {
    const Settled settled = settle(reference_model(SkinLaw::kArea, 45, 45, sweeps), time_of_rest(sweeps));
    std::printf("  %3d sweeps: %.2f mm\n", sweeps, settled.largest_gape * 1e3);
    EXPECT_NEAR(settled.largest_gape, 0.0368, 0.02 * 0.0368) << sweeps << " sweeps";
  }
}

// Fiber skin gapes as the reference, least along the tension lines.
TEST(LatticeWound, FiberSkinMatchesReference) {
  struct Case {
    double along, across, gape;
  };
  for (const auto& [along, across, gape] : {Case{45, 45, 0.0120}, {60, 30, 0.0072}, {30, 60, 0.0175}}) {
    for (const int sweeps : {5, 40}) {
      const Settled settled =
          settle(reference_model(SkinLaw::kFiber, along, across, sweeps), time_of_rest(sweeps));
      std::printf("  %4.1f / %4.1f N/m, %3d sweeps: %.2f mm\n", tension_of(SkinLaw::kFiber, along),
                  tension_of(SkinLaw::kFiber, across), sweeps, settled.largest_gape * 1e3);
      EXPECT_NEAR(settled.largest_gape, gape, 0.02 * gape)
          << along << "/" << across << " N/m, " << sweeps << " sweeps";
      EXPECT_NEAR(settled.wound.gape_max, gape, 0.03 * gape) << "as measured along the cut";
      EXPECT_GT(settled.wound.opening_area, 0.5 * gape * settled.wound.length);
      EXPECT_LT(settled.wound.opening_area, gape * settled.wound.length);
    }
  }
}

// Sweeps by colors match the reference too.
TEST(LatticeWound, ColorsMatchReference) {
  for (const auto& [law, along, across, sweeps, gape] :
       {std::tuple{SkinLaw::kArea, 45.0, 45.0, 20, 0.0368}, {SkinLaw::kFiber, 60.0, 30.0, 5, 0.0072}}) {
    Model model = reference_model(law, along, across, sweeps);
    model.params.solver.ordering = Ordering::kColors;  // the VBD model is that of slabs
    const Settled settled = settle(model, 3);
    std::printf("  law %d, %3d sweeps: %.2f mm\n", int(law), sweeps, settled.largest_gape * 1e3);
    EXPECT_NEAR(settled.largest_gape, gape, 0.02 * gape) << "law " << int(law);
  }
}

/// A tense block whose skin faces along an axis or against it, with a cut along one of the two other axes.
struct Lying {
  int up;
  bool away, across;
};

/// Air above, sides and bottom fixed; the last component of `size` is the depth.
BodyNodes lying_block(Int3 size, const Lying& lying) {
  const int axes[3] = {(lying.up + 1) % 3, (lying.up + 2) % 3, lying.up};
  BodyNodes nodes;
  for (int q = 0; q < 3; q++) nodes.grid.size[axes[q]] = size[q] + (q == 2);
  nodes.grid.spacing = {kStep, kStep, kStep};
  for (int k = 0; k < nodes.grid.size.z; k++)
    for (int j = 0; j < nodes.grid.size.y; j++)
      for (int i = 0; i < nodes.grid.size.x; i++) {
        const Int3 node{i, j, k};
        Int3 p{node[axes[0]], node[axes[1]], node[axes[2]]};
        if (lying.away) p.z = size.z - p.z;
        const bool air = p.z == size.z, side = p.x == 0 || p.y == 0 || p.x == size.x - 1 || p.y == size.y - 1;
        nodes.hu.push_back(air ? kAirHu : 0);
        nodes.tissue.push_back(air ? Tissue::kOutside : Tissue::kMuscle);
        nodes.young.push_back(air ? 0 : 5e3f);
        nodes.fixed.push_back(!air && (side || p.z == 0));
      }
  return nodes;
}

/// Displacement of the lips after a second of projections, which do not come to rest [m].
double lips_by_projections(Ordering ordering, Int3 size, const Lying& lying) {
  Params params;
  params.solver = {.method = Method::kPbd, .ordering = ordering};
  params.skin.law = SkinLaw::kArea;
  const Model model = assemble(Exec(1), lying_block(size, lying), nullptr, params).value();
  State state = make_state(model);
  const int axes[3] = {(lying.up + 1) % 3, (lying.up + 2) % 3, lying.up};
  const auto point = [&](double along, double beside) {
    Vec3d p;
    p[axes[lying.across]] = (size[lying.across] / 2 + 0.5 + along) * kStep;
    p[axes[!lying.across]] = (size[!lying.across] / 2 + 0.5 + beside) * kStep;
    p[axes[2]] = (lying.away ? 1 : size.z - 1) * kStep;
    return p;
  };
  const BladePath path =
      lay_blade(model, state, {.from = point(-5, 0), .to = point(5, 0), .depth = 2.5 * kStep}).value();
  EXPECT_GT(cut_edges(model, state, path, 0, 1, 0), 40);
  for (int frame = 0; frame < 60; frame++) step(Exec(2), model, state, {}, 1.0 / 60);
  return measure_wound(model, state, path, 0).edge_displacement;
}

// With PBD by colors, lips open alike for any orientation of the body; by slabs they do not.
TEST(LatticeWound, PbdByColorsIsIsotropic) {
  double least[2] = {1, 1}, most[2] = {};
  for (const Lying& lying : {Lying{0, false, false},
                             {0, true, true},
                             {1, false, true},
                             {1, true, false},
                             {2, false, false},
                             {2, true, true}})
    for (const Ordering ordering : {Ordering::kSlabs, Ordering::kColors}) {
      const double lips = lips_by_projections(ordering, {25, 29, 8}, lying);
      std::printf("  skin faces %d%s, cut %d: %.3f mm by %s\n", lying.up, lying.away ? " away" : "",
                  lying.across, 1e3 * lips, ordering == Ordering::kSlabs ? "slabs" : "colors");
      least[int(ordering)] = std::min(least[int(ordering)], lips);
      most[int(ordering)] = std::max(most[int(ordering)], lips);
    }
  EXPECT_LT(most[1], 1.15 * least[1]) << "m, colors";
  EXPECT_GT(most[0], 1.3 * least[0]) << "m, slabs, see docs/models/lattice.md";
}

// The error for a blade off the body states the extent of the body and its nearest point.
TEST(LatticeWound, BladeOffBody_ReportsBodyExtent) {
  const Model model = reference_model(SkinLaw::kFiber, 45, 45, 1);
  const auto outside =
      lay_blade(model, make_state(model), {.name = "a", .from = {0.1, 0.1, 0.536}, .to = {0.14, 0.1, 0.536}});
  ASSERT_FALSE(outside);
  const std::string& message = outside.error().message;
  for (const char* text :
       {"of (0.1, 0.1, 0.536) m", "the body is between (0, 0, 0.036) m and (0.188, 0.188, 0.036) m",
        "its nearest point, (0.1, 0.1, 0.036) m, is 0.5 m away"})
    EXPECT_NE(message.find(text), std::string::npos) << text << " is not in: " << message;
}

// A blade without length, or with an end off the skin, is rejected.
TEST(LatticeWound, RejectsBladeWithoutSkinOrLength) {
  const Model model = reference_model(SkinLaw::kFiber, 45, 45, 1);
  const State state = make_state(model);
  const Vec3d on{0.1, 0.1, 0.036};
  const auto no_length = lay_blade(model, state, {.name = "a", .from = on, .to = on});
  ASSERT_FALSE(no_length);
  EXPECT_NE(no_length.error().message.find("same point"), std::string::npos);
  const auto outside = lay_blade(model, state, {.name = "a", .from = on, .to = {0.5, 0.1, 0.036}});
  ASSERT_FALSE(outside);
  EXPECT_NE(outside.error().message.find("no skin within 0.1 m of (0.19, 0.1, 0.036) m"), std::string::npos)
      << outside.error().message;
}

}  // namespace
}  // namespace turgor::lattice
