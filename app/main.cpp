// The program `turgor`: reads the command line, lets a command work, and turns failures into a sentence and
// an exit code: 2 when the command line or the world was not as expected, 130 when interrupted.
#include <cstdio>
#include <exception>
#include <new>
#include <string>
#include <vector>

#include "app/commands.hpp"
#include "turgor/sim/output_folder.hpp"
#include "turgor/sim/report/report.hpp"
#include "turgor/sim/scene/nearest_name.hpp"

namespace {

int fail(const std::string& message) {
  std::fprintf(stderr, "turgor: %s\n", message.c_str());
  return 2;
}

/// A word where a command should be, which is none; empty when that is not what is wrong.
std::string unknown_command(const CLI::App& app, int argc, char** argv) {
  const std::vector<const CLI::App*> commands = app.get_subcommands([](const CLI::App*) { return true; });
  if (argc < 2 || argv[1][0] == '-' || commands.empty()) return "";
  const std::string word = argv[1];
  std::vector<std::string> names;
  for (const CLI::App* command : commands) {
    if (command->get_name() == word) return unknown_command(*command, argc - 1, argv + 1);
    names.push_back(command->get_name());
  }
  return word + " is not a command" + turgor::suggestion(word, names);
}

}  // namespace

int main(int argc, char** argv) {
  turgor::remove_partial_folders_when_interrupted();
  CLI::App program{
      "Turgor: tissue you can touch. CT volumes become bodies that deform, are cut and are measured."};
  program.name("turgor");
  program.footer(
      "Examples:\n"
      "  turgor run scenes/incision.toml --out out/incision\n"
      "  turgor info patient.nii.gz\n"
      "turgor COMMAND --help tells more.");
  program.set_version_flag("--version", "turgor " + turgor::program_version());
  program.set_help_all_flag("--help-all", "Help of all commands");
  turgor::Global global;
  program.add_option("--threads", global.threads, "Threads to use; 0 = one per core")
      ->check(CLI::Range(0, 1024));
  program.fallthrough();
  turgor::add_run_command(program, global);
  turgor::add_info_command(program, global);
  turgor::add_import_command(program, global);
  turgor::add_phantom_command(program, global);
  turgor::add_mesh_command(program, global);
  turgor::add_bench_command(program, global);
  turgor::add_validate_command(program, global);
  turgor::add_calibrate_command(program, global);
  turgor::add_cache_command(program);
  if (argc < 2) return std::fputs(program.help().c_str(), stdout), 0;
  if (const std::string message = unknown_command(program, argc, argv); !message.empty())
    return fail(message);
  try {
    program.parse(argc, argv);
    return 0;
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return program.exit(error);  // --help and --version
    return fail(std::string(error.what()) + "; see turgor --help");
  } catch (const turgor::Failure& failure) {
    fail(failure.message);
    return failure.exit_code;
  } catch (const std::bad_alloc&) {
    return fail("not enough memory for this; a larger block or a smaller CT needs less");
  } catch (const std::exception& error) {
    return fail(error.what());
  }
}
