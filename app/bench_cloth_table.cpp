#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/bench_cloth.hpp"
#include "app/print.hpp"

namespace turgor {

namespace {

using nlohmann::ordered_json;

void print_frames(const ClothBench& bench) {
  print_plain(
      "A flag in gusts, springs along and across edges, 8 sweeps, medians [ms]; 1 and {} threads, copies "
      "{:.1f} GB/s.\n\n{:>9} {:>19} {:>22} {:>10} {:>9} {:>9} {:>9} {:>11}\n",
      bench.threads, bench.copy_bandwidth * 1e-9, "vertices", "no self-collision", "with self-collision",
      "ns/vertex", "contacts", "B/vertex", "sweep", "vs copy");
  for (const ClothFrameRow& r : bench.frames)
    print_plain("{:>9} {:>19} {:>22} {:>10.0f} {:>9.2f} {:>9.0f} {:>9.3f} {:>11.2f}\n", r.vertices,
                fmt::format("{:.2f} / {:.2f}", r.single_one, r.alone),
                fmt::format("{:.2f} / {:.2f}", r.self_one, r.self), r.self * 1e6 / r.vertices,
                r.contacts_per_vertex, r.bytes_per_vertex, r.sweep, r.bandwidth_fraction);
  print_plain("\nGPU: {}\n", bench.gpu);
  for (const ClothFrameRow& r : bench.frames)
    if (r.gpu_alone > 0) print_plain("{:>9} {:>19.3f} {:>22.3f}\n", r.vertices, r.gpu_alone, r.gpu_self);
  print_plain(
      "\nOther engines on 2 cores of an EPYC (Zen 4), 2025, one step with 5 iterations; the work is not the "
      "same:\n"
      "  Jolt 5.5, edges + shear, no self-collision      10 000: 1.64 / 1.10    90 000: 15.3 / 10.2\n"
      "  Jolt, with dihedral bending                      10 000:  6.2 / 3.8     90 000: 62 / 36–59\n"
      "  Bullet 3.25, crumpled, with self-collision       10 000: 24–39\n"
      "  MuJoCo 3.12, self-colliding drape                 2 500: 23.6\n"
      "  SOFA, springs, implicit, CG 25                   10 000: 16.2           90 000: 181\n"
      "On another machine with 2 cores of an EPYC, November 2026, a frame without / with self-collision:\n"
      "  Newton 1.8, VBD on the CPU                       10 000: 89 / 168\n"
      "  MuJoCo 4.0, flex, 4.2 steps of 4 ms              10 000: 18 / 83\n"
      "  Bullet 3.25, deformable world                    10 000: 525 / -\n"
      "Published: OGC 2025, 50 layers on a CPU            246 000: 210 on average, 550 at most\n"
      "benches/peers/run measures these engines and Turgor in one run.\n");
}

}  // namespace

void print(const ClothBench& bench) {
  print_frames(bench);
  print_plain(
      "\nA sheet of {} vertices over a ball on a table: {:.2f} / {:.2f} ms, {:.2f} contacts a vertex; "
      "distance of layers "
      "at "
      "least {:.3f} thicknesses.\n\nUntil |b - W dv| is a tenth of |b| (10 000 vertices):\n",
      bench.drape.vertices, bench.drape.one, bench.drape.all, bench.drape.contacts_per_vertex,
      bench.drape.smallest_distance);
  for (const ClothSolverRow& r : bench.solvers)
    print_plain("  {:<20} {:>6} sweeps {:>9.2f} ms   residual {:.4f}\n", r.method,
                r.sweeps > 0 ? std::to_string(r.sweeps) : "> 8192", r.ms, r.residual);
}

std::string to_json_text(const ClothBench& bench) {
  ordered_json frames = ordered_json::array(), solvers = ordered_json::array();
  for (const ClothFrameRow& r : bench.frames)
    frames.push_back({{"vertices", r.vertices},
                      {"alone_one_thread_ms", r.single_one},
                      {"alone_ms", r.alone},
                      {"self_collision_one_thread_ms", r.self_one},
                      {"self_collision_ms", r.self},
                      {"gpu_alone_ms", r.gpu_alone > 0 ? ordered_json(r.gpu_alone) : ordered_json()},
                      {"gpu_self_collision_ms", r.gpu_self > 0 ? ordered_json(r.gpu_self) : ordered_json()},
                      {"contacts_per_vertex", r.contacts_per_vertex},
                      {"bytes_per_vertex", r.bytes_per_vertex},
                      {"sweep_ms", r.sweep},
                      {"sweep_fraction_of_copy_bandwidth", r.bandwidth_fraction}});
  for (const ClothSolverRow& r : bench.solvers)
    solvers.push_back({{"method", r.method}, {"sweeps", r.sweeps}, {"ms", r.ms}, {"residual", r.residual}});
  const ClothDrapeRow& drape = bench.drape;
  return ordered_json({{"bench", "cloth"},
                       {"threads", bench.threads},
                       {"copy_bandwidth_gb_per_s", bench.copy_bandwidth * 1e-9},
                       {"gpu", bench.gpu},
                       {"frames", frames},
                       {"drape",
                        {{"vertices", drape.vertices},
                         {"one_thread_ms", drape.one},
                         {"ms", drape.all},
                         {"contacts_per_vertex", drape.contacts_per_vertex},
                         {"smallest_distance_in_thicknesses", drape.smallest_distance}}},
                       {"solvers", solvers}})
             .dump(2) +
         "\n";
}

}  // namespace turgor
