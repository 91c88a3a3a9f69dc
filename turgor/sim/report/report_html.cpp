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

constexpr const char* kPageHead = R"(<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>Turgor: {0}</title>
<style>
:root {{ color-scheme: light dark; --ground: #fbfaf8; --card: #ffffff; --ink: #22262b; --soft: #6b737d; --line: #e3e1dc; --accent: #b4502f; }}
@media (prefers-color-scheme: dark) {{
  :root {{ --ground: #14171a; --card: #1c2024; --ink: #e8e6e1; --soft: #98a1ab; --line: #2f353b; --accent: #f0936f; }} }}
* {{ box-sizing: border-box; }}
body {{ margin: 0; background: var(--ground); color: var(--ink); font: 16px/1.55 system-ui, "Segoe UI", "DejaVu Sans", sans-serif; }}
main {{ max-width: 1080px; margin: 0 auto; padding: 2.5rem 1.25rem 4rem; }}
h1 {{ font-size: 1.9rem; margin: 0; letter-spacing: -0.01em; }} h2 {{ font-size: 1.2rem; margin: 2.6rem 0 0.8rem; }}
.soft {{ color: var(--soft); }} .warning {{ border-left: 4px solid var(--accent); padding: 0.4rem 0.9rem; background: var(--card); }}
.figures {{ display: grid; grid-template-columns: repeat(auto-fit, minmax(150px, 1fr)); gap: 0.8rem; margin: 1.6rem 0; }}
.figures div, figure, .plot {{ background: var(--card); border: 1px solid var(--line); border-radius: 10px; }}
.figures div {{ padding: 0.8rem 1rem; }} .figures b {{ display: block; font-size: 1.5rem; font-variant-numeric: tabular-nums; }}
.figures span {{ color: var(--soft); font-size: 0.85rem; }}
.grid {{ display: grid; grid-template-columns: repeat(auto-fit, minmax(min(420px, 100%), 1fr)); gap: 1rem; }} .grid > * {{ min-width: 0; }}
figure {{ margin: 0; overflow: hidden; }} figure.large {{ grid-column: 1 / -1; }} figure img, figure video {{ display: block; width: 100%; height: auto; }}
figcaption {{ padding: 0.55rem 0.9rem; font-size: 0.88rem; color: var(--soft); }}
.plot-read {{ font-weight: 600; paint-order: stroke; stroke: var(--card); stroke-width: 4px; }}
.plot {{ padding: 0.6rem; overflow-x: auto; }} .plot svg {{ width: 100%; min-width: 460px; height: auto; display: block; }}
.scroll {{ overflow-x: auto; }}
table {{ border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; font-size: 0.93rem; }}
th, td {{ text-align: right; padding: 0.4rem 0.7rem; border-bottom: 1px solid var(--line); }} th:first-child, td:first-child {{ text-align: left; }}
th {{ font-weight: 600; color: var(--soft); }}
pre {{ background: var(--card); border: 1px solid var(--line); border-radius: 10px; padding: 1rem; overflow-x: auto; font-size: 0.85rem; }}
code {{ font-family: ui-monospace, "DejaVu Sans Mono", monospace; }}
</style></head><body><main>
)";

/// Script that shows the values of the curve nearest to the mouse.
constexpr const char* kReadPlots = R"js(<script>
for (const plot of document.querySelectorAll('.turgor-plot')) {
  const area = plot.querySelector('.plot-area'), curves = [...plot.querySelectorAll('.plot-curve')];
  if (!area || curves.length === 0) continue;
  const number = (name) => Number(area.getAttribute(name)), pair = (name) => area.getAttribute(name).split(' ').map(Number);
  const [x0, x1] = pair('data-x'), [y0, y1] = pair('data-y'), powers = area.getAttribute('data-powers') === 'yes';
  const points = curves.flatMap((curve) => curve.getAttribute('d').slice(1).split('L').map((p) => [...p.split(' ').map(Number), curve]));
  const make = (name) => plot.appendChild(document.createElementNS('http://www.w3.org/2000/svg', name)), dot = make('circle'), text = make('text');
  dot.setAttribute('r', 4), dot.style.display = text.style.display = 'none', text.setAttribute('class', 'plot-read');
  plot.addEventListener('pointermove', (event) => {
    const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(plot.getScreenCTM().inverse());
    const far = (p) => 4 * Math.abs(p[0] - at.x) + Math.abs(p[1] - at.y), near = points.reduce((a, b) => (far(b) < far(a) ? b : a));
    const x = x0 + (near[0] - number('x')) / number('width') * (x1 - x0);
    const level = y1 - (near[1] - number('y')) / number('height') * (y1 - y0), y = powers ? 10 ** level : level;
    const right = near[0] > number('x') + 0.6 * number('width');
    dot.setAttribute('cx', near[0]), dot.setAttribute('cy', near[1]), dot.setAttribute('fill', near[2].getAttribute('stroke'));
    text.setAttribute('x', near[0] + (right ? -8 : 8)), text.setAttribute('y', Math.max(number('y') + 14, near[1] - 8));
    text.setAttribute('text-anchor', right ? 'end' : 'start');
    text.textContent = Number(x.toPrecision(4)) + ', ' + Number(y.toPrecision(4)), dot.style.display = text.style.display = '';
  });
  plot.addEventListener('pointerleave', () => { dot.style.display = text.style.display = 'none'; });
}
</script>
)js";

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

  // frames
  Plot frames{"Wall time of a frame", "frame", "time [ms]", {{"frame", {}}}};
  const Json& times = report.at("timing").at("frame_ms");
  for (std::size_t f = 0; f < times.size(); f++)
    frames.curves[0].points.emplace_back(double(f + 1), times[f].get<double>());

  // page
  std::string html;
  if (!report.at("wounds").empty())
    html += "<h2>Wounds</h2>\n<div class=\"grid\">" + plot_html(gape) + plot_html(profile) + "</div>\n";
  html += page::touch_curves(report) + page::cloth_curves(report);
  if (bodies_of(report, BodyKind::kLattice).empty()) return html;
  return html + "<h2>Solver</h2>\n<div class=\"grid\">" + plot_html(residual) + plot_html(frames) +
         "</div>\n";
}

std::string key_figures(const Json& report) {
  std::string html = "<div class=\"figures\">";
  for (const Section& section : report_sections())
    html += page::quantity_figures(section.items(report), section.captions);
  const auto seconds = [&](const char* key) { return html_value(report.at("timing").value(key, Json())); };
  html += key_figure(html_value(report.at("simulated_s")) + " s",
                     fmt::format("simulated in {} s, drawn in {} s, written in {} s", seconds("physics_s"),
                                 seconds("drawing_s"), seconds("files_s")));
  return html + "</div>\n";
}

std::string tables(const Json& report) {
  std::string html;
  for (const Section& section : report_sections())
    if (const Json items = section.items(report); *section.heading && !items.empty())
      html += fmt::format("<h2>{}</h2>\n", section.heading) +
              (section.item_per_row ? page::item_table : page::quantity_table)(items, section.item,
                                                                               section.captions);
  return html;
}

}  // namespace

std::string report_html(const Json& report, const fs::path& folder, const std::string& motion) {
  // head
  const Json &scene = report.at("scene"), &machine = report.at("machine");
  const std::string name = xml_text(fs::path(scene.at("file").get<std::string>()).stem().string());
  std::string html = fmt::format(fmt::runtime(kPageHead), name);
  html +=
      fmt::format("<h1>{}</h1>\n<p class=\"soft\">{:g} frames a second; {} threads on {}; turgor {}</p>\n",
                  name, scene.at("frame_rate_per_s").get<double>(), html_value(machine.at("threads")),
                  html_value(machine.at("processor")), html_value(report.at("version")));
  for (const Json& warning : report.at("warnings"))
    html += "<p class=\"warning\">" + html_value(warning) + "</p>\n";

  // sections
  html += key_figures(report);
  html += motion + pictures(report, folder) + videos(report, folder);
  html += curves(report);
  html += tables(report) + files(report);

  // scene
  html += "<h2>Scene</h2>\n<pre><code>" + xml_text(report.at("scene_text").get<std::string>()) +
          "</code></pre>\n";
  for (const Json& text : scene.at("overrides"))
    html += "<p><code>--set " + html_value(text) + "</code></p>\n";
  return html + kReadPlots + "</main></body></html>\n";
}

}  // namespace turgor
