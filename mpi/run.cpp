#include "mpi/run.hpp"

#include <bit>
#include <cmath>
#include <optional>

#include <fmt/format.h>
#include <sys/resource.h>

#include "mpi/displacement.hpp"
#include "mpi/exchange.hpp"
#include "mpi/load_part.hpp"
#include "turgor/core/hash.hpp"
#include "turgor/core/timing.hpp"
#include "turgor/io/files/file.hpp"
#include "turgor/sim/output_folder.hpp"
#include "turgor/sim/report/report.hpp"

namespace turgor::mpi {

namespace fs = std::filesystem;

namespace {

/// What one process has to say about its part.
struct PartFacts {
  Share share;
  std::int64_t voxels_read = 0, memory = 0,
               peak = 0;                     // memory: model and state; peak: of the process [bytes]
  std::int64_t exchanged = 0, messages = 0;  // sent to neighbours by sweeps
  double load_seconds = 0, step_seconds = 0, exchange_seconds = 0;
  double work_seconds = 0;   // of the processor, in steps, without telling neighbours
  double least_seconds = 0;  // Traffic
};

/// A run on its way.
struct Running {
  const Exec& exec;
  const Ranks& ranks;
  const Scene& scene;
  LoadedPart part;
  std::vector<Cut> cuts;
  lattice::StepReport last;
  int frames = 0;  // finished
  PartFacts facts;
};

Status load_cuts(Running& run, const lattice::HaloExchange& halo) {
  for (const IncisionScene& incision : run.scene.incisions) {
    Cut cut;
    cut.body = incision.body, cut.blade = incision.blade;
    const auto trial = lattice::lay_blade(run.part.body.model, run.part.body.state, cut.blade, &halo);
    if (!trial) return Error{fmt::format("{}: {}", incision.place, trial.error().message)};
    run.cuts.push_back(std::move(cut));
  }
  return Done{};
}

/// As step(World&) does.
Status step_frame(Running& run, const lattice::HaloExchange& halo, bool measure_residual) {
  LatticeBody& body = run.part.body;
  const double dt = 1 / run.scene.frame_rate, end = (run.frames + 1) * dt * (1 + 1e-12);
  for (std::size_t c = 0; c < run.cuts.size(); c++)
    if (const Status cut = advance_blade(body, run.cuts, int(c), end, &halo); !cut) return cut;
  const double from = run.frames * dt, to = from + dt;
  const bool has_forces = body.model.params.solver.method == lattice::Method::kVbd;
  const lattice::Inputs inputs{.gravity = body.has_gravity ? run.scene.gravity : Vec3d{},
                               .measure_residual = measure_residual && has_forces,
                               .halo = &halo};
  run.last = lattice::step(run.exec, body.model, body.state.change(), inputs, to - from);
  run.frames++;
  return Done{};
}

Status simulate_part(Running& run, PartOfBody& part) {
  const lattice::HaloExchange halo = others_of(part);
  if (const Status loaded = load_cuts(run, halo); !loaded) return loaded;
  const Timer timer;
  const double processor_before = processor_seconds();
  const int frames = frame_count(run.scene);
  while (run.frames < frames && run.last.finite)
    if (const Status done = step_frame(run, halo, run.frames + 1 == frames); !done) return done;
  run.facts.step_seconds = timer.seconds();
  run.facts.exchange_seconds = part.traffic.seconds;
  run.facts.work_seconds = processor_seconds() - processor_before - part.traffic.processor_seconds;
  run.facts.least_seconds = part.traffic.least_seconds;
  run.facts.exchanged = part.traffic.bytes, run.facts.messages = part.traffic.messages;
  return Done{};
}

std::int64_t peak_memory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return std::int64_t(usage.ru_maxrss) * 1024;
}

/// Of own nodes [m].
double largest_displacement(const PartOfBody& part) {
  const lattice::Model& model = part.model;
  Real farthest = 0;
  for (int s = row_slot(model.lattice, -1, model.owned.begin);
       s < row_slot(model.lattice, -1, model.owned.end); s++)
    if (const auto n = std::size_t(s); lattice::is_solid(model, part.state, s))
      farthest = std::max(farthest, dot(part.state.u[n], part.state.u[n]));
  return std::sqrt(double(std::bit_cast<Real>(largest(std::bit_cast<std::uint32_t>(farthest)))));
}

std::int64_t cut_edge_count(const PartOfBody& part) {
  const lattice::Model& model = part.model;
  std::int64_t count = 0;
  for (int s = row_slot(model.lattice, -1, model.owned.begin);
       s < row_slot(model.lattice, -1, model.owned.end); s++)
    count += std::popcount(unsigned(part.state.cut[std::size_t(s)] & ~lattice::kIsCut));
  return sum(count);
}

Json layers_json(Layers l) { return Json::array({l.begin, l.end}); }

Json report_of(const Running& run, const PartOfBody& part) {
  Json processes = Json::array();
  for (const PartFacts& f : join(run.ranks, std::vector<PartFacts>{run.facts}))
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
  const Int3 size = run.part.nodes.size;
  return {{"program", "turgor_mpi " + program_version()},
          {"scene", run.scene.file.string()},
          {"frames", run.frames},
          {"finite", run.last.finite},
          {"state_hash", hash_text(state_hash(part))},
          {"nodes", Json::array({size.x, size.y, size.z})},
          {"body_nodes", run.part.body_nodes},
          {"free_nodes", run.part.free_nodes},
          {"cut_edges", cut_edge_count(part)},
          {"copies", all_copies(part).size()},
          {"largest_displacement_mm", 1e3 * largest_displacement(part)},
          {"largest_speed_mm_s", 1e3 * double(run.last.largest_speed)},
          {"residual_rms_N", run.last.residual.rms},
          {"residual_largest_N", run.last.residual.largest},
          {"processes", processes}};
}

/// The folder is rank 0's; where to write is told to all.
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
  const std::vector<char> told = join(ranks, std::vector<char>(name.begin(), name.end()));
  shared.path = std::string(told.begin(), told.end());
  return shared;
}

}  // namespace

Result<Json> run(const Exec& exec, const Ranks& ranks, const Scene& scene, const fs::path& out) {
  Result<SharedFolder> folder = create_folder(ranks, out);
  if (!folder) return folder.error();
  const Timer loading;
  Result<LoadedPart> loaded = load_part(exec, ranks, scene.lattice_bodies[0], !scene.incisions.empty());
  if (!loaded) return loaded.error();
  Running running{exec, ranks, scene, std::move(*loaded), {}, {}, 0, {}};
  LatticeBody& body = running.part.body;
  PartOfBody part{ranks, running.part.shares, body.model, body.state.watch(), {}};
  running.facts.share = part.share();
  running.facts.voxels_read = running.part.voxels_read;
  running.facts.load_seconds = loading.seconds();
  if (const Status done = simulate_part(running, part); !done) return done.error();
  running.facts.memory = std::int64_t(lattice::memory_bytes(body.model, body.state));
  running.facts.peak = peak_memory();
  const Status written = write_displacement(part, running.part.nodes, folder->path);
  if (const Status all = agree(ranks, written); !all) return all.error();
  const Json report = report_of(running, part);
  Status committed = Done{};
  if (folder->folder) {
    committed = write_file(folder->path / kReportFile, report.dump(2) + "\n");
    if (committed) committed = folder->folder->commit();
  }
  if (const Status all = agree(ranks, committed); !all) return all.error();
  return report;
}

}  // namespace turgor::mpi
