#include "turgor/sim/report/page.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "turgor/io/files/xml_text.hpp"
#include "turgor/sim/report/amount.hpp"
#include "turgor/sim/report/literature.hpp"

namespace turgor::page {

namespace {

/// True for sizes of memory, whose cells have their own unit: 601622784 bytes are "602 MB".
bool is_size(const Caption& caption) { return caption.unit.text == std::string_view(units::kBytes.text); }

std::string with_unit(const Caption& caption) {
  return *caption.unit.text && !is_size(caption) ? fmt::format("{} [{}]", caption.label, caption.unit.text)
                                                 : caption.label;
}

std::string name_of(const Json& item) { return item.contains("name") ? html_value(item.at("name")) : ""; }

}  // namespace

std::string html_value(const Json& value) { return xml_text(number_of(value)); }

namespace {

std::string cell_of(const Json& value, const Caption& caption) {
  return is_size(caption) ? xml_text(amount(value, caption.unit)) : html_value(value);
}

}  // namespace

std::string table_row(const std::vector<std::string>& cells, const char* tag) {
  std::string row = "<tr>";
  for (const std::string& cell : cells) row += fmt::format("<{0}>{1}</{0}>", tag, cell);
  return row + "</tr>\n";
}

std::string quantity_table(const Json& items, const char* heading, const std::vector<Caption>& captions) {
  // one row per quantity; rows without any value are omitted
  std::vector<std::vector<std::string>> rows;
  std::vector<std::string> literature;  // of each row
  for (const Caption& caption : captions) {
    if (!(caption.shown_in & kInTable)) continue;
    std::vector<std::string> cells = {with_unit(caption)};
    bool any = false;
    for (const Json& item : items) {
      const Json* value = find(item, caption.key);
      const bool known = value && !value->is_null();
      any = any || known;
      cells.push_back(known ? cell_of(*value, caption) : "–");
    }
    if (!any) continue;
    rows.push_back(std::move(cells));
    literature.push_back(xml_text(published_measure(heading, caption.key)));
  }
  // header: one column per item, and one of published values if there are any
  std::vector<std::string> cells = {heading};
  for (const Json& item : items) cells.push_back(name_of(item));
  const bool has_literature = std::any_of(literature.begin(), literature.end(),
                                          [](const std::string& text) { return !text.empty(); });
  if (has_literature) cells.push_back("literature");
  std::string table = "<div class=\"scroll\"><table>" + table_row(cells, "th");
  for (std::size_t r = 0; r < rows.size(); r++) {
    if (has_literature) rows[r].push_back(literature[r]);
    table += table_row(rows[r], "td");
  }
  return table + "</table></div>\n";
}

std::string item_table(const Json& items, const char* heading, const std::vector<Caption>& captions) {
  // header: one column per quantity; columns without any value are omitted
  const auto has_value = [&items](const Caption& caption) {
    return std::any_of(items.begin(), items.end(), [&caption](const Json& item) {
      const Json* value = find(item, caption.key);
      return value && !value->is_null();
    });
  };
  std::vector<Caption> columns;
  for (const Caption& caption : captions)
    if ((caption.shown_in & kInTable) && has_value(caption)) columns.push_back(caption);
  std::vector<std::string> cells = {heading};
  for (const Caption& caption : columns) cells.push_back(with_unit(caption));
  std::string table = "<div class=\"scroll\"><table>" + table_row(cells, "th");
  // one row per item
  for (const Json& item : items) {
    cells = {name_of(item)};
    for (const Caption& caption : columns) {
      const Json* value = find(item, caption.key);
      cells.push_back(value && !value->is_null() ? cell_of(*value, caption) : "–");
    }
    table += table_row(cells, "td");
  }
  return table + "</table></div>\n";
}

std::string quantity_figures(const Json& items, const std::vector<Caption>& captions, Figures which) {
  const auto is_time = [](std::string_view unit) { return unit == "ms" || unit == "µs"; };
  std::string html;
  for (const Json& item : items)
    for (const Caption& caption : captions) {
      const Json* value = find(item, caption.key);
      if (!caption.figure.empty() && value && !value->is_null() &&
          is_time(caption.unit.text) == (which == Figures::kTimes))
        html += key_figure(xml_text(amount(*value, caption.unit)),
                           fmt::format(fmt::runtime(caption.figure), name_of(item)));
    }
  return html;
}

Curve curve_of(const std::string& label, const Json& item, const SeriesKeys& series, std::string_view x,
               std::string_view y) {
  Curve curve{label, {}};
  const Json columns = item.value(series.columns, Json::array()),
             rows = item.value(series.rows, Json::array());
  const auto column_of = [&columns](std::string_view name) {
    return std::size_t(std::find(columns.begin(), columns.end(), name) - columns.begin());
  };
  const std::size_t at_x = column_of(x), at_y = column_of(y);
  for (const Json& row : rows)
    if (std::max(at_x, at_y) < row.size() && row.at(at_x).is_number() && row.at(at_y).is_number())
      curve.points.emplace_back(row.at(at_x).get<double>(), row.at(at_y).get<double>());
  return curve;
}

std::string plot_html(const Plot& plot) {
  const std::string svg = plot_svg(plot);
  return svg.empty() ? "" : "<div class=\"plot\">" + svg + "</div>\n";
}

std::string key_figure(const std::string& value, const std::string& label) {
  return fmt::format("<div><b>{}</b><span>{}</span></div>", value, label);
}

}  // namespace turgor::page
