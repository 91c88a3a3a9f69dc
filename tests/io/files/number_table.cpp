#include "turgor/io/files/number_table.hpp"

#include <gtest/gtest.h>

#include "tests/folders.hpp"
#include "tests/refused.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;

fs::path table(const std::string& text) {
  const fs::path file = test::fresh_folder() / "table.csv";
  test::write(file, text);
  return file;
}

Result<std::vector<NumberRow>> read(const std::string& text) {
  return read_number_table(table(text), "numbers t, x, y, z");
}

std::vector<std::vector<double>> values_of(const std::string& text) {
  const Result<std::vector<NumberRow>> rows = read(text);
  EXPECT_TRUE(rows) << rows.error().message;
  std::vector<std::vector<double>> values;
  if (rows)
    for (const NumberRow& row : *rows) values.push_back(row.values);
  return values;
}

const std::vector<std::vector<double>> kTwoRows = {{0, 0.5}, {1, -2}};

// Rows are read with any separator, with names or without, and after a byte-order mark.
TEST(NumberTable, SeparatorsNamesAndMarksAreRead) {
  for (const char* text :
       {"0,0.5\n1,-2\n", "0;0.5\n1;-2\n", "0 0.5\n1 -2\n", "0\t0.5\r\n1\t-2\r\n", "t,x\n0,0.5\n1,-2\n",
        "# by hand\n\ntime [s]; force 1 [N]\n0;0.5\n1;-2\n", "\xEF\xBB\xBFt,x\n0,0.5\n1,-2\n",
        "\xEF\xBB\xBF"
        "0,0.5\n1,-2\n"})
    EXPECT_EQ(values_of(text), kTwoRows) << text;
}

// A first row with a typing error or NaN is no line of names: it is refused, not dropped.
TEST(NumberTable, DamagedFirstRowIsRefused) {
  EXPECT_REFUSED(read("0,0,0,O.02\n1,0,0,0\n"),
                 "table.csv:1: expected numbers t, x, y, z, found \"0,0,0,O.02\"");
  EXPECT_REFUSED(read("0 0 0 nan\n1 0 0 0\n"), "table.csv:1: expected numbers", "nan");
  EXPECT_REFUSED(read("nan;nan\n1;0\n"), "table.csv:1: expected numbers");
  EXPECT_REFUSED(read("# comment\n\n0,x\n1,0\n"), "table.csv:3: expected numbers");
  EXPECT_REFUSED(read("t,x\n0,0\nO,1\n"), "table.csv:3: expected numbers");
  EXPECT_REFUSED(read("t,x\nt,x\n0,0\n"), "table.csv:2: expected numbers");
  EXPECT_REFUSED(read("t,x\n"), "table.csv: expected lines of numbers t, x, y, z, found none");
}

// The names of columns are those of the first line, if none of them is a number.
TEST(NumberTable, NamesOfColumnsAreRead) {
  using Names = std::vector<std::string>;
  EXPECT_EQ(read_column_names(table("time [s], force 1 [N]\n0,1\n")).value(),
            (Names{"time [s]", "force 1 [N]"}));
  EXPECT_EQ(read_column_names(table("\xEF\xBB\xBFt x\n0 1\n")).value(), (Names{"t", "x"}));
  EXPECT_EQ(read_column_names(table("0,1\n")).value(), Names());
  EXPECT_EQ(read_column_names(table("0,O\n")).value(), Names());
}

}  // namespace
}  // namespace turgor
