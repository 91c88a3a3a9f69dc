// Verdict, subject, parameters and wall times on the report's page.
#include <algorithm>

#include <fmt/format.h>

#include "turgor/io/files/xml_text.hpp"
#include "turgor/sim/report/literature.hpp"
#include "turgor/sim/report/page.hpp"
#include "turgor/sim/report/section.hpp"

namespace turgor::page {

namespace {

std::string text_under(const Json& item, const char* key) {
  const Json* value = find(item, key);
  return value && value->is_string() ? value->get<std::string>() : std::string();
}

/// "2024-05-01" of DICOM's "20240501"; other text unchanged.
std::string iso_date(const std::string& date) {
  const bool is_dicom =
      date.size() == 8 && std::all_of(date.begin(), date.end(), [](char c) { return c >= '0' && c <= '9'; });
  return is_dicom ? date.substr(0, 4) + "-" + date.substr(4, 2) + "-" + date.substr(6) : date;
}

/// "patient DOE^JANE (17), Thorax, series 'B30f', scanned 2024-05-01"; the source of a CT without a patient.
std::string subject_of(const Json& body) {
  std::string text;
  const auto add = [&text](const std::string& more) { text += (text.empty() ? "" : ", ") + more; };
  const std::string patient = text_under(body, "ct.patient"), id = text_under(body, "ct.patient_id"),
                    study = text_under(body, "ct.study"), series = text_under(body, "ct.series"),
                    date = text_under(body, "ct.study_date"), source = text_under(body, "ct.source");
  if (!patient.empty() || !id.empty())
    add("patient " + patient + (id.empty() ? "" : (patient.empty() ? "" : " ") + ("(" + id + ")")));
  if (!study.empty()) add(study);
  if (!series.empty()) add("series '" + series + "'");
  if (!date.empty()) add("scanned " + iso_date(date));
  return text.empty() ? source == "phantom" ? "a synthetic CT" : source : text;
}

std::string line_of(const std::string& text) { return "<p class=\"soft\">" + xml_text(text) + "</p>\n"; }

/// Curves of wall times of every model.
std::string time_curves(const Json& report) {
  // frames
  Plot frames{"Wall time of a frame", "frame", "time [ms]", {{"frame", {}}}};
  const Json& times = report.at("timing").at("frame_ms");
  for (std::size_t f = 0; f < times.size(); f++)
    frames.curves[0].points.emplace_back(double(f + 1), times[f].get<double>());
  // patches and cloth
  Plot rebuilds{"Building a patch", "time [s]", "wall time [ms]", {}},
      steps{"Wall time of a step", "time [s]", "time [ms]", {}};
  for (const Json& body : bodies_of(report, BodyKind::kSfem))
    rebuilds.curves.push_back(
        curve_of(body.at("name").get<std::string>(), body.at("patch"), {}, "time_s", "rebuild_ms"));
  for (const Json& cloth : bodies_of(report, BodyKind::kCloth))
    steps.curves.push_back(curve_of(cloth.at("name").get<std::string>(), cloth, {}, "time_s", "step_ms"));
  return "<div class=\"grid\">" + plot_html(frames) + plot_html(rebuilds) + plot_html(steps) + "</div>\n";
}

}  // namespace

std::string verdict_html(const Json& report) {
  // verdict
  std::string html = "<p class=\"verdict\">";
  for (const Json& sentence : report.value("verdict", Json::array())) html += html_value(sentence) + " ";
  html += "</p>\n";
  // subject
  for (const Json& body : report.value("bodies", Json::array()))
    if (body.contains("ct"))
      html += line_of(fmt::format("{}: {}", text_under(body, "name"), subject_of(body)));
  const Json& machine = report.at("machine");
  const std::string date = text_under(report, "timing.date");
  return html + line_of(fmt::format("turgor {}{}; {} frames a second; {} threads on {}",
                                    text_under(report, "version"), date.empty() ? "" : ", " + date,
                                    report.at("scene").at("frame_rate_per_s").dump(),
                                    machine.at("threads").dump(), text_under(machine, "processor")));
}

std::string parameter_table(const Json& report) {
  const Json parameters = report.value("parameters", Json::array());
  if (parameters.empty()) return "";
  const auto literature_of = [](const Json& p) { return published_parameter(text_under(p, "key")); };
  const bool has_literature = std::any_of(parameters.begin(), parameters.end(),
                                          [&](const Json& p) { return !literature_of(p).empty(); });
  std::vector<std::string> columns{"key", "value", "unit", "source"};
  if (has_literature) columns.push_back("literature");
  std::string html =
      "<h2>Parameters</h2>\n<div class=\"scroll\"><table class=\"parameters\">" + table_row(columns, "th");
  for (const Json& p : parameters) {
    const bool is_default = text_under(p, "source") == "default";
    std::string row;
    for (const char* key : {"key", "value", "unit", "source"})
      row += "<td>" + xml_text(text_under(p, key)) + "</td>";
    if (has_literature) row += "<td>" + xml_text(literature_of(p)) + "</td>";
    html += (is_default ? "<tr class=\"default\">" : "<tr>") + row + "</tr>\n";
  }
  return html + "</table></div>\n";
}

std::string time_section(const Json& report) {
  std::string figures;
  for (const Section& section : report_sections())
    figures += quantity_figures(section.items(report), section.captions, Figures::kTimes);
  const Section timing = timing_section();
  return "<h2>Time</h2>\n<div class=\"figures\">" + figures + "</div>\n" +
         quantity_table(timing.items(report), timing.item, timing.captions) + time_curves(report);
}

}  // namespace turgor::page
