// The program `turgor`: reads the command line, lets a command work, and turns failures into a sentence and an exit code
// (1: wrong usage, 2: the world was not as expected).
#include <cstdio>
#include <exception>

#include "app/commands.hpp"

int main(int argc, char** argv) {
  CLI::App program{"Turgor: tissue you can touch. CT volumes become bodies that deform, are cut and are measured."};
  program.name("turgor");
  program.require_subcommand(1);
  program.set_help_all_flag("--help-all", "Help of all commands");
  turgor::Global global;
  program.add_option("--threads", global.threads, "Threads to use; 0 = one per core")->check(CLI::NonNegativeNumber);
  program.fallthrough();
  turgor::add_info_command(program, global);
  turgor::add_import_command(program, global);
  turgor::add_phantom_command(program, global);
  try {
    program.parse(argc, argv);
    return 0;
  } catch (const CLI::ParseError& error) {
    return program.exit(error) == 0 ? 0 : 1;
  } catch (const turgor::Failure& failure) {
    std::fprintf(stderr, "turgor: %s\n", failure.message.c_str());
    return failure.exit_code;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "turgor: %s\n", error.what());
    return 2;
  }
}
