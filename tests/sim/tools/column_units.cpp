#include "turgor/sim/tools/column_units.hpp"

#include <gtest/gtest.h>

#include "tests/refused.hpp"

namespace turgor {
namespace {

// Brackets, `_`, `/` and a known word after a blank declare a unit; other words do not.
TEST(ColumnUnits, NamesDeclareUnits) {
  for (const char* name : {"depth_mm", "depth [mm]", "depth(mm)", "depth[mm", "\"depth_mm\"", "depth/mm",
                           "Tiefe in mm", "depth_mm_1", "depth (tool) [mm]", "depth [ mm ] "})
    EXPECT_EQ(unit_of(name), "mm") << name;
  for (const char* name : {"depth", "x", "tool_x", "mean_force", "tool depth", "force_1", "mm", "s", ""})
    EXPECT_EQ(unit_of(name), "") << name;
  EXPECT_EQ(unit_of("force [N/mm]"), "N/mm");
  EXPECT_EQ(unit_of("area_mm2"), "mm2");
  EXPECT_EQ(unit_of("Zeit in s"), "s");
}

// A column without a declared unit has that of the SI, unless its whole name is a unit of its kind.
TEST(ColumnUnits, BareWordsAreSI) {
  const auto size = [](const char* column, ColumnKind kind) { return column_unit("t.csv", column, kind); };
  EXPECT_EQ(size("depth", ColumnKind::kLength)->name, "m");
  EXPECT_EQ(size("depth", ColumnKind::kLength)->size, 1);
  EXPECT_EQ(size("s", ColumnKind::kLength)->name, "m") << "a usual symbol of a path";
  EXPECT_EQ(size("F", ColumnKind::kForce)->name, "N");
  EXPECT_EQ(size("mm", ColumnKind::kLength)->size, 1e-3);
}

// Sizes by the definitions of the SI; a gram of force is 9.80665 mN.
TEST(ColumnUnits, KnownUnitsHaveTheirSize) {
  const auto force = [](const char* column) {
    return column_unit("t.csv", column, ColumnKind::kForce)->size;
  };
  EXPECT_DOUBLE_EQ(force("Force (g)"), 9.80665e-3);
  EXPECT_DOUBLE_EQ(force("Force (gf)"), 9.80665e-3);
  EXPECT_DOUBLE_EQ(force("Force (kgf)"), 9.80665);
  EXPECT_DOUBLE_EQ(force("force_kN"), 1000);
  EXPECT_DOUBLE_EQ(force("force_cN"), 0.01);
  EXPECT_DOUBLE_EQ(force("force [mN]"), 1e-3);
  EXPECT_DOUBLE_EQ(column_unit("t.csv", "Time (sec)", ColumnKind::kTime)->size, 1);
}

// An unknown unit, and one of another kind, are refused with file, column and the known units.
TEST(ColumnUnits, UnknownUnitsAreRefused) {
  EXPECT_REFUSED(column_unit("t.csv", "Force (stone)", ColumnKind::kForce), "t.csv", "\"Force (stone)\"",
                 "N, kN, cN, mN", "found \"stone\"");
  EXPECT_REFUSED(column_unit("t.csv", "x_furlong", ColumnKind::kLength), "x_furlong", "m, cm, mm",
                 "found \"furlong\"");
  EXPECT_REFUSED(column_unit("t.csv", "force_mm", ColumnKind::kForce), "found \"mm\"");
  EXPECT_REFUSED(column_unit("t.csv", "depth_MM", ColumnKind::kLength), "found \"MM\"");
  EXPECT_REFUSED(column_unit("t.csv", "time_h", ColumnKind::kTime), "s, sec, ms");
}

}  // namespace
}  // namespace turgor
