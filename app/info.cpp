// `turgor info`: describes a CT file and a segmentation of it. Meshes are in info_mesh.cpp.
#include <algorithm>
#include <memory>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/commands.hpp"
#include "app/info_mesh.hpp"
#include "app/print.hpp"
#include "turgor/geometry/label_measures.hpp"
#include "turgor/geometry/reorient.hpp"
#include "turgor/io/ct.hpp"
#include "turgor/io/files/file.hpp"
#include "turgor/io/mesh/unit_question.hpp"
#include "turgor/io/volume/organ_names.hpp"
#include "turgor/sim/report/report.hpp"

namespace turgor {

namespace {

struct InfoOptions {
  std::string path, labels, series, json;
  double scale = 1;  // of a mesh
};

/// Anatomical directions in which the axes i, j, k grow: "LPS", "RAS", …
std::string orientation(const Grid& grid) {
  constexpr const char* kTowards[3] = {"RL", "AP", "IS"};
  std::string letters;
  for (const Vec3d& axis : grid.axes.column) {
    int main = 0;
    for (int a = 1; a < 3; a++)
      if (std::abs(axis[a]) > std::abs(axis[main])) main = a;
    letters += kTowards[main][axis[main] > 0];
  }
  return letters;
}

Vec3d to_ras(Vec3d lps) { return {-lps.x, -lps.y, lps.z}; }

Json describe(const std::string& path, const CtFile& file) {
  const Grid& grid = file.ct.grid;
  const HuSummary hu = summarize(file.ct);
  const Vec3d last{grid.size.x - 1.0, grid.size.y - 1.0, grid.size.z - 1.0};
  const Vec3d a = point_at(grid, {}), b = point_at(grid, last);
  Json json{{"path", path}, {"format", file.format}, {"files", file.files}};
  if (file.format == "DICOM")
    json.update({{"patient", file.patient},
                 {"study", file.study},
                 {"series", file.series},
                 {"modality", file.modality}});
  json.update({{"size", {grid.size.x, grid.size.y, grid.size.z}},
               {"spacing_mm", triple(grid.spacing * 1e3)},
               {"orientation", orientation(grid)},
               {"extent_mm", triple(hadamard(grid.spacing, last + Vec3d{1, 1, 1}) * 1e3)},
               {"first_sample_lps_mm", triple(a * 1e3)},
               {"last_sample_lps_mm", triple(b * 1e3)},
               {"hu", {{"lowest", hu.lowest}, {"highest", hu.highest}, {"mean", hu.mean}}},
               {"fractions", {{"air", hu.air}, {"fat", hu.fat}, {"soft", hu.soft}, {"bone", hu.bone}}}});
  if (!file.notes.empty()) json["notes"] = file.notes;
  return json;
}

/// Describes the labels; adds a note if the file does not name them.
Json describe_labels(const std::string& path, const CtVolume& ct, Json& notes) {
  const LabelFile read = required(read_labels_of(path, ct.grid));
  if (!read.has_names)
    notes.push_back(path + ": the file names none of its labels: names are those of TotalSegmentator");
  const auto name_of = [&](int label) {
    const auto found = read.names.find(label);
    return found == read.names.end() ? std::string{} : found->second;
  };
  Json list = Json::array();
  for (const LabelMeasure& m : measure_labels(read.labels, &ct))
    list.push_back({{"label", m.label},
                    {"name", name_of(m.label)},
                    {"voxels", m.voxels},
                    {"volume_ml", m.volume * 1e6},
                    {"centroid_ras_mm", triple(to_ras(m.centroid) * 1e3)},
                    {"centroid_lps_mm", triple(m.centroid * 1e3)},
                    {"mean_hu", m.mean_hu}});
  return list;
}

std::string format_triple(const Json& v, int digits) {
  return fmt::format("{:.{}f}, {:.{}f}, {:.{}f}", v[0].get<double>(), digits, v[1].get<double>(), digits,
                     v[2].get<double>(), digits);
}

void print(const Json& json) {
  const auto row = [](const char* name, const std::string& text) {
    print_plain("  {:<12} {}\n", name, text);
  };
  const auto text = [&](const char* key) { return json.value(key, std::string{}); };
  print_plain("{}\n", text("path"));
  row("format", fmt::format("{}, {} {}", text("format"), json["files"].get<int>(),
                            json["files"] == 1 ? "file" : "files"));
  for (const char* field : {"patient", "study", "series", "modality"})
    if (!text(field).empty()) row(field, text(field));
  row("size", fmt::format("{} x {} x {}", json["size"][0].get<int>(), json["size"][1].get<int>(),
                          json["size"][2].get<int>()));
  row("spacing", format_triple(json["spacing_mm"], 4) + " mm");
  row("orientation", text("orientation") + " (directions in which i, j, k grow)");
  row("extent", format_triple(json["extent_mm"], 1) + " mm");
  row("from", format_triple(json["first_sample_lps_mm"], 2) + " mm LPS");
  row("to", format_triple(json["last_sample_lps_mm"], 2) + " mm LPS");
  const Json& hu = json["hu"];
  row("HU", fmt::format("{} to {}, mean {:.1f}", hu["lowest"].get<int>(), hu["highest"].get<int>(),
                        hu["mean"].get<double>()));
  const Json& f = json["fractions"];
  const auto percent = [&](const char* kind) { return 100 * f[kind].get<double>(); };
  row("tissue",
      fmt::format(
          "air {:.1f} % (below {} HU), fat {:.1f} % (below {}), soft {:.1f} %, bone {:.1f} % (from {})",
          percent("air"), kAirBelow, percent("fat"), kFatBelow, percent("soft"), percent("bone"), kBoneFrom));
  if (json.contains("notes"))
    for (const Json& note : json["notes"]) row("note", note.get<std::string>());
}

/// Number of characters of a UTF-8 text.
int characters_of(const std::string& text) {
  return int(
      std::count_if(text.begin(), text.end(), [](char c) { return (std::uint8_t(c) & 0xc0) != 0x80; }));
}

void print_labels(const Json& labels) {
  int width = 22;  // of the names
  for (const Json& m : labels) width = std::max(width, characters_of(m["name"].get<std::string>()));
  print_plain("\n  {:>5} {:<{}} {:>9} {:>10} {:>8}  {:<26} {}\n", "label", "name", width, "voxels", "mL",
              "mean HU", "centroid RAS [mm]", "centroid LPS [mm]");
  for (const Json& m : labels)
    print_plain("  {:>5} {:<{}} {:>9} {:>10.3f} {:>8.2f}  {:<26} {}\n", m["label"].get<int>(),
                m["name"].get<std::string>(), width, m["voxels"].get<std::size_t>(),
                m["volume_ml"].get<double>(), m["mean_hu"].get<double>(),
                format_triple(m["centroid_ras_mm"], 2), format_triple(m["centroid_lps_mm"], 2));
}

/// Lists the DICOM series of a folder that is not a readable volume, for the error message.
std::string list_series(const InfoOptions& options, const Exec& exec) {
  const std::string series = list_dicom_series(exec, options.path);
  return series.empty() ? "" : "\nSeries in this folder:" + series;
}

Json inform_about_ct(const InfoOptions& options, const Exec& exec) {
  if (options.scale != 1)
    throw Failure{2, fmt::format("{}: --scale applies to meshes; a CT has its own units", options.path)};
  Json json;
  {
    ProgressBar bar("reading");
    const Result<CtFile> file = read_ct(exec, options.path, {options.series, bar.callback()});
    if (!file) throw Failure{2, file.error().message + list_series(options, exec)};
    json = describe(options.path, *file);
    if (!options.labels.empty()) json["labels"] = describe_labels(options.labels, file->ct, json["notes"]);
    if (json["notes"].empty()) json.erase("notes");
  }
  print(json);
  if (json.contains("labels")) print_labels(json["labels"]);
  return json;
}

Json inform_about_mesh(const InfoOptions& options, const Exec& exec) {
  if (!options.labels.empty() || !options.series.empty())
    throw Failure{2, fmt::format("{}: --labels and --series apply to CTs; this is a mesh", options.path)};
  Json json = describe_mesh(exec, options.path, options.scale);
  print_mesh(json);
  double size = 0;  // largest extent [m]
  for (std::size_t axis = 0; axis < 3; axis++)
    size = std::max(size, json["box_to_m"][axis].get<double>() - json["box_from_m"][axis].get<double>());
  if (const std::string question = unit_question(size); !question.empty() && options.scale == 1)
    print_plain("warning: {}\n", question);
  return json;
}

/// Checks --json before long work.
void check_json_goal(const InfoOptions& options) {
  required(check_file_goal(options.json));
  for (const std::string& input : {options.path, options.labels})
    if (replaces_input(options.json, input))
      throw Failure{2, fmt::format("--json {}: would replace an input file", options.json)};
}

void run_info(const InfoOptions& options, const Global& global) {
  if (options.path.ends_with(".toml") && std::filesystem::exists(options.path))
    throw Failure{2,
                  fmt::format("{0}: expected a CT or a mesh, found a scene; turgor run {0} --check reads it",
                              options.path)};
  if (!options.json.empty()) check_json_goal(options);
  const Exec exec(global.threads);
  const Json json =
      is_mesh_file(options.path) ? inform_about_mesh(options, exec) : inform_about_ct(options, exec);
  if (options.json.empty()) return;
  const std::string text = json_text(json, 2) + "\n";
  required(write_file(options.json, text));
}

}  // namespace

void add_info_command(CLI::App& program, Global& global) {
  CLI::App* command = program.add_subcommand("info",
                                             "Describe a CT (size, position, densities, labels of a "
                                             "segmentation) or a mesh (elements, regions, "
                                             "volume, angles)");
  auto options = std::make_shared<InfoOptions>();
  command
      ->add_option(
          "path", options->path,
          "A DICOM folder or one of its files, .nii, .nii.gz, .nrrd, .mha; or a mesh: .msh, .vtk, .vtu, "
          ".node, .mesh, .obj, .stl, .ply")
      ->required();
  command->add_option("--labels", options->labels,
                      "A segmentation of the CT; prints sizes and centroids of its labels");
  command->add_option("--series", options->series, "DICOM: the series, by number or SeriesInstanceUID");
  command->add_option("--scale", options->scale, "Mesh: meters per unit of its file, 0.001 for mm")
      ->check(number_within(1e-12, 1e6, "m"));
  command->add_option("--json", options->json, "Also write the output to this file");
  command->footer(
      "Example:\n  turgor info ct/ --labels segmentation.nii.gz --json ct.json\n  turgor info liver.msh "
      "--scale 0.01");
  command->callback([options, &global] { run_info(*options, global); });
}

}  // namespace turgor
