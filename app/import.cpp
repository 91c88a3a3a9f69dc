// `turgor import`: converts a CT of any readable format to one file.
#include <memory>

#include "app/commands.hpp"
#include "app/print.hpp"
#include "turgor/io/ct.hpp"

namespace turgor {

namespace {

struct ImportOptions {
  std::string path, output, series;
  bool straighten = false;
};

CtFile read_with_bar(const ImportOptions& options, const Exec& exec) {
  ProgressBar bar("reading");
  return required(read_ct(exec, options.path, {options.series, bar.callback(), options.straighten}));
}

void run_import(const ImportOptions& options, const Global& global) {
  required(check_volume_goal(options.output));
  if (replaces_input(options.output, options.path))
    throw Failure{2, fmt::format("-o {}: would replace an input file", options.output)};
  const CtFile file = read_with_bar(options, Exec(global.threads));
  for (const std::string& note : file.notes) turgor::note(note);
  required(write_ct(options.output, file.ct));
  const Int3 size = file.ct.grid.size;
  print_plain("{}: {} x {} x {} samples from {}\n", options.output, size.x, size.y, size.z, file.format);
}

}  // namespace

void add_import_command(CLI::App& program, Global& global) {
  CLI::App* command = program.add_subcommand("import", "Convert a CT to one NIfTI, NRRD or MetaImage file");
  auto options = std::make_shared<ImportOptions>();
  command->add_option("path", options->path, "A DICOM folder or one of its files, .nii, .nii.gz, .nrrd, .mha")
      ->required();
  command->add_option("-o,--output", options->output, "Output file: .nii, .nii.gz, .nrrd or .mha")
      ->required();
  command->add_option("--series", options->series, "DICOM: the series, by number or SeriesInstanceUID");
  command->add_flag("--straighten", options->straighten,
                    "DICOM: resample the slices of a tilted gantry to a straight grid");
  command->footer("Example:\n  turgor import ct/ -o patient.nii.gz");
  command->callback([options, &global] { run_import(*options, global); });
}

}  // namespace turgor
