// The program `turgor`: reads the command line, lets a command work, and turns failures into a sentence and
// an exit code: 2 when the command line or the world was not as expected, 3 when numbers that were not finite
// ended a simulation early, 130 when interrupted, 141, without a sentence, when nobody reads what it prints
// any more.
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <iostream>
#include <new>
#include <string>
#include <system_error>
#include <vector>

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include "app/commands.hpp"
#include "turgor/io/files/unfinished.hpp"
#include "turgor/sim/report/report.hpp"
#include "turgor/sim/scene/nearest_name.hpp"

namespace {

int fail(const std::string& message) {
  std::fprintf(stderr, "turgor: %s\n", message.c_str());
  return 2;
}

/// What could not be printed is lost like a file that could not be written. A reader that went away knows it.
int fail_to_print(int reason) {
  if (reason == EPIPE) return 128 + SIGPIPE;
  return fail(std::string("standard output: cannot be written: ") + std::strerror(reason));
}

/// Prints what waits to be printed; the exit code then.
int end_with(int code) {
  std::cout.flush();
  if (std::fflush(stdout) == 0 && !std::ferror(stdout)) return code;
  const int reason = errno;
  return code == 0 ? fail_to_print(reason) : code;
}

/// A stream that is closed would be the number of the next file that is opened, and be printed into.
void hold_standard_streams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    if (fcntl(stream, F_GETFD) < 0) (void)!open("/dev/null", stream == STDERR_FILENO ? O_WRONLY : O_RDONLY);
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

/// The exit code.
int run(int argc, char** argv) {
  CLI::App program{
      "Turgor: tissue you can touch. CT volumes become bodies that deform, are cut and are measured."};
  program.name("turgor");
  program.footer(
      "Examples:\n"
      "  turgor run scenes/incision.toml --out out/incision\n"
      "  turgor info patient.nii.gz\n"
      "turgor COMMAND --help tells more.\n"
      "Exit codes: 0 done; 2 something was not as expected, a sentence says what; 3 numbers that were not\n"
      "finite ended a simulation early, the results up to then are there, or a figure of validate is beyond\n"
      "its bound; 130 interrupted, nothing is left.");
  program.set_version_flag("--version", "turgor " + turgor::program_version());
  program.set_help_all_flag("--help-all", "Help of all commands");
  turgor::Global global;
  program.add_option("--threads", global.threads, "Threads to use; 0 = one per core")
      ->check(CLI::Range(0, 1024));
  program.fallthrough();
  turgor::add_run_command(program, global);
  turgor::add_replay_command(program, global);
  turgor::add_view_command(program, global);
  turgor::add_info_command(program, global);
  turgor::add_import_command(program, global);
  turgor::add_phantom_command(program, global);
  turgor::add_mesh_command(program, global);
  turgor::add_bench_command(program, global);
  turgor::add_validate_command(program, global);
  turgor::add_calibrate_command(program, global);
  turgor::add_cache_command(program);
  turgor::add_devices_command(program);
  if (argc < 2) return fmt::print("{}", program.help()), 0;
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
  } catch (const std::system_error& error) {  // fmt::print
    return fail_to_print(error.code().value());
  } catch (const std::bad_alloc&) {
    return fail("not enough memory for this; a larger block or a smaller CT needs less");
  } catch (const std::exception& error) {
    return fail(error.what());
  }
}

}  // namespace

int main(int argc, char** argv) {
  hold_standard_streams();
  turgor::remove_unfinished_when_interrupted();
  return end_with(run(argc, argv));
}
