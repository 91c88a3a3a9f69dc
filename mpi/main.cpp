// The program `turgor_mpi`: one body in several processes started by mpirun (docs/distributed-bodies.md).
// Exit codes are those of `turgor`. After an error, the message of the lowest failing rank is printed.
#include <cstdio>
#include <exception>
#include <filesystem>
#include <new>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "app/commands.hpp"
#include "app/print.hpp"
#include "mpi/run.hpp"
#include "mpi/scene.hpp"
#include "turgor/core/thread_limit.hpp"
#include "turgor/sim/report/report.hpp"

namespace {

using turgor::Error, turgor::Json, turgor::Result;
using namespace turgor::mpi;

struct Options {
  std::filesystem::path scene, out;
  std::vector<std::string> overrides;
  int threads = 1;
  bool quiet = false;
};

int fail(const Ranks& ranks, const std::string& message) {
  if (ranks.rank == 0) turgor::print_message("turgor_mpi", message);
  return 2;
}

void print_summary(const Json& report, const std::filesystem::path& out) {
  turgor::print_plain("{}: {} frames, {} processes, state_hash {}\n", out.string(),
                      report["frames"].get<int>(), report["processes"].size(),
                      report["state_hash"].get<std::string>());
  for (const Json& p : report["processes"])
    turgor::print_plain("  layers {:>4} to {:>4}: {:.0f} MB, {:.2f} s, of which exchange {:.2f} s\n",
                        p["layers"][0].get<int>(), p["layers"][1].get<int>(),
                        p["memory_bytes"].get<double>() / 1e6, p["steps_s"].get<double>(),
                        p["exchange_s"].get<double>());
}

/// Runs the simulation and returns the exit code.
int simulate(const Ranks& ranks, const Options& options) {
  const Result<turgor::Scene> scene = turgor::read_scene(options.scene, options.overrides);
  turgor::Status known = scene ? check_scene(*scene) : turgor::Status(scene.error());
  if (known = agree(ranks, known); !known) return fail(ranks, known.error().message);
  const std::filesystem::path out =
      options.out.empty() ? std::filesystem::path("out") / options.scene.stem() : options.out;
  const Result<Json> report = run(turgor::Exec(options.threads), ranks, *scene, out);
  if (!report) return fail(ranks, report.error().message);
  if (!options.quiet && ranks.rank == 0) print_summary(*report, out);
  if (report->at("finite").get<bool>()) return 0;
  fail(ranks, fmt::format("{}: stopped after {} frames: the next step was not finite", options.scene.string(),
                          report->at("frames").get<int>()));
  return turgor::kNotFinite;
}

int command_line(const Ranks& ranks, int argc, char** argv) {
  CLI::App program{"Turgor: one body in several processes; each process owns some of its layers."};
  program.name("turgor_mpi");
  program.footer(
      "Example:\n  mpirun -n 4 turgor_mpi run huge.toml --out out/huge\n"
      "Supported scenes: docs/distributed-bodies.md.");
  program.set_version_flag("--version", "turgor_mpi " + turgor::program_version());
  program.require_subcommand(1);
  Options options;
  CLI::App* command = program.add_subcommand("run", "Simulate a scene; writes displacements and a report");
  command->add_option("scene", options.scene, "The scene, a TOML file: a lattice and incisions")->required();
  command->add_option("-o,--out", options.out, "Folder for the results (default: out/SCENE)");
  turgor::add_set_option(*command, options.overrides);
  command->add_option("--threads", options.threads, "Threads of each process (default: 1); 0 = one per core")
      ->check(CLI::Range(0, turgor::kMostThreads));
  command->add_flag("-q,--quiet", options.quiet, "Print nothing on success");
  try {
    program.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return ranks.rank == 0 ? program.exit(error) : 0;
    return fail(ranks, std::string(error.what()) + "; see turgor_mpi --help");
  }
  return simulate(ranks, options);
}

}  // namespace

int main(int argc, char** argv) {
  const Ranks ranks(argc, argv);
  try {
    return command_line(ranks, argc, argv);
  } catch (const std::bad_alloc&) {
    std::fprintf(stderr, "turgor_mpi: rank %d: not enough memory; with more processes each needs less\n",
                 ranks.rank);
  } catch (const std::exception& error) {
    turgor::print_message(fmt::format("turgor_mpi: rank {}", ranks.rank), error.what());
  }
  end_all(2);
}
