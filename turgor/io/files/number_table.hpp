// Rows of numbers from a text file, as written by spreadsheets and measuring programs. Separators are commas,
// semicolons, tabs or blanks. Empty lines and comments after '#' are allowed, and a first line of names, none
// of which is a number.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "turgor/core/result.hpp"

namespace turgor {

struct NumberRow {
  int line = 0;  // in the file, from 1
  std::vector<double> values;
  std::string text;  // as written in the file
};

/// Error: file and line of a row that is not finite numbers; `expected` describes a row.
Result<std::vector<NumberRow>> read_number_table(const std::filesystem::path& file,
                                                 const std::string& expected);
/// Column names of the first line; empty if one of them is a number.
Result<std::vector<std::string>> read_column_names(const std::filesystem::path& file);

}  // namespace turgor
