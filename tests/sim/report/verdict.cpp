#include "turgor/sim/report/verdict.hpp"

#include <gtest/gtest.h>

namespace turgor {
namespace {

/// A wound of 10 mm in skin of 40 N/m on a lattice of 5 mm, so that skin pulls with 0.2 N on a node. Its gape
/// changed by `change` [mm] within the last half second; `residual` [N] is the last one.
Json wound_report(double change, double residual) {
  Json series = Json::array();
  for (int n = 0; n <= 10; n++) series.push_back({0.1 * n, n == 10 ? 10 : 10 - change});
  Json report;
  report["bodies"] = {{{"name", "torso"}, {"model", "lattice"}, {"lattice_spacing_mm", {5.0, 5.0, 4.0}}}};
  report["wounds"] = {{{"name", "midline"},
                       {"body", "torso"},
                       {"tension_across_cut_N_per_m", 40},
                       {"tension_along_cut_N_per_m", 20},
                       {"series_columns", {"time_s", "gape_max_mm"}},
                       {"series", series}}};
  report["solver"] = {{"columns", {"time_s", "residual_largest_N"}},
                      {"samples", Json::array({{0.5, 0.1}, {1.0, residual}})}};
  return report;
}

// A gape that changes by less than 1 % is settled; the residual is compared with tension times spacing.
TEST(Verdict, SettledWoundAndSmallResidual) {
  const std::vector<std::string> said = verdict_of(wound_report(0.02, 0.004));
  ASSERT_EQ(said.size(), 2u);
  EXPECT_EQ(said[0], "The wound is settled: 0.02 mm in the last 0.5 s.");
  EXPECT_EQ(said[1], "The solver left 2 % of the skin's pull.");
}

// A gape that still changes, and a large residual, are said with what helps.
TEST(Verdict, UnsettledWoundNamesRemedy) {
  const std::vector<std::string> said = verdict_of(wound_report(0.5, 0.1));
  ASSERT_EQ(said.size(), 2u);
  EXPECT_EQ(
      said[0],
      "The wound is not settled: its gape changed by 0.50 mm in the last 0.5 s; a larger world.duration "
      "lets it settle.");
  EXPECT_EQ(said[1], "The solver left 50 % of the skin's pull: more solver.sweeps reduce it.");
}

// A wound that was cut just before the end cannot be judged.
TEST(Verdict, LateCutIsNotJudged) {
  Json report = wound_report(0, 0.001);
  report["wounds"][0]["series"] = Json::array({{0.8, 1.0}, {1.0, 1.0}});
  EXPECT_TRUE(verdict_of(report)[0].starts_with("The wound was cut less than 0.5 s before the end"));
}

// Bodies that fall without being touched: the fastest one is named, with its speed.
TEST(Verdict, RigidBodiesMoveOrRest) {
  Json report;
  report["bodies"] = {{{"name", "table"}, {"model", "rigid"}, {"speed_m_per_s", 0.0}},
                      {{"name", "stone"}, {"model", "rigid"}, {"speed_m_per_s", 0.25}}};
  EXPECT_EQ(verdict_of(report),
            std::vector<std::string>{"The rigid body 'stone' moves with 250 mm/s at the end."});
  report["bodies"][1]["speed_m_per_s"] = 2e-4;
  EXPECT_EQ(verdict_of(report), std::vector<std::string>{"The rigid bodies are at rest."});
}

// The largest force of all tools is said with its error; a limit of the model sends to the warnings.
TEST(Verdict, LargestForceAndLimits) {
  Json report;
  report["tools"] = {{{"name", "finger"},
                      {"force_max_N", 0.5},
                      {"force_max_at_s", 1.25},
                      {"force_error_expected_percent", 3.6}},
                     {{"name", "hook"}, {"force_max_N", 0.2}, {"force_max_at_s", 1.0}}};
  std::vector<std::string> said = verdict_of(report);
  ASSERT_EQ(said.size(), 2u);
  EXPECT_EQ(
      said[0],
      "The largest force is 0.50 N, on 'finger' at 1.25 s, with an error of about 4 % from the mesh under "
      "it; the mesh elsewhere is not counted.");
  EXPECT_EQ(said[1], "No force reached a limit of the model.");
  report["bodies"] = {{{"name", "liver"}, {"model", "sfem"}, {"surface_strain_max_percent", 28.0}}};
  EXPECT_EQ(verdict_of(report)[1],
            "The surface of 'liver' was strained by 28 %, beyond its linear law: see the warnings.");
  report["bodies"][0]["surface_strain_max_percent"] = 9.0;
  EXPECT_EQ(verdict_of(report)[1], "No force reached a limit of the model.");
  report["tools"][1]["slips"] = 1;
  said = verdict_of(report);
  EXPECT_EQ(said[1], "Forces on 'hook' reached a limit of the model: see the warnings.");
}

/// Cloth with edges of 10 mm whose fastest point has this speed [m/s].
Json cloth_report(double speed) {
  Json report;
  report["bodies"] = {{{"name", "flag"},
                       {"model", "cloth"},
                       {"mean_edge_mm", 10},
                       {"largest_residual_relative", 0.002},
                       {"triangles_crossing", 0},
                       {"series_columns", {"time_s", "largest_speed_m_per_s"}},
                       {"series", Json::array({{0.1, 3.0}, {0.6, speed}, {1.0, speed}})}}};
  return report;
}

// Cloth rests if it moves less than a tenth of an edge in the window: 2 mm/s for edges of 10 mm.
TEST(Verdict, ClothRestsOrMoves) {
  EXPECT_EQ(verdict_of(cloth_report(0.001))[0],
            "The cloth is at rest: its fastest point had 1.00 mm/s in the last 0.5 s.");
  EXPECT_EQ(verdict_of(cloth_report(0.5))[0],
            "The cloth still moves: its fastest point had 500 mm/s in the last 0.5 s.");
  EXPECT_EQ(verdict_of(cloth_report(0.5))[1],
            "The solver left at most 0.2 % of a step's load, and no triangles intersect.");
}

// A run without results has a verdict too, and so has one that ended early.
TEST(Verdict, IsNeverEmpty) {
  EXPECT_EQ(verdict_of(Json::object()).size(), 1u);
  EXPECT_EQ(verdict_of({{"stopped", "not finite"}})[0], "The run stopped early: not finite.");
}

}  // namespace
}  // namespace turgor
