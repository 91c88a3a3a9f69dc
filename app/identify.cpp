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
  fs::path out;
  std::vector<fs::path> files;  // of tables
  std::vector<std::string> tools, fits;
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

/// Writes the curves of a table whose forces of the model begin at `first`. `suffix`: of the file names.
void write_curves(const MeasuredForce& measured, const double* model, const std::string& suffix,
                  const fs::path& folder) {
  const char* abscissa = measured.by_time ? "time [s]" : "depth [mm]";
  const double scale = measured.by_time ? 1 : 1e3;
  Plot plot{"Measured and fitted force", abscissa, "force [N]", {{"measured", {}}, {"model", {}}}, false};
  std::string table = fmt::format("{},measured_N,model_N\n", measured.by_time ? "time_s" : "depth_m");
  for (std::size_t i = 0; i < measured.at.size(); i++) {
    plot.curves[0].points.emplace_back(scale * measured.at[i], measured.force[i]);
    plot.curves[1].points.emplace_back(scale * measured.at[i], model[i]);
    table += fmt::format("{:.9g},{:.9g},{:.9g}\n", measured.at[i], measured.force[i], model[i]);
  }
  required(write_file(folder / fmt::format("force{}.svg", suffix), plot_svg_file(plot)));
  required(write_file(folder / fmt::format("curve{}.csv", suffix), table));
}
/// Curves of all tables: curve.csv of one, curve-1.csv and so on of several.
void write_curves(const std::vector<MeasuredForce>& tables, const Identified& found, const fs::path& folder) {
  const double* model = found.force.data();
  for (std::size_t t = 0; t < tables.size(); t++) {
    write_curves(tables[t], model, tables.size() == 1 ? "" : fmt::format("-{}", t + 1), folder);
    model += tables[t].at.size();
  }
}

Json to_json(const IdentifyOptions& options, const std::vector<MeasuredForce>& tables,
             const Identified& found) {
  Json parameters = Json::array(), measured = Json::array();
  for (std::size_t t = 0; t < tables.size(); t++)
    measured.push_back({{"file", options.files[t].string()},
                        {"tool", tables[t].tool},
                        {"units", tables[t].units},
                        {"rows", tables[t].at.size()},
                        {"residual", found.residuals[t]}});
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
          {"tables", measured},
          {"parameters", parameters},
          {"residual", found.residual},
          {"start_residual", found.start_residual},
          {"iterations", found.iterations},
          {"runs", found.runs},
          {"converged", found.converged},
          {"notes", found.notes}};
}

void print(const IdentifyOptions& options, const std::vector<MeasuredForce>& tables, const Identified& found,
           const fs::path& out) {
  for (std::size_t t = 0; t < tables.size(); t++)
    print_plain("{} read as {}\n", options.files[t].string(), tables[t].units);
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

/// Reads the tables; the first --tool names the tool of the first table, and so on.
std::vector<MeasuredForce> read_tables(const IdentifyOptions& options) {
  if (options.tools.size() > options.files.size())
    throw Failure{2, fmt::format("--tool: expected at most one for each table, found {} for {}",
                                 options.tools.size(), options.files.size())};
  std::vector<MeasuredForce> tables;
  for (const fs::path& file : options.files) {
    MeasuredForce table = required(read_measured_force(file));
    if (tables.size() < options.tools.size()) table.tool = options.tools[tables.size()];
    tables.push_back(std::move(table));
  }
  return tables;
}

void identify_tissue(const Exec& exec, IdentifyOptions& options) {
  options.input.parameters.clear();
  for (const std::string& text : options.fits) options.input.parameters.push_back(parameter_of(text));
  const std::vector<MeasuredForce> tables = read_tables(options);
  const fs::path& first = options.files[0];
  OutputFolder folder =
      open_result_folder(options.out.empty() ? fs::path("out") / first.stem() : options.out, options.force);
  const Identified found =
      required(identify(exec, options.input, tables), tables.size() == 1 ? first.string() + ": " : "");
  write_curves(tables, found, folder.path());
  required(write_file(folder.path() / kReportFile, json_text(to_json(options, tables, found)) + "\n"));
  commit_results(folder);
  print(options, tables, found, folder.goal());
}

}  // namespace

void add_identify_command(CLI::App& program, Global& global) {
  auto options = std::make_shared<IdentifyOptions>();
  CLI::App* command =
      program.add_subcommand("identify", "Fit tissue parameters of a scene to a measured force");
  command->add_option("scene", options->input.scene, "A scene whose tool moves as in the measurement")
      ->required();
  command
      ->add_option(
          "table", options->files,
          "Two columns: depth_mm,force_N (or other units, as in \"depth [m]\"), compared while the tool "
          "moves in; or time_s,force_N, compared at the scene's time. Several tables, such as those of two "
          "probes, are fitted together")
      ->required();
  command
      ->add_option("--fit", options->fits,
                   "KEY=START: a key of the scene and its start value, such as body.liver.young=3000 or "
                   "body.liver.viscosity.pairs[0][1]=0.1; repeated for every parameter")
      ->required()
      ->type_size(1)
      ->allow_extra_args(false);
  command
      ->add_option(
          "--tool", options->tools,
          "Name of the tool of the table (default: the first of the scene); repeated for every table")
      ->type_size(1)
      ->allow_extra_args(false);
  command->add_option("-o,--out", options->out,
                      "Folder for the curves (default: out/ and the name of the first table)");
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
