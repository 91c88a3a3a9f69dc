// Pieces of the report's page: text, tables and curves as HTML. Used by report_html*.cpp.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "turgor/sim/report/plot.hpp"
#include "turgor/sim/report/quantity.hpp"
#include "turgor/sim/report/report.hpp"

namespace turgor::page {

/// A number as people read it: three or four digits; text escaped.
std::string snapshot(const Json& value);
std::string table_row(const std::vector<std::string>& cells, const char* tag);

/// A row a quantity, a column for each of `items`; what none of them has is left out.
std::string quantity_table(const Json& items, const char* heading, const std::vector<Caption>& captions);
/// Key figures of those that are marked so.
std::string quantity_figures(const Json& items, const std::vector<Caption>& captions);

/// Where a series and the names of its columns are.
struct SeriesKeys {
  const char* columns = "series_columns";
  const char* rows = "series";
};
/// Two columns of a series as a curve; empty when it has none of these names.
Curve curve_of(const std::string& label, const Json& item, const SeriesKeys& series, std::string_view x,
               std::string_view y);
/// A plot on the page; empty without points.
std::string drawn(const Plot& plot);

/// A large number with what it is.
std::string key_figure(const std::string& value, const std::string& label);

/// Of tools and what they touch; empty without tools.
std::string touch_curves(const Json& report);

}  // namespace turgor::page
