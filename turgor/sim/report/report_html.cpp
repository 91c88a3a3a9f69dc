// report.html, made from report.json only, so that a replay writes the same page as the run.
#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>

#include <fmt/format.h>

#include "turgor/io/files/base64.hpp"
#include "turgor/io/files/file.hpp"
#include "turgor/io/files/xml_text.hpp"
#include "turgor/sim/output_folder.hpp"
#include "turgor/sim/report/page.hpp"
#include "turgor/sim/report/report.hpp"
#include "turgor/sim/report/report_cloth.hpp"
#include "turgor/sim/report/section.hpp"

namespace turgor {

namespace {

namespace fs = std::filesystem;
using page::curve_of, page::plot_html, page::key_figure, page::html_value;

std::string pictures(const Json& report, const fs::path& folder) {
  std::string html = "<div class=\"grid\">\n";
  // embed each readable picture
  for (const Json& picture : report.at("pictures")) {
    const std::string caption = xml_text(picture.at("caption").get<std::string>());
    const Result<std::string> bytes = read_file(folder / picture.at("file").get<std::string>());
    if (!bytes) continue;
    html += fmt::format(
        "<figure{}><img alt=\"{}\" src=\"data:image/png;base64,{}\"><figcaption>{}</figcaption></figure>\n",
        picture.at("large").get<bool>() ? " class=\"large\"" : "", caption, io::base64(*bytes), caption);
  }
  html += "</div>\n";
  // link to the other pictures
  const std::string more = report.value("more_pictures", std::string());
  if (more.empty()) return html;
  return html + fmt::format(
                    "<p class=\"soft\">More pictures (whole bodies, color maps, CT): "
                    "<code>{}</code></p>\n",
                    xml_text(more));
}

/// Percent-encoded file name.
std::string link_text(const std::string& name) {
  std::string text;
  for (const char letter : name) {
    const bool plain = std::isalnum(static_cast<unsigned char>(letter)) ||
                       std::string_view("._/-").find(letter) != std::string::npos;
    text += plain ? std::string(1, letter) : fmt::format("%{:02X}", static_cast<unsigned char>(letter));
  }
  return text;
}

/// Embedded up to a total size, else as links.
std::string videos(const Json& report, const fs::path& folder) {
  // embed videos up to a total of 1 MiB, link the others
  constexpr std::size_t kLargest = 1 << 20;
  std::size_t taken = 0;
  std::string html;
  for (const Json& file : report.value("files", Json::array())) {
    const std::string name = file.get<std::string>();
    if (!name.ends_with(".mp4")) continue;
    const Result<std::string> bytes = read_file(folder / name);
    if (!bytes) continue;
    taken += bytes->size();
    html += fmt::format(
        "<figure class=\"large\"><video controls loop muted src=\"{}\"></video><figcaption>{}"
        "</figcaption></figure>\n",
        taken <= kLargest ? "data:video/mp4;base64," + io::base64(*bytes) : link_text(name), xml_text(name));
  }
  return html;
}

/// Links to all files of the output folder.
std::string files(const Json& report) {
  std::string html = "<h2>Files</h2>\n<p class=\"files\">";
  Json names = report.value("files", Json::array());
  for (const Json& picture : report.at("pictures")) names.push_back(picture.at("file"));
  names.push_back(kReportFile);
  for (const Json& name : names) {
    const std::string text = name.get<std::string>();
    html += fmt::format("<a href=\"{}\">{}</a> ", link_text(text), xml_text(text));
  }
  return html + "</p>\n";
}

std::string curves(const Json& report) {
  // wounds
  Plot gape{"Gape over time", "time [s]", "largest gape [mm]", {}},
      profile{"Gape along the cut at the end", "along the cut [mm]", "gape [mm]", {}};
  for (const Json& wound : report.at("wounds")) {
    const std::string name = wound.at("name").get<std::string>();
    gape.curves.push_back(curve_of(name, wound, {}, "time_s", "gape_max_mm"));
    profile.curves.push_back(curve_of(name, wound, {"profile_columns", "profile"}, "along_mm", "gape_mm"));
  }

  // sutures
  Plot closing{"Closing force over time", "time [s]", "force [N]", {}},
      stitches{"Tension of the stitches at the end", "along the cut [mm]", "tension [N]", {}};
  for (const Json& suture : items_of(report, "sutures")) {
    const std::string name = suture.at("name").get<std::string>();
    closing.curves.push_back(curve_of(name, suture, {}, "time_s", "closing_force_N"));
    stitches.curves.push_back(
        curve_of(name, suture, {"stitch_columns", "stitches"}, "along_mm", "tension_N"));
  }

  // solver
  const Json& solver = report.at("solver");
  const page::SeriesKeys kSamples{"columns", "samples"};
  Plot residual{"Residual force of the solver",
                "time [s]",
                "force [N]",
                {curve_of("largest", solver, kSamples, "time_s", "residual_largest_N"),
                 curve_of("root mean square", solver, kSamples, "time_s", "residual_rms_N")},
                true};
  for (Curve& curve : residual.curves)
    std::erase_if(curve.points, [](const auto& p) { return !(p.second > 0); });

  // page
  std::string html;
  if (!report.at("wounds").empty())
    html += "<h2>Wounds</h2>\n<div class=\"grid\">" + plot_html(gape) + plot_html(profile) + "</div>\n";
  if (!closing.curves.empty())
    html += "<h2>Sutures</h2>\n<div class=\"grid\">" + plot_html(closing) + plot_html(stitches) + "</div>\n";
  html += page::touch_curves(report) + page::cloth_curves(report);
  if (bodies_of(report, BodyKind::kLattice).empty()) return html;
  return html + "<h2>Solver</h2>\n<div class=\"grid\">" + plot_html(residual) + "</div>\n";
}

std::string key_figures(const Json& report) {
  std::string html = "<div class=\"figures\">";
  for (const Section& section : report_sections())
    html += page::quantity_figures(section.items(report), section.captions, page::Figures::kResults);
  return html + key_figure(html_value(report.at("simulated_s")) + " s", "simulated") + "</div>\n";
}

std::string table_of(const Json& report, const Section& section) {
  const Json items = section.items(report);
  if (!*section.heading || items.empty()) return "";
  return fmt::format("<h2>{}</h2>\n", section.heading) +
         (section.item_per_row ? page::item_table : page::quantity_table)(items, section.item,
                                                                          section.captions);
}

/// Measures of wounds or cloth beside the parameters, then the tables of bodies and tools. Without such
/// measures the parameters come last, in the whole width.
std::string tables(const Json& report) {
  std::string first, others;
  for (const Section& section : report_sections()) {
    const bool is_result = section.is_result && first.empty();
    (is_result ? first : others) += table_of(report, section);
  }
  const std::string parameters = page::parameter_table(report);
  if (first.empty()) return others + parameters;
  return "<div class=\"beside\"><div>" + first + "</div><div>" + parameters + "</div></div>\n" + others;
}

}  // namespace

std::string report_html(const Json& report, const fs::path& folder, const std::string& motion) {
  // answer
  const Json& scene = report.at("scene");
  const std::string name = xml_text(fs::path(scene.at("file").get<std::string>()).stem().string());
  std::string html = page::page_head(name) + "<h1>" + name + "</h1>\n" + page::verdict_html(report);
  for (const Json& warning : report.at("warnings"))
    html += "<p class=\"warning\">" + html_value(warning) + "</p>\n";
  html += key_figures(report);

  // results
  html += motion + pictures(report, folder) + videos(report, folder);
  html += tables(report) + curves(report);

  // time, files and scene
  html += page::time_section(report) + files(report);
  html += "<h2>Scene</h2>\n<pre><code>" + xml_text(report.at("scene_text").get<std::string>()) +
          "</code></pre>\n";
  for (const Json& text : scene.at("overrides"))
    html += "<p><code>--set " + html_value(text) + "</code></p>\n";
  return html + page::page_end();
}

}  // namespace turgor
