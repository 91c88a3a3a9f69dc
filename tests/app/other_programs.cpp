// Commands that programs beside `turgor` run.
#include "tests/app/program.hpp"

namespace turgor {
namespace {

using namespace test;

/// Runs a copy of the program that has no others beside it.
Ended run_alone(const std::string& arguments) {
  const fs::path folder = fresh_folder();
  fs::copy_file(TURGOR_PROGRAM, folder / "turgor");
  return run_shell("./turgor " + arguments, folder);
}

// All three commands start their program with every argument, also after the option --threads.
TEST(OtherPrograms, CommandsReachThem) {
  const fs::path folder = fresh_folder();
  for (const char* command : {"view", "bench", "validate"})
    for (const char* before : {"", "--threads 2 ", "--threads=2 "}) {
      const Ended ended = run_program(std::string(before) + command + " --help", folder);
      EXPECT_EQ(ended.code, 0) << ended.printed;
      EXPECT_NE(ended.printed.find("Usage: turgor " + std::string(command)), std::string::npos)
          << ended.printed;
    }
  EXPECT_EQ(run_program("validate lattice --quikc", folder).code, 2);
}

// Without its program, a command says which target builds it; others run, and the help lists all.
TEST(OtherPrograms, MissingOneIsNamed) {
  const Ended ended = run_alone("validate lattice --quick");
  EXPECT_EQ(ended.code, 2);
  EXPECT_NE(ended.printed.find(
                "turgor-bench is not built; build it by: scripts/build release turgor_bench_program"),
            std::string::npos)
      << ended.printed;
  EXPECT_EQ(run_alone("tissues").code, 0);
  const std::string help = run_alone("--help").printed;
  for (const char* command : {"view", "bench", "validate", "run", "info"})
    EXPECT_NE(help.find(std::string("\n  ") + command + " "), std::string::npos) << help;
}

}  // namespace
}  // namespace turgor
