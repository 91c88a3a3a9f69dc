// Commands that programs beside `turgor` run: turgor-view opens the window, turgor-bench measures and
// validates. They are targets of their own, because they would take a third of a build of `turgor`.
#pragma once

#include <CLI/CLI.hpp>

namespace turgor {

struct OtherProgram {
  const char* command;
  const char* about;  // for turgor --help
  const char* file;   // beside this program
  const char* target;
};

inline constexpr OtherProgram kView{"view", "Simulate a scene in a window: view, press, cut and edit it",
                                    "turgor-view", "turgor_view_program"};
inline constexpr OtherProgram kBench{"bench", "Benchmark this machine, beside the tables of the papers",
                                     "turgor-bench", "turgor_bench_program"};
inline constexpr OtherProgram kValidate{"validate", "Validate a model against known answers", "turgor-bench",
                                        "turgor_bench_program"};

/// Lists the command in the help of `program`. Parsing it throws Failure.
void add_other_command(CLI::App& program, const OtherProgram& other);

/// Replaces this process by the program that runs the command of this command line, with the same arguments.
/// Returns if `turgor` runs the command itself. Throws Failure if the program is not built.
void start_other_program(int argc, char** argv);

}  // namespace turgor
