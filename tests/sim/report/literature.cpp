#include "turgor/sim/report/literature.hpp"

#include <gtest/gtest.h>

#include "turgor/sim/report/page.hpp"

namespace turgor {
namespace {

// Published values are found by the kind of item and the key; other keys have none.
TEST(Literature, ValuesHaveTheirSource) {
  EXPECT_EQ(
      published_measure("suture", "closing_force_N"),
      "closed directly up to 5.4; median of those not closed 6.0 (dogs; Lackmann, Rohwedder, Maron et al. "
      "2023, Tierärztliche Praxis K 51, 386)");
  EXPECT_EQ(
      published_measure("wound", "tension_across_cut_N_per_m"),
      "5.6 to 138 (human, living; Flynn, Taberner, Nielsen 2011 (Biomechanics and Modeling in "
      "Mechanobiology 10, 27); Flynn, Taberner, Nielsen 2011 (Annals of Biomedical Engineering 39, 1935))");
  EXPECT_EQ(published_parameter("body.torso.skin.tension"),
            published_measure("wound", "tension_across_cut_N_per_m"));
  EXPECT_NE(published_parameter("tool.needle.shape.toughness").find("doi 10.1186/s10033-022-00767-4"),
            std::string::npos);
  for (const char* key : {"", "body.torso", "body.torso.skin.stiffness", "tool.torso.skin.tension"})
    EXPECT_EQ(published_parameter(key), "") << key;
  EXPECT_EQ(published_measure("wound", "gape_max_mm"), "");
}

// A table has the column only if one of its rows has a published value.
TEST(Literature, ColumnStandsBesideResults) {
  const std::vector<Caption> captions{
      {"gape_max_mm", "gape", units::kMillimeters, kInTable, ""},
      {"specimen.length_change_percent", "shrinkage", units::kPercent, kInTable, ""}};
  const auto table = [&captions](const Json& wound) {
    return page::quantity_table(Json::array({wound}), "wound", captions);
  };
  EXPECT_EQ(table({{"name", "cut"}, {"gape_max_mm", 3}}).find("literature"), std::string::npos);
  const std::string html =
      table({{"name", "cut"}, {"gape_max_mm", 3}, {"specimen", {{"length_change_percent", -10}}}});
  EXPECT_NE(html.find("<th>cut</th><th>literature</th>"), std::string::npos) << html;
  EXPECT_NE(html.find("<td>-10</td><td>-17.0 (people, 111 excisions; doi 10.1111/cup.12401)</td>"),
            std::string::npos)
      << html;
  EXPECT_NE(html.find("<td>3</td><td></td>"), std::string::npos) << html;
}

}  // namespace
}  // namespace turgor
