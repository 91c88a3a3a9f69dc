#include "mpi/run.hpp"

#include <bit>
#include <cmath>
#include <optional>

#include <fmt/format.h>
#include <sys/resource.h>

#include "mpi/displacement.hpp"
#include "mpi/exchange.hpp"
#include "mpi/load_subdomain.hpp"
#include "turgor/core/hash.hpp"
#include "turgor/core/timing.hpp"
#include "turgor/io/files/file.hpp"
#include "turgor/sim/output_folder.hpp"
#include "turgor/sim/report/report.hpp"

namespace turgor::mpi {

namespace fs = std::filesystem;

namespace {

/// Statistics of one process for the report.
struct ProcessStats {
  Share share;
  std::int64_t voxels_read = 0, memory = 0,
               peak = 0;                     // memory: model and state; peak: of the process [bytes]
  std::int64_t exchanged = 0, messages = 0;  // sent to neighbors by sweeps
  double load_seconds = 0, step_seconds = 0, exchange_seconds = 0;
  double work_seconds = 0;   // CPU time of steps without exchanges
  double least_seconds = 0;  // shortest exchange, see Traffic
};

/// A run in progress.
struct Running {
  const Exec& exec;
  const Ranks& ranks;
  const Scene& scene;
  LoadedSubdomain loaded;
  std::vector<Cut> cuts;
  lattice::StepReport last;
  int frames = 0;  // completed
  ProcessStats stats;
};

Status load_cuts(Running& run, const lattice::HaloExchange& halo) {
  for (const IncisionScene& incision : run.scene.incisions) {
    Cut cut;
    cut.body = incision.body, cut.blade = incision.blade;
    const auto trial = lattice::lay_blade(run.loaded.body.model, run.loaded.body.state, cut.blade, &halo);
    if (!trial) return Error{fmt::format("{}: {}", incision.source_location, trial.error().message)};
    run.cuts.push_back(std::move(cut));
  }
  return Done{};
}

/// One frame, as step(World&) does it.
Status step_frame(Running& run, const lattice::HaloExchange& halo, bool measure_residual) {
  LatticeBody& body = run.loaded.body;
  const double dt = 1 / run.scene.frame_rate, end = (run.frames + 1) * dt * (1 + 1e-12);
  for (std::size_t c = 0; c < run.cuts.size(); c++)
    if (const Status cut = advance_blade(run.exec, body, run.cuts, int(c), end, &halo); !cut) return cut;
  const double from = run.frames * dt, to = from + dt;
  const bool has_forces = body.model.params.solver.method == lattice::Method::kVbd;
  const lattice::Inputs inputs{.gravity = body.has_gravity ? run.scene.gravity : Vec3d{},
                               .measure_residual = measure_residual && has_forces,
                               .halo = &halo};
  run.last = lattice::step(run.exec, body.model, body.state.change(), inputs, to - from);
  run.frames++;
  return Done{};
}

Status simulate_subdomain(Running& run, Subdomain& subdomain) {
  const lattice::HaloExchange halo = halo_exchange_of(subdomain);
  if (const Status loaded = load_cuts(run, halo); !loaded) return loaded;
  const Timer timer;
  const double processor_before = processor_seconds();
  const int frames = frame_count(run.scene);
  while (run.frames < frames && run.last.finite)
    if (const Status done = step_frame(run, halo, run.frames + 1 == frames); !done) return done;
  run.stats.step_seconds = timer.seconds();
  run.stats.exchange_seconds = subdomain.traffic.seconds;
  run.stats.work_seconds = processor_seconds() - processor_before - subdomain.traffic.processor_seconds;
  run.stats.least_seconds = subdomain.traffic.least_seconds;
  run.stats.exchanged = subdomain.traffic.bytes, run.stats.messages = subdomain.traffic.messages;
  return Done{};
}

std::int64_t peak_memory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return std::int64_t(usage.ru_maxrss) * 1024;
}

/// Largest displacement of all nodes [m].
double largest_displacement(const Subdomain& subdomain) {
  const lattice::Model& model = subdomain.model;
  Real farthest = 0;
  for (int s = row_slot(model.anatomy.lattice, -1, model.anatomy.owned.begin);
       s < row_slot(model.anatomy.lattice, -1, model.anatomy.owned.end); s++)
    if (const auto n = std::size_t(s); lattice::is_solid(model, subdomain.state.cuts, s))
      farthest = std::max(farthest, dot(subdomain.state.motion.u[n], subdomain.state.motion.u[n]));
  return std::sqrt(double(std::bit_cast<Real>(largest(std::bit_cast<std::uint32_t>(farthest)))));
}

std::int64_t cut_edge_count(const Subdomain& subdomain) {
  const lattice::Model& model = subdomain.model;
  std::int64_t count = 0;
  for (int s = row_slot(model.anatomy.lattice, -1, model.anatomy.owned.begin);
       s < row_slot(model.anatomy.lattice, -1, model.anatomy.owned.end); s++)
    count += std::popcount(unsigned(subdomain.state.cuts.cut[std::size_t(s)] & ~lattice::kCutCell));
  return sum(count);
}

Json layers_json(Layers l) { return Json::array({l.begin, l.end}); }

Json report_of(const Running& run, const Subdomain& subdomain) {
  Json processes = Json::array();
  for (const ProcessStats& f : join(run.ranks, std::vector<ProcessStats>{run.stats}))
    processes.push_back({{"layers", layers_json(f.share.owned)},
                         {"layers_held", layers_json(f.share.held)},
                         {"voxels_read", f.voxels_read},
                         {"memory_bytes", f.memory},
                         {"peak_bytes", f.peak},
                         {"exchanged_bytes", f.exchanged},
                         {"messages", f.messages},
                         {"load_s", f.load_seconds},
                         {"steps_s", f.step_seconds},
                         {"steps_processor_s", f.work_seconds},
                         {"exchange_s", f.exchange_seconds},
                         {"shortest_exchange_s", f.least_seconds}});
  const Int3 size = run.loaded.nodes.size;
  return {{"program", "turgor_mpi " + program_version()},
          {"scene", run.scene.file.string()},
          {"frames", run.frames},
          {"finite", run.last.finite},
          {"state_hash", hash_text(state_hash(subdomain))},
          {"nodes", Json::array({size.x, size.y, size.z})},
          {"body_nodes", run.loaded.body_nodes},
          {"free_nodes", run.loaded.free_nodes},
          {"cut_edges", cut_edge_count(subdomain)},
          {"virtual_nodes", all_virtual_nodes(subdomain).size()},
          {"largest_displacement_mm", 1e3 * largest_displacement(subdomain)},
          {"largest_speed_mm_s", 1e3 * double(run.last.largest_speed)},
          {"residual_rms_N", run.last.residual.rms},
          {"residual_largest_N", run.last.residual.largest},
          {"processes", processes}};
}

/// Result folder. Rank 0 creates it; all ranks receive its path.
struct SharedFolder {
  std::optional<OutputFolder> folder;
  fs::path path;
};
Result<SharedFolder> create_folder(const Ranks& ranks, const fs::path& goal) {
  SharedFolder shared;
  Status owned = Done{};
  if (ranks.rank == 0) {
    Result<OutputFolder> created = OutputFolder::create(goal);
    if (created)
      shared.folder.emplace(std::move(*created));
    else
      owned = created.error();
  }
  if (const Status all = agree(ranks, owned); !all) return all.error();
  const std::string name = shared.folder ? shared.folder->path().string() : std::string();
  const std::vector<char> path_chars = join(ranks, std::vector<char>(name.begin(), name.end()));
  shared.path = std::string(path_chars.begin(), path_chars.end());
  return shared;
}

}  // namespace

