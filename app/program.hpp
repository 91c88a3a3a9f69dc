// A program of the command line: parses it, runs a command, and turns a failure into a sentence and an exit
// code. 2: unexpected command line or scene. 3: non-finite numbers ended a simulation early. 130:
// interrupted. 141, without a sentence: the reader of standard output closed the pipe.
#pragma once

#include "app/commands.hpp"

namespace turgor {

/// Adds commands to a program. `global` must outlive the parsing.
using AddCommands = void (*)(CLI::App& program, Global& global);

/// The main function of a program with these commands; returns its exit code. `before`, which may be null, is
/// called with the command line before it is parsed, and may throw Failure.
int run_program(int argc, char** argv, AddCommands add_commands, void (*before)(int, char**) = nullptr);

}  // namespace turgor
