// HTML elements of the report: text, tables and curves. Used by report_html*.cpp.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "turgor/sim/report/plot.hpp"
#include "turgor/sim/report/quantity.hpp"
#include "turgor/sim/report/report.hpp"

namespace turgor::page {

/// Number with three or four digits, or escaped text.
std::string html_value(const Json& value);
std::string table_row(const std::vector<std::string>& cells, const char* tag);

/// Table with a row per quantity and a column per item; rows without values are omitted. Published values
/// have a column of their own where a row has some.
std::string quantity_table(const Json& items, const char* heading, const std::vector<Caption>& captions);
/// Table with a row per item and a column per quantity.
std::string item_table(const Json& items, const char* heading, const std::vector<Caption>& captions);
/// Key figures of the quantities that have one and a value: results, or wall times below a second.
enum class Figures : std::uint8_t { kResults, kTimes };
std::string quantity_figures(const Json& items, const std::vector<Caption>& captions, Figures which);

/// Keys of a series and of its column names.
struct SeriesKeys {
  const char* columns = "series_columns";
  const char* rows = "series";
};
/// Two columns of a series as a curve; empty if a column is missing.
Curve curve_of(const std::string& label, const Json& item, const SeriesKeys& series, std::string_view x,
               std::string_view y);
/// Plot as HTML; empty without points.
std::string plot_html(const Plot& plot);

/// A large number with its label.
std::string key_figure(const std::string& value, const std::string& label);

/// Curves of tools and touched bodies; empty without tools.
std::string touch_curves(const Json& report);

/// Begin of the page with its style, and its end with the script of plots.
std::string page_head(const std::string& title);
std::string page_end();

/// Verdict, then the patient or phantom, series and dates.
std::string verdict_html(const Json& report);
/// Parameters with units, sources and published values; empty if the report has none.
std::string parameter_table(const Json& report);
/// Wall times: figures, table and curves.
std::string time_section(const Json& report);

}  // namespace turgor::page