Result<Json> run(const Exec& exec, const Ranks& ranks, const Scene& scene, const fs::path& out) {
  Result<SharedFolder> folder = create_folder(ranks, out);
  if (!folder) return folder.error();
  const Timer loading;
  Result<LoadedSubdomain> loaded =
      load_subdomain(exec, ranks, scene.lattice_bodies[0], !scene.incisions.empty());
  if (!loaded) return loaded.error();
  Running running{exec, ranks, scene, std::move(*loaded), {}, {}, 0, {}};
  LatticeBody& body = running.loaded.body;
  Subdomain subdomain{ranks, running.loaded.shares, body.model, body.state.watch(), {}};
  running.stats.share = subdomain.share();
  running.stats.voxels_read = running.loaded.voxels_read;
  running.stats.load_seconds = loading.seconds();
  if (const Status done = simulate_subdomain(running, subdomain); !done) return done.error();
  running.stats.memory = std::int64_t(lattice::memory_bytes(body.model, body.state));
  running.stats.peak = peak_memory();
  const Status written = write_displacement(subdomain, running.loaded.nodes, folder->path);
  if (const Status all = agree(ranks, written); !all) return all.error();
  const Json report = report_of(running, subdomain);
  Status committed = Done{};
  if (folder->folder) {
    committed = write_file(folder->path / kReportFile, json_text(report, 2) + "\n");
    if (committed) committed = folder->folder->commit();
  }
  if (const Status all = agree(ranks, committed); !all) return all.error();
  return report;
}

}  // namespace turgor::mpi
