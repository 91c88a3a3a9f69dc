// Rows of numbers from a text file, as spreadsheets and measuring programs write them: commas, semicolons,
// tabs or blanks between them, a first line of names, empty lines, and comments behind '#'.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "turgor/core/result.hpp"

namespace turgor {

struct NumberRow {
  int line = 0;  // in the file, from 1
  std::vector<double> values;
  std::string text;  // as it stands there
};

/// Error: names file and line of what is no row of finite numbers; `expected` says what one is made of.
Result<std::vector<NumberRow>> read_number_table(const std::filesystem::path& file,
                                                 const std::string& expected);
/// What its first line calls the columns; none where that is a row of numbers.
Result<std::vector<std::string>> read_column_names(const std::filesystem::path& file);

}  // namespace turgor
