// Cost of touches on a body of the sfem model on this machine. Measures Green's functions over sizes, a
// haptic tick over contact points, a patch over its refinement, and the whole surface. The limits of the
// machine are measured in the same run.
#pragma once

#include <string>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/core/progress.hpp"

namespace turgor {

/// All Green's functions of a block of tetrahedra, from its mesh.
struct PrecomputeRow {
  int nodes = 0;  // free nodes
  double seconds = 0;
  double factor_bytes = 0, store_bytes = 0;
  double flops_fraction = 0;  // operations a second, relative to a dense product on all threads [1]
};
/// A fingertip that slides over a patch, on one thread.
struct TickRow {
  int contacts = 0;                      // points with a contact force, median
  int points = 0;                        // surface points of the patch
  double p50 = 0, p99 = 0, largest = 0;  // [s]
};
/// The paper's plate of 4×4×1 hexahedra with its central 2×2 superposed, on one thread.
struct PatchRow {
  int refinement = 0, local_nodes = 0, points = 0;
  double seconds = 0;
};
/// Displacement of a whole surface, as for a picture.
struct SurfaceRow {
  int vertices = 0;
  double seconds = 0;
  double bandwidth_fraction = 0;  // relative to a plain matrix–vector product of the same size [1]
};

struct SfemBench {
  int threads = 0;
  double dense_flops = 0;     // of a dense product on one thread [1/s]
  double gemv_bandwidth = 0;  // of a matrix–vector product on one thread [B/s]
  std::vector<PrecomputeRow> precompute;
  std::vector<TickRow> ticks;
  std::vector<PatchRow> patches;
  SurfaceRow surface;
};

/// Runs blocks of about 1000, 3000 and 10 000 nodes, except those larger than `largest`.
SfemBench bench_sfem(const Exec& exec, int largest, const Progress& progress);

/// Prints the tables, with the figures of other engines beside them.
void print(const SfemBench& bench);
std::string to_json_text(const SfemBench& bench);

}  // namespace turgor
