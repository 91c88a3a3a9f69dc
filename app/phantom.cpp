// `turgor phantom`: writes a synthetic CT as a DICOM folder or one file, or the surface of a liver or of
// forceps.
#include "turgor/geometry/phantom.hpp"

#include <filesystem>
#include <map>
#include <memory>
#include <optional>

#include <fmt/format.h>

#include "app/commands.hpp"
#include "app/print.hpp"
#include "turgor/geometry/phantom_liver.hpp"
#include "turgor/io/ct.hpp"
#include "turgor/io/files/file.hpp"
#include "turgor/io/mesh/mesh_files.hpp"

namespace turgor {

namespace {

namespace fs = std::filesystem;

struct PhantomOptions {
  std::string kind, labels, output;
  std::vector<int> size;
  std::vector<double> spacing_mm;
  std::optional<std::uint64_t> seed;  // default: 1
  std::optional<double> detail;       // default: 1
};

const std::map<std::string, PhantomKind> kKinds = {
    {"torso", PhantomKind::kTorso}, {"head", PhantomKind::kHead}, {"leg", PhantomKind::kLeg}};

/// Parameters of the phantom. If only a size is given, the extent stays and the spacing changes.
PhantomParams make_params(const PhantomOptions& options) {
  PhantomParams params = default_phantom(kKinds.at(options.kind));
  params.seed = options.seed.value_or(1);
  for (int axis = 0; axis < 3 && !options.size.empty(); axis++) {
    const int size = options.size[std::size_t(axis)];
    params.spacing[axis] *= double(params.size[axis]) / size;
    params.size[axis] = size;
  }
  for (int axis = 0; axis < 3 && !options.spacing_mm.empty(); axis++)
    params.spacing[axis] = options.spacing_mm[std::size_t(axis)] * 1e-3;
  return params;
}

bool is_file_name(const std::string& name) {
  for (const char* extension : {".nii", ".nii.gz", ".nrrd", ".mha"})
    if (name.ends_with(extension)) return true;
  return false;
}

/// Checks that all output paths can be written, before long work.
Status check_goals(const PhantomOptions& options) {
  const bool file = is_file_name(options.output);
  if (Status goal = file ? check_volume_goal(options.output) : check_dicom_goal(options.output); !goal)
    return goal;
  if (options.labels.empty()) return Done{};
  if (Status goal = check_volume_goal(options.labels); !goal) return goal;
  const Result<fs::path> labels = resolved_goal(options.labels), output = resolved_goal(options.output);
  if (!labels || !output || *labels != *output) return Done{};
  return Error{fmt::format("{}: --labels and --output name the same file", options.labels)};
}

Status write_phantom(const PhantomOptions& options, const CtVolume& ct, const Exec& exec) {
  if (is_file_name(options.output)) return write_ct(options.output, ct);
  ProgressBar bar("writing");
  return write_dicom(exec, options.output, ct, patient_alone("Phantom^" + options.kind), bar.callback());
}

CtVolume make_with_bar(const PhantomParams& params, const Exec& exec, LabelVolume* labels) {
  ProgressBar bar("painting");
  return make_phantom(exec, params, labels, bar.callback());
}

/// Writes a liver or forceps as triangles.
void run_surface(const PhantomOptions& options) {
  if (!options.output.ends_with(".obj"))
    throw Failure{2, fmt::format("--output: expected a file that ends in .obj, found {}", options.output)};
  if (!options.size.empty() || !options.spacing_mm.empty() || !options.labels.empty())
    throw Failure{2, fmt::format("phantom {}: a surface has no --size, --spacing or --labels", options.kind)};
  required(check_file_goal(options.output));
  const TriMesh mesh =
      options.kind == "liver" ? phantom_liver(options.detail.value_or(1)) : phantom_forceps();
  required(write_obj(options.output, mesh));
  print_plain("{}: {} of {} vertices and {} triangles\n", options.output, options.kind, mesh.vertices.size(),
              mesh.triangles.size());
}

void run_phantom(const PhantomOptions& options, const Global& global) {
  const bool is_surface = options.kind == "liver" || options.kind == "forceps";
  if (options.detail && options.kind != "liver")
    throw Failure{2, fmt::format("phantom {}: only the liver has --detail", options.kind)};
  if (options.seed && is_surface)
    throw Failure{2, fmt::format("phantom {}: a surface has no --seed", options.kind)};
  if (is_surface) return run_surface(options);
  const Exec exec(global.threads);
  const PhantomParams params = make_params(options);
  if (const double samples = double(params.size.x) * params.size.y * params.size.z;
      samples > double(1ull << 33))
    throw Failure{2, fmt::format("--size: {:.3g} samples; expected at most 2^33", samples)};
  required(check_goals(options));
  LabelVolume labels;
  const CtVolume ct = make_with_bar(params, exec, options.labels.empty() ? nullptr : &labels);
  required(write_phantom(options, ct, exec));
  if (!options.labels.empty()) required(write_labels(options.labels, labels));
  print_plain("{}: {} of {} x {} x {} samples, {:.4g} x {:.4g} x {:.4g} mm\n", options.output, options.kind,
              params.size.x, params.size.y, params.size.z, params.spacing.x * 1e3, params.spacing.y * 1e3,
              params.spacing.z * 1e3);
}

}  // namespace

void add_phantom_command(CLI::App& program, Global& global) {
  CLI::App* command =
      program.add_subcommand("phantom", "Generate a synthetic CT with known anatomy, or an organ surface");
  auto options = std::make_shared<PhantomOptions>();
  command->add_option("kind", options->kind, "torso, head or leg: a CT; liver or forceps: a surface")
      ->required()
      ->check(one_of({"torso", "head", "leg", "liver", "forceps"}));
  command
      ->add_option("--size", options->size, "Samples along x, y, z (default 512 512 300; head 544, leg 1152)")
      ->expected(3)
      ->check(CLI::Range(1, 65535));
  command
      ->add_option("--spacing", options->spacing_mm,
                   "Distance of samples [mm] (default: covers the whole phantom)")
      ->expected(3)
      ->check(number_within(0.01, 100, "mm"));
  command->add_option("--seed", options->seed, "Seed of the noise and of small variations of the anatomy");
  command->add_option("--labels", options->labels,
                      "Also write the anatomy as labels (numbers of TotalSegmentator; 200 = nodule)");
  command
      ->add_option("-o,--output", options->output,
                   "A new DICOM folder, or a file: .nii, .nii.gz, .nrrd, .mha; for a surface: .obj")
      ->required();
  command
      ->add_option("--detail", options->detail, "liver: factor by which edges are shorter; 1 = 3116 vertices")
      ->check(number_within(0.2, 20, "1"));
  command->footer(
      "Examples:\n  turgor phantom torso --size 512 512 300 -o ct/\n  turgor phantom liver -o liver.obj");
  command->callback([options, &global] { run_phantom(*options, global); });
}

}  // namespace turgor
