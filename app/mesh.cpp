// `turgor mesh`: converts a label of a segmentation or a closed surface to a tetrahedral mesh.
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "app/commands.hpp"
#include "app/print.hpp"
#include "turgor/geometry/mesh_quality.hpp"
#include "turgor/geometry/organ_mesh.hpp"
#include "turgor/io/ct.hpp"
#include "turgor/io/files/file.hpp"
#include "turgor/io/mesh/mesh_files.hpp"
#include "turgor/io/mesh/solid_files.hpp"
#include "turgor/io/mesh/surface_files.hpp"
#include "turgor/sim/scene/scene_label.hpp"

namespace turgor {

namespace {

struct MeshOptions {
  std::string input, output;
  std::vector<std::string> labels;  // by number or by name
  std::optional<double> size;       // [m]
  double scale = 1;
  double most = MeshBound{}.elements;
  std::string cavities = "fill";
};

constexpr double kLargestSize = 0.008;  // unless --size gives another one [m]

/// Prints the forecast of a mesh that takes some time.
MeshBound bound_of(const MeshOptions& options) {
  constexpr double kNoticed = 2;  // [s]
  return {.elements = options.most,
          .edges = options.size ? 0 : kEdgesAcross,
          .begin = [](const MeshForecast& forecast) {
            if (forecast.seconds > kNoticed)
              print_plain(stderr, "about {:.2g} million tetrahedra, in about {:.0f} s\n",
                          forecast.elements * 1e-6, forecast.seconds);
          }};
}

OrganMesh mesh_surface(const MeshOptions& options, const Exec& exec) {
  if (!options.labels.empty())
    throw Failure{2, options.input + " is a surface; --label applies to segmentations"};
  const ReadSurface read = required(read_surface(options.input, options.scale));
  ProgressBar bar("meshing");
  OrganMesh body = required(mesh_of_surface(exec, read.mesh, options.size.value_or(kLargestSize),
                                            bar.callback(), Sides::kFlat, bound_of(options)),
                            options.input + ": ");
  body.notes.insert(body.notes.begin(), read.notes.begin(), read.notes.end());
  return body;
}

/// Numbers of the requested labels; prints a note if the file does not name its labels.
std::vector<int> label_numbers(const MeshOptions& options) {
  SceneLabels names = labels_of(options.input);
  std::vector<int> numbers;
  for (const std::string& name : options.labels) {
    numbers.push_back(required(find_label(name, names), "--label: "));
    if (const std::string text = std::exchange(names.note, {}); !text.empty()) note(text);
  }
  return numbers;
}

OrganMesh mesh_labels(const MeshOptions& options, const Exec& exec) {
  const LabelFile file = required(read_labels(options.input));
  if (options.scale != 1) throw Failure{2, "--scale applies to surfaces; a segmentation has its own units"};
  const std::vector<int> labels = label_numbers(options);
  ProgressBar bar("meshing");
  return required(
      mesh_of_labels(exec, file.labels, labels, options.size.value_or(kLargestSize), bar.callback(),
                     Sides::kFlat, bound_of(options), {options.cavities == "fill", {}}),
      options.input + ": ");
}

Status write_mesh(const std::filesystem::path& path, const SolidMesh& mesh) {
  if (path.extension() == ".vtu") return write_vtu(path, mesh, {}, {});
  return write_msh(path, mesh);
}

void print_regions(const SolidMesh& mesh) {
  for (const int label : std::set<int>(mesh.regions.begin(), mesh.regions.end())) {
    std::size_t count = 0;
    double sum = 0;
    for (std::size_t e = 0; e < element_count(mesh); e++)
      if (region(mesh, e) == label) count++, sum += volume(mesh, e);
    print_plain("  region {}: {} tetrahedra, {:.4g} mL\n", label, count, sum * 1e6);
  }
}

void print_mesh(const OrganMesh& body, const MeshOptions& options) {
  const MeshQuality quality = measure_quality(body.mesh);
  print_plain("{}: {} vertices, {} tetrahedra\n", options.output, body.mesh.vertices.size(),
              element_count(body.mesh));
  print_plain("  volume {:.4g} mL, input {:.4g} mL ({:+.2f} %)\n", quality.volume * 1e6,
              body.input_volume * 1e6, (quality.volume / body.input_volume - 1) * 100);
  print_plain("  dihedral angles {:.1f} to {:.1f} degrees\n", quality.min_dihedral, quality.max_dihedral);
  print_plain("  edges {:.3g} to {:.3g} mm\n", quality.shortest_edge * 1e3, quality.longest_edge * 1e3);
  if (options.labels.size() > 1) print_regions(body.mesh);
}

void run_mesh(const MeshOptions& options, const Global& global) {
  const std::string extension = std::filesystem::path(options.output).extension().string();
  if (extension != ".vtu" && extension != ".msh")
    throw Failure{2, fmt::format("{}: expected a name that ends in .vtu or .msh", options.output)};
  required(check_file_goal(options.output));
  const Exec exec(global.threads);
  const OrganMesh body =
      is_surface_file(options.input) ? mesh_surface(options, exec) : mesh_labels(options, exec);
  for (const std::string& note : body.notes) turgor::note(note);
  required(write_mesh(options.output, body.mesh));
  print_mesh(body, options);
}

}  // namespace

void add_mesh_command(CLI::App& program, Global& global) {
  CLI::App* command = program.add_subcommand("mesh", "Mesh a label or a closed surface with tetrahedra");
  auto options = std::make_shared<MeshOptions>();
  command
      ->add_option("input", options->input,
                   "A segmentation (.nii, .nii.gz, .nrrd, .mha) or a surface (.obj, .stl, .ply, .vtp, .vtk)")
      ->required();
  command->add_option("-o,--output", options->output, "Output file: .vtu or .msh")->required();
  command->add_option("--label", options->labels,
                      "Labels of the body by number or name, such as an organ and its nodules; each "
                      "becomes a region");
  command
      ->add_option(
          "--size", options->size,
          "Approximate edge length [m] (default: 0.008, but at most a fifth of the cube root of the volume)")
      ->check(number_within(1e-6, 100, "m"));
  command->add_option("--most", options->most, "Limit of the expected number of tetrahedra (default: 1e7)")
      ->check(number_within(1, 1e9, "1"));
  command
      ->add_option("--cavities", options->cavities,
                   "Where the labels enclose other ones: \"fill\" them with the first label's region, or "
                   "\"keep\" them hollow (default: fill)")
      ->check(CLI::IsMember({"fill", "keep"}));
  command->add_option("--scale", options->scale, "Meters per unit of a surface's file: 0.001 for mm")
      ->check(number_within(1e-12, 1e6, "m"));
  command->footer(
      "Examples:\n"
      "  turgor mesh segmentation.nii.gz --label liver --size 0.008 -o liver.vtu\n"
      "  turgor mesh liver.stl --scale 0.001 -o liver.msh");
  command->callback([options, &global] { run_mesh(*options, global); });
}

}  // namespace turgor
