// `turgor identify`: fits parameters of a scene's tissue, such as Young's modulus or Prony pairs, to a
// measured force of a tool over depth or time. `turgor calibrate` fits the chain of a rhombus body instead.
// Writes the curves, the values with their confidence intervals, and the keys for the scene.
#include "turgor/sim/identify.hpp"

#include <cmath>
#include <memory>

#include <fmt/format.h>

#include "app/print.hpp"
#include "app/result_folder.hpp"
#include "turgor/core/progress.hpp"
#include "turgor/io/files/file.hpp"
#include "turgor/sim/report/plot.hpp"
#include "turgor/sim/report/report.hpp"

namespace turgor {

namespace {

namespace fs = std::filesystem;

struct IdentifyOptions {
  IdentifyInput input;
  fs::path table, out;
  std::vector<std::string> fits;
  bool force = false;
};

FitParameter parameter_of(const std::string& text) {
  const std::size_t at = text.rfind('=');
  FitParameter parameter{.key = text.substr(0, at)};
  try {
    std::size_t used = 0;
    const std::string number = at == std::string::npos ? "" : text.substr(at + 1);
    parameter.start = std::stod(number, &used);
    if (used == number.size() && parameter.start > 0 && std::isfinite(parameter.start)) return parameter;
  } catch (const std::exception&) {  // not a number: the same failure
  }
  throw Failure{2, fmt::format("--fit: expected KEY=START with a start value above 0, such as "
                               "body.liver.young=3000, found \"{:.80}\"",
                               text)};
}

void write_curves(const MeasuredForce& measured, const Identified& found, const fs::path& folder) {
  const char* abscissa = measured.by_time ? "time [s]" : "depth [mm]";
  const double scale = measured.by_time ? 1 : 1e3;
  Plot plot{"Measured and fitted force", abscissa, "force [N]", {{"measured", {}}, {"model", {}}}, false};
  std::string table = fmt::format("{},measured_N,model_N\n", measured.by_time ? "time_s" : "depth_m");
  for (std::size_t i = 0; i < measured.at.size(); i++) {
    plot.curves[0].points.emplace_back(scale * measured.at[i], measured.force[i]);
    plot.curves[1].points.emplace_back(scale * measured.at[i], found.force[i]);
    table += fmt::format("{:.9g},{:.9g},{:.9g}\n", measured.at[i], measured.force[i], found.force[i]);
  }
  required(write_file(folder / "force.svg", plot_svg_file(plot)));
  required(write_file(folder / "curve.csv", table));
}

Json to_json(const IdentifyOptions& options, const MeasuredForce& measured, const Identified& found) {
  Json parameters = Json::array();
  const auto number = [](double value) { return std::isfinite(value) ? Json(value) : Json(); };
  for (const FittedParameter& p : found.parameters)
    parameters.push_back({{"key", p.key},
                          {"value", p.value},
                          {"low", p.low},
                          {"high", number(p.high)},
                          {"sensitivity", p.sensitivity},
                          {"observable", p.is_observable}});
  return {{"program", "turgor"},
          {"version", program_version()},
          {"scene", options.input.scene.string()},
          {"table", options.table.string()},
          {"rows", measured.at.size()},
          {"parameters", parameters},
          {"residual", found.residual},
          {"start_residual", found.start_residual},
          {"iterations", found.iterations},
          {"runs", found.runs},
          {"converged", found.converged},
          {"notes", found.notes}};
}

void print(const Identified& found, const fs::path& out) {
  for (const FittedParameter& p : found.parameters)
    print_plain("{}   {:.5g}   95 % interval {:.5g} to {:.5g}   10 % of it change the force by {:.2g} %\n",
                p.key, p.value, p.low, p.high, 10 * p.sensitivity);
  print_plain("residual {:.2g} % of the force (root mean square; {:.2g} % at the start), {} runs\n",
              100 * found.residual, 100 * found.start_residual, found.runs);
  for (const std::string& sentence : found.notes) note(sentence);
  std::string keys;
  for (const FittedParameter& p : found.parameters)
    if (p.key.find('[') == std::string::npos) keys += fmt::format(" --set {}={:.5g}", p.key, p.value);
  if (!keys.empty()) print_plain("\nFor other commands:{}\n", keys);
  print_plain("curves   {}\n", out.string());
}

void identify_tissue(const Exec& exec, IdentifyOptions& options) {
  options.input.parameters.clear();
  for (const std::string& text : options.fits) options.input.parameters.push_back(parameter_of(text));
  const MeasuredForce measured = required(read_measured_force(options.table));
  OutputFolder folder = open_result_folder(
      options.out.empty() ? fs::path("out") / options.table.stem() : options.out, options.force);
  const Identified found = required(identify(exec, options.input, measured), options.table.string() + ": ");
  write_curves(measured, found, folder.path());
  required(write_file(folder.path() / kReportFile, json_text(to_json(options, measured, found)) + "\n"));
  commit_results(folder);
  print(found, folder.goal());
}

}  // namespace

void add_identify_command(CLI::App& program, Global& global) {
  auto options = std::make_shared<IdentifyOptions>();
  CLI::App* command =
      program.add_subcommand("identify", "Fit tissue parameters of a scene to a measured force");
  command->add_option("scene", options->input.scene, "A scene whose tool moves as in the measurement")
      ->required();
  command
      ->add_option("table", options->table,
                   "Two columns: depth_mm,force_N (or _m, _mN), compared while the tool moves in; or "
                   "time_s,force_N, compared at the scene's time")
      ->required();
  command
      ->add_option("--fit", options->fits,
                   "KEY=START: a key of the scene and its start value, such as body.liver.young=3000 or "
                   "body.liver.viscosity.pairs[0][1]=0.1; repeated for every parameter")
      ->required()
      ->type_size(1)
      ->allow_extra_args(false);
  command->add_option("--tool", options->input.tool, "Name of the tool (default: the first)");
  command->add_option("-o,--out", options->out, "Folder for the curves (default: out/TABLE)");
  add_force_option(*command, options->force);
  add_set_option(*command, options->input.overrides);
  command->footer(
      "Example:\n  turgor identify scenes/palpation.toml press.csv --fit body.liver.young=3000\n  turgor "
      "identify "
      "hold.toml hold.csv --fit body.pad.young=5e3 --fit body.pad.viscosity.ratio=0.5 --fit "
      "body.pad.viscosity.time=0.1");
  command->callback([options, &global] { identify_tissue(Exec(global.threads), *options); });
}

}  // namespace turgor
