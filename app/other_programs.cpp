#include "app/other_programs.hpp"

#include <cstring>
#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>

#include <unistd.h>

#include "app/commands.hpp"

namespace turgor {

namespace {

/// First word of a command line that is neither an option nor the number after --threads.
std::string_view command_of(int argc, char** argv) {
  for (int i = 1; i < argc; i++) {
    const std::string_view word = argv[i];
    if (word == "--threads") {
      i++;
    } else if (word.empty() || word[0] != '-') {
      return word;
    }
  }
  return {};
}

}  // namespace

void add_other_command(CLI::App& program, const OtherProgram& other) {
  CLI::App* command = program.add_subcommand(other.command, other.about);
  command->footer("For its options: turgor " + std::string(other.command) + " --help");
  command->callback([other] {
    throw Failure{2, std::string(other.command) + ": expected as first command"};
  });
}

void start_other_program(int argc, char** argv) {
  const std::string_view word = command_of(argc, argv);
  for (const OtherProgram& other : {kView, kBench, kValidate}) {
    if (word != other.command) continue;
    std::error_code failed;
    const auto file = std::filesystem::read_symlink("/proc/self/exe", failed).parent_path() / other.file;
    execv(file.c_str(), argv);  // returns only after an error
    const std::string reason =
        errno == ENOENT ? "is not built; build it by: scripts/build release " + std::string(other.target)
                        : "cannot be started: " + std::string(std::strerror(errno));
    throw Failure{2, std::string(word) + ": " + file.string() + " " + reason};
  }
}

}  // namespace turgor
