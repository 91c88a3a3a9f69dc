#include "app/validate_measured.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "app/commands.hpp"
#include "app/measured_table.hpp"
#include "app/print.hpp"
#include "turgor/io/files/file.hpp"
#include "turgor/sim/report/plot.hpp"

namespace turgor {

namespace {

std::string band_text(const MeasuredRow& row) { return fmt::format("[{:.4g} to {:.4g}]", row.low, row.high); }

void print_rows(const std::vector<MeasuredRow>& rows) {
  // columns as wide as their longest entries
  std::size_t name = 0, band = 0;
  for (const MeasuredRow& row : rows)
    name = std::max(name, row.name.size()), band = std::max(band, band_text(row).size());
  print_plain("  {:<{}} {:>10} {:>{}} {:>11} {:<4} {}\n", "quantity", name, "measured", "[band]", band,
              "predicted", "", "inside?");
  for (const MeasuredRow& row : rows)
    print_plain("  {:<{}} {:>10.4g} {:>{}} {:>11.4g} {:<4} {}\n", row.name, name, row.measured,
                band_text(row), band, row.predicted, row.unit == "1" ? "" : row.unit,
                is_inside(row) ? "yes" : "NO");
}

nlohmann::ordered_json json_of(const std::vector<MeasuredRow>& rows) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const MeasuredRow& row : rows)
    json.push_back({{"name", row.name},
                    {"source", row.source},
                    {"unit", row.unit},
                    {"measured", row.measured},
                    {"low", row.low},
                    {"high", row.high},
                    {"predicted", row.predicted},
                    {"inside", is_inside(row)}});
  return json;
}

/// Measured and predicted curve over the shaded band.
Plot plot_of(const MeasuredCurve& curve) {
  Plot plot{curve.title, curve.x_label, curve.y_label, {{"measured", {}}, {"predicted", {}}}};
  plot.region.label = "band";
  for (const auto& [x, measured, half, predicted] : curve.points) {
    plot.curves[0].points.emplace_back(x, measured);
    plot.curves[1].points.emplace_back(x, predicted);
    plot.region.points.push_back({x, measured - half, measured + half});
  }
  return plot;
}

}  // namespace

std::vector<Figure> validate_measured(const Exec& exec, bool quick, const std::filesystem::path& folder,
                                      nlohmann::ordered_json& report) {
  // predictions
  MeasuredResult result;
  add_laws(result);
  add_point_problems(result);
  add_febio(result);
  add_body_problems(exec, quick, result);
  add_muscle(result);
  add_brain(exec, quick, result);
  add_skin_sheet(exec, result);
  add_disc(exec, quick, result);
  add_cantilever(exec, quick, result);
  add_silicones(exec, quick, result);
  if (!quick) add_muscle_bodies(exec, result);
  if (!quick) add_limbs(exec, result);

  // table and curves
  print_rows(result.rows);
  for (const MeasuredCurve& curve : result.curves)
    required(write_file(folder / curve.file, plot_svg_file(plot_of(curve))));
  report["rows"] = json_of(result.rows);

  // figures
  std::vector<Figure> figures;
  for (const MeasuredRow& row : result.rows)
    figures.push_back({row.name, row.source, row.unit, row.predicted, row.low, row.high});
  return figures;
}

}  // namespace turgor
