// The program `turgor-bench`, which `turgor bench` and `turgor validate` start.
#include "app/commands.hpp"
#include "app/program.hpp"

namespace {

void add_commands(CLI::App& program, turgor::Global& global) {
  turgor::add_bench_command(program, global);
  turgor::add_validate_command(program, global);
}

}  // namespace

int main(int argc, char** argv) { return turgor::run_program(argc, argv, add_commands); }
