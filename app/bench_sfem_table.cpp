#include <nlohmann/json.hpp>

#include "app/bench_sfem.hpp"
#include "app/print.hpp"

namespace turgor {

namespace {

using nlohmann::ordered_json;

constexpr double kMicro = 1e6, kMilli = 1e3, kMega = 1e-6;

}  // namespace

void print(const SfemBench& bench) {
  print_plain(
      "A body under a fingertip, medians. {} threads for Green's functions and the surface, one for ticks "
      "and "
      "patches.\nOne thread: dense product {:.1f} Gflop/s, matrix-vector product {:.1f} "
      "GB/s.\n",
      bench.threads, bench.dense_flops * 1e-9, bench.gemv_bandwidth * 1e-9);
  print_plain("\n{:>8}{:>14}{:>12}{:>12}{:>22}\n", "nodes", "Green's [s]", "factor[MB]", "store[MB]",
              "vs dense product");
  for (const PrecomputeRow& r : bench.precompute)
    print_plain("{:>8}{:>14.2f}{:>12.0f}{:>12.0f}{:>22.2f}\n", r.nodes, r.seconds, r.factor_bytes * kMega,
                r.store_bytes * kMega, r.flops_fraction);
  print_plain("{:>8}{:>14.2f}   SOFA's precomputed compliance, 2 cores of an EPYC (Zen 4), 2025\n", 1024,
              32.0);
  print_plain("\n{:>10}{:>10}{:>12}{:>12}{:>12}\n", "contacts", "points", "tick[us]", "99 %[us]", "max[us]");
  for (const TickRow& r : bench.ticks)
    print_plain("{:>10}{:>10}{:>12.1f}{:>12.1f}{:>12.1f}\n", r.contacts, r.points, r.p50 * kMicro,
                r.p99 * kMicro, r.largest * kMicro);
  print_plain("{:>10}{:>10}{:>12.0f}   SOFA's precomputed compliance at 60 rows, the same machine as above\n",
              20, "-", 4900.0);
  print_plain("\n{:>12}{:>14}{:>10}{:>14}   the paper's plate, 2x2 elements superposed\n", "refinement",
              "local nodes", "points", "patch[ms]");
  for (const PatchRow& r : bench.patches)
    print_plain("{:>12}{:>14}{:>10}{:>14.3f}\n", r.refinement, r.local_nodes, r.points, r.seconds * kMilli);
  print_plain("\nThe surface of {} vertices: {:.2f} ms, {:.2f} of a matrix-vector product of that size.\n",
              bench.surface.vertices, bench.surface.seconds * kMilli, bench.surface.bandwidth_fraction);
}

std::string to_json_text(const SfemBench& bench) {
  ordered_json precompute = ordered_json::array(), ticks = precompute, patches = precompute;
  for (const PrecomputeRow& r : bench.precompute)
    precompute.push_back({{"nodes", r.nodes},
                          {"seconds", r.seconds},
                          {"factor_bytes", r.factor_bytes},
                          {"store_bytes", r.store_bytes},
                          {"fraction_of_dense_product", r.flops_fraction}});
  for (const TickRow& r : bench.ticks)
    ticks.push_back({{"contacts", r.contacts},
                     {"points", r.points},
                     {"p50_us", r.p50 * kMicro},
                     {"p99_us", r.p99 * kMicro},
                     {"max_us", r.largest * kMicro}});
  for (const PatchRow& r : bench.patches)
    patches.push_back({{"refinement", r.refinement},
                       {"local_nodes", r.local_nodes},
                       {"points", r.points},
                       {"ms", r.seconds * kMilli}});
  const ordered_json json{{"bench", "sfem"},
                          {"threads", bench.threads},
                          {"dense_flops_per_s", bench.dense_flops},
                          {"gemv_bytes_per_s", bench.gemv_bandwidth},
                          {"precompute", precompute},
                          {"ticks", ticks},
                          {"patches", patches},
                          {"surface",
                           {{"vertices", bench.surface.vertices},
                            {"ms", bench.surface.seconds * kMilli},
                            {"fraction_of_gemv", bench.surface.bandwidth_fraction}}}};
  return json.dump(2) + "\n";
}

}  // namespace turgor
