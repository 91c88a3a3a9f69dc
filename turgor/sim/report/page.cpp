#include "turgor/sim/report/page.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <fmt/format.h>

#include "turgor/io/xml_text.hpp"

namespace turgor::page {

namespace {

/// What a key leads to, table by table; null when there is no such thing.
const Json* find(const Json& item, std::string_view key) {
  const Json* at = &item;
  for (std::size_t begin = 0; begin <= key.size();) {
    const std::size_t end = std::min(key.find('.', begin), key.size());
    const std::string part(key.substr(begin, end - begin));
    if (!at->is_object() || !at->contains(part)) return nullptr;
    at = &at->at(part);
    begin = end + 1;
  }
  return at;
}

}  // namespace

std::string shown(const Json& value) {
  if (value.is_string()) return xml_text(value.get<std::string>());
  if (value.is_number_integer()) return fmt::format("{}", value.get<std::int64_t>());
  if (!value.is_number()) return "";
  const double number = value.get<double>(), size = std::abs(number);
  if (number == 0) return "0";
  if (size >= 100 && size < 1e6) return fmt::format("{:.0f}", number);
  if (size >= 10 && size < 1e6) return fmt::format("{:.1f}", number);
  return size >= 0.01 && size < 1e6 ? fmt::format("{:.2f}", number) : fmt::format("{:.2g}", number);
}

std::string table_row(const std::vector<std::string>& cells, const char* tag) {
  std::string row = "<tr>";
  for (const std::string& cell : cells) row += fmt::format("<{0}>{1}</{0}>", tag, cell);
  return row + "</tr>\n";
}

std::string quantity_table(const Json& items, const char* heading, const std::vector<Quantity>& quantities) {
  std::vector<std::string> cells = {heading};
  for (const Json& item : items) cells.push_back(shown(item.at("name")));
  std::string table = "<div class=\"scroll\"><table>" + table_row(cells, "th");
  for (const Quantity& q : quantities) {
    cells = {q.label};
    bool any = false;
    for (const Json& item : items) {
      const Json* value = find(item, q.key);
      any = any || value;
      cells.push_back(value ? shown(*value) : "–");
    }
    if (any) table += table_row(cells, "td");
  }
  return table + "</table></div>\n";
}

Curve curve_of(const std::string& label, const Json& rows, std::size_t x, std::size_t y) {
  Curve curve{label, {}};
  for (const Json& row : rows)
    if (row.at(x).is_number() && row.at(y).is_number())
      curve.points.emplace_back(row.at(x).get<double>(), row.at(y).get<double>());
  return curve;
}

std::string drawn(const Plot& plot) {
  const std::string svg = plot_svg(plot);
  return svg.empty() ? "" : "<div class=\"plot\">" + svg + "</div>\n";
}

std::string key_figure(const std::string& value, const std::string& label) {
  return fmt::format("<div><b>{}</b><span>{}</span></div>", value, label);
}

}  // namespace turgor::page
