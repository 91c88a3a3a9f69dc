#include "app/program.hpp"

#include <algorithm>
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

#include "app/print.hpp"
#include "turgor/core/thread_limit.hpp"
#include "turgor/io/files/unfinished.hpp"
#include "turgor/sim/report/report.hpp"
#include "turgor/sim/scene/nearest_name.hpp"
#include "turgor/view/drawing_process.hpp"

namespace turgor {

namespace {

int fail(const std::string& message) {
  print_message("turgor", message);
  return 2;
}

/// Exit code after a failed write to standard output. A closed pipe needs no message.
int fail_to_print(int reason) {
  if (reason == EPIPE) return 128 + SIGPIPE;
  return fail(std::string("standard output: cannot be written: ") + std::strerror(reason));
}

/// Flushes standard output and returns the exit code.
int end_with(int code) {
  std::cout.flush();
  if (std::fflush(stdout) == 0 && !std::ferror(stdout)) return code;
  const int reason = errno;
  return code == 0 ? fail_to_print(reason) : code;
}

/// Opens closed standard streams on /dev/null. Otherwise the next opened file would get the number of a
/// stream, and messages would be written to it.
void hold_standard_streams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    if (fcntl(stream, F_GETFD) < 0) (void)!open("/dev/null", stream == STDERR_FILENO ? O_WRONLY : O_RDONLY);
}

/// Message about an unknown command; empty if the command line has another problem.
std::string unknown_command(const CLI::App& app, int argc, char** argv) {
  const std::vector<const CLI::App*> commands = app.get_subcommands([](const CLI::App*) { return true; });
  if (argc < 2 || argv[1][0] == '-' || commands.empty()) return "";
  const std::string word = argv[1];
  std::vector<std::string> names;
  for (const CLI::App* command : commands) {
    if (command->get_name() == word) return unknown_command(*command, argc - 1, argv + 1);
    names.push_back(command->get_name());
  }
  return word + " is not a command" + suggestion(word, names);
}

/// "FILE: " of the command's first argument, such as the scene of run; empty without one.
std::string input_of(const CLI::App& program) {
  for (const CLI::App* command : program.get_subcommands())
    for (const CLI::Option* option : command->get_options())
      if (option->get_positional() && option->count() > 0) return option->results().front() + ": ";
  return {};
}

/// Message about a command line that does not parse. An unknown option is named with the nearest known one.
std::string problem_of(const CLI::App& program, const CLI::ParseError& error, int argc, char** argv) {
  // the command that was given, with its options and those of the program
  const CLI::App* command = &program;
  std::string help = "; see turgor";
  std::vector<std::string> known;
  for (;;) {
    for (const CLI::Option* option : command->get_options())
      for (const std::string& name : option->get_lnames()) known.push_back("--" + name);
    if (command->get_subcommands().empty()) break;
    command = command->get_subcommands().front();
    help += " " + command->get_name();
  }
  help += " --help";
  // the first unknown option
  const bool has_unknown = dynamic_cast<const CLI::ExtrasError*>(&error);
  for (int n = 1; has_unknown && n < argc; n++) {
    const std::string word(argv[n], std::strcspn(argv[n], "="));
    if (!word.starts_with("--") || std::find(known.begin(), known.end(), word) != known.end()) continue;
    const std::string nearest = nearest_name(word, known);
    return word + " is not an option" + (nearest.empty() ? help : "; did you mean " + nearest + "?");
  }
  // a missing option or argument, with what it is for
  if (dynamic_cast<const CLI::RequiredError*>(&error))
    for (const CLI::Option* option : command->get_options())
      if (option->get_required() && option->count() == 0)
        return option->get_name() + " is missing: " + option->get_description() + help;
  return error.what() + help;
}

/// Parses the command line, runs its command and returns the exit code.
int run(int argc, char** argv, AddCommands add_commands, void (*before)(int, char**)) {
  CLI::App program{
      "Turgor simulates soft bodies for surgery training and research: a patient's skin that is cut, organs\n"
      "under a finger or forceps, and cloth. Bodies come from a CT or a mesh."};
  program.name("turgor");
  program.footer(
      "Examples:\n"
      "  turgor run scenes/incision.toml --out out/incision\n"
      "  turgor info patient.nii.gz\n"
      "For help on a command: turgor COMMAND --help\n"
      "Exit codes: 0 success; 2 an error, explained by a message; 3 a simulation stopped early because it\n"
      "was not finite (earlier results are written), a condition of --require or a bound of validate is\n"
      "exceeded, or a replay has other bits; 130 interrupted: unfinished files are removed, and the message\n"
      "names complete ones.");
  program.set_version_flag("--version", "turgor " + program_version());
  program.set_help_all_flag("--help-all", "Print the help of all commands");
  Global global;
  program.add_option("--threads", global.threads, "Threads to use; 0 = one per core")
      ->check(CLI::Range(0, kMostThreads));
  program.fallthrough();
  add_commands(program, global);
  if (argc < 2) return print_text(program.help()), 0;
  if (const std::string message = unknown_command(program, argc, argv); !message.empty())
    return fail(message);
  try {
    if (before) before(argc, argv);
    program.parse(argc, argv);
    return 0;
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return program.exit(error);  // --help and --version
    return fail(problem_of(program, error, argc, argv));
  } catch (const Failure& failure) {
    fail(failure.message);
    return failure.exit_code;
  } catch (const std::system_error& error) {  // fmt::print
    return fail_to_print(error.code().value());
  } catch (const std::bad_alloc&) {
    return fail(input_of(program) + "not enough memory; a larger block or a smaller CT needs less");
  } catch (const std::exception& error) {
    return fail(error.what());
  }
}

}  // namespace

int run_program(int argc, char** argv, AddCommands add_commands, void (*before)(int, char**)) {
  constexpr const char* kDraws = "draw-meshes";  // the child process of a run that draws its pictures
  if (argc == 2 && std::string(argv[1]) == kDraws) return serve_drawings();
  hold_standard_streams();
  set_drawing_program({.arguments = {"/proc/self/exe", kDraws}});
  remove_unfinished_when_interrupted();
  return end_with(run(argc, argv, add_commands, before));
}

}  // namespace turgor
