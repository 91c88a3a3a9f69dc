// Cost of a frame of cloth on this machine, beside the figures of other engines. Measures frames over sizes,
// the fraction of the memory bandwidth that sweeps reach, and the time of three solvers to the same residual.
#pragma once

#include <string>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/core/progress.hpp"

namespace turgor {

/// A flag in gusts, 8 sweeps a frame.
struct ClothFrameRow {
  int vertices = 0;
  double single_one = 0, alone = 0;    // without self-collision, on one thread and on all [ms]
  double self_one = 0, self = 0;       // with self-collision [ms]
  double gpu_alone = 0, gpu_self = 0;  // the same with the state resident on the GPU; 0 without a GPU [ms]
  double contacts_per_vertex = 0, bytes_per_vertex = 0;
  double sweep = 0;               // one sweep on all threads [ms]
  double bandwidth_fraction = 0;  // least memory traffic of a sweep, relative to the copy bandwidth [1]
};

/// A sheet that has fallen over a ball onto a table: many contacts.
struct ClothDrapeRow {
  int vertices = 0;
  double one = 0, all = 0;  // [ms]
  double contacts_per_vertex = 0;
  double smallest_distance = 0;  // smallest distance of layers, relative to the thickness [1]
};

/// Solution of the linear system of one frame of a flag, until the residual is below a tenth of the
/// right-hand side.
struct ClothSolverRow {
  std::string method;
  int sweeps = 0;  // or iterations; 0 = more than the limit
  double ms = 0;   // on all threads
  double residual = 0;
};

struct ClothBench {
  int threads = 0;
  double copy_bandwidth = 0;  // all threads [B/s]
  std::string gpu;            // name of the GPU, or the reason why it cannot be used
  std::vector<ClothFrameRow> frames;
  ClothDrapeRow drape;
  std::vector<ClothSolverRow> solvers;
};

/// Runs squares of 2500 to 1 000 000 vertices, except those larger than `largest`.
ClothBench bench_cloth(const Exec& exec, int largest, const Progress& progress);

/// Prints the tables, with the figures of other engines beside them.
void print(const ClothBench& bench);
std::string to_json_text(const ClothBench& bench);

}  // namespace turgor
