#include "turgor/sim/report/quantity.hpp"

#include <set>

#include <gtest/gtest.h>

#include "turgor/sim/report/amount.hpp"
#include "turgor/sim/report/page.hpp"
#include "turgor/sim/report/section.hpp"

namespace turgor {
namespace {

/// A measured wound with one member and one table row per quantity.
struct Scar {
  std::string name;
  double width = 0;  // [m]
  int stitches = 0;
  double healed_at = -1;  // [s]
};
const Quantity<Scar> kScar[] = {
    {"name", units::kNone, "", [](const Scar& s) -> Json { return s.name; }, kInReport},
    {"size.width", units::kMillimeters, "width", [](const Scar& s) -> Json { return s.width; }, kEverywhere,
     "width of {}"},
    {"stitches", units::kCount, "stitches", [](const Scar& s) -> Json { return s.stitches; }},
    {"healed_at", units::kSeconds, "healed at",
     [](const Scar& s) { return s.healed_at < 0 ? absent() : Json(s.healed_at); }},
};

// One row of a table yields the JSON key with its unit, a row of the page and a key figure.
TEST(Quantity, RowYieldsKeyTableAndFigure) {
  const Json json = Json::array(
      {values_of(kScar, Scar{"left", 0.0123456789, 5}), values_of(kScar, Scar{"right", 0.004, 2, 3600})});
  EXPECT_EQ(json[0].dump(), R"({"name":"left","size":{"width_mm":12.3457},"stitches":5})");
  EXPECT_EQ(json[1]["healed_at_s"], 3600.0);
  const std::vector<Caption> captions = captions_of(kScar);
  const std::string table = page::quantity_table(json, "scar", captions);
  EXPECT_NE(table.find("<td>width [mm]</td><td>12.3</td><td>4.00</td>"), std::string::npos) << table;
  EXPECT_NE(table.find("<td>stitches</td><td>5</td><td>2</td>"), std::string::npos) << table;
  EXPECT_NE(table.find("<td>healed at [s]</td><td>–</td><td>3600</td>"), std::string::npos) << table;
  const std::string figures = page::quantity_figures(json, captions, page::Figures::kResults);
  EXPECT_NE(figures.find("<b>12.3 mm</b><span>width of left</span>"), std::string::npos) << figures;
}

// A series names its columns, and a curve finds them by name.
TEST(Quantity, CurveFindsColumnsByName) {
  Json json;
  add_rows(json, "columns", "rows", kScar,
           std::vector<Scar>{{"a", 0.001, 1}, {"b", 0.002, 2}, {"c", 0.003, 3}}, 2);
  EXPECT_EQ(json["columns"].dump(), R"(["name","size.width_mm","stitches","healed_at_s"])");
  const page::SeriesKeys keys{"columns", "rows"};
  const Curve curve = page::curve_of("x", json, keys, "stitches", "size.width_mm");
  EXPECT_EQ(curve.points, (std::vector<std::pair<double, double>>{{1, 1}, {3, 3}}));
  EXPECT_TRUE(page::curve_of("x", json, keys, "stitches", "depth_mm").points.empty());
}

// Amounts are printed in a suitable multiple of their unit.
TEST(Quantity, AmountsUseSuitableUnit) {
  const auto text = [](double value, const Unit& unit) { return amount(Json(value), unit); };
  EXPECT_EQ(text(1330, units::kMicroseconds), "1.33 ms");
  EXPECT_EQ(text(1.33e6, units::kMicroseconds), "1.33 s");
  EXPECT_EQ(text(999, units::kMicroseconds), "999 µs");
  EXPECT_EQ(text(1330, units::kMilliseconds), "1.33 s");
  EXPECT_EQ(text(2.5e6, units::kSeconds), "2.5e+06 s");
  EXPECT_EQ(amount(Json(123456789), units::kBytes), "123 MB");
  EXPECT_EQ(text(0.0123, units::kNewtons), "0.01 N");
  EXPECT_EQ(text(45, units::kDegrees), "45.0°");
  EXPECT_EQ(amount(Json(7), units::kCount), "7");
  EXPECT_EQ(amount(Json("descent"), units::kNone), "descent");
  EXPECT_EQ(amount(Json(), units::kNewtons), "");
}

// No section of a report has a key twice.
TEST(Quantity, KeysAreUniqueInSection) {
  for (const Section& section : report_sections()) {
    std::set<std::string> keys;
    for (const Caption& caption : section.captions) {
      EXPECT_TRUE(keys.insert(caption.key).second) << section.item << ": " << caption.key;
      EXPECT_EQ(caption.label.empty(), caption.shown_in == kInReport)
          << section.item << ": " << caption.key << ": displayed quantities have a caption";
    }
  }
}

}  // namespace
}  // namespace turgor
