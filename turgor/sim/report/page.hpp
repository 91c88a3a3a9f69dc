// Pieces of the report's page: text, tables and curves as HTML. Used by report_html*.cpp.
#pragma once

#include <string>
#include <vector>

#include "turgor/sim/report/plot.hpp"
#include "turgor/sim/report/report.hpp"

namespace turgor::page {

/// A number as people read it: three or four digits; text escaped.
std::string shown(const Json& value);
std::string table_row(const std::vector<std::string>& cells, const char* tag);

/// A table of quantities: a row each, a column for each of `items`. A key may lead into tables:
/// "mesh.elements".
struct Quantity {
  const char* key;
  const char* label;
};
std::string quantity_table(const Json& items, const char* heading, const std::vector<Quantity>& quantities);

/// Two columns of a series as a curve.
Curve curve_of(const std::string& label, const Json& rows, std::size_t x, std::size_t y);
/// A plot on the page; empty without points.
std::string drawn(const Plot& plot);

/// A large number with what it is.
std::string key_figure(const std::string& value, const std::string& label);

}  // namespace turgor::page

namespace turgor {

/// report_html_touch.cpp: key figures, curves and tables of bodies and tools; empty when there are none.
std::string touch_figures(const Json& report);
std::string touch_curves(const Json& report);
std::string touch_tables(const Json& report);

}  // namespace turgor
