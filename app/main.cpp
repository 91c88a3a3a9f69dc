// The program `turgor`.
#include "app/commands.hpp"
#include "app/other_programs.hpp"
#include "app/program.hpp"

namespace {

void add_commands(CLI::App& program, turgor::Global& global) {
  turgor::add_run_command(program, global);
  turgor::add_replay_command(program, global);
  turgor::add_other_command(program, turgor::kView);
  turgor::add_info_command(program, global);
  turgor::add_import_command(program, global);
  turgor::add_phantom_command(program, global);
  turgor::add_mesh_command(program, global);
  turgor::add_other_command(program, turgor::kBench);
  turgor::add_other_command(program, turgor::kValidate);
  turgor::add_calibrate_command(program, global);
  turgor::add_identify_command(program, global);
  turgor::add_plan_excision_command(program, global);
  turgor::add_cache_command(program);
  turgor::add_devices_command(program);
  turgor::add_tissues_command(program);
}

}  // namespace

int main(int argc, char** argv) {
  return turgor::run_program(argc, argv, add_commands, turgor::start_other_program);
}
