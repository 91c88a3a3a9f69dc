// What a frame of cloth costs on this machine, with other engines' figures beside: frames over sizes, the
// sweeps' share of the memory's bandwidth, and three solvers' way to the same residual.
#pragma once

#include <string>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/core/progress.hpp"

namespace turgor {

/// A flag in gusts, 8 sweeps a frame.
struct ClothFrameRow {
  int vertices = 0;
  double alone_one = 0, alone = 0;     // without self-collision, on one thread and on all [ms]
  double self_one = 0, self = 0;       // with it [ms]
  double gpu_alone = 0, gpu_self = 0;  // the same on a GPU, where the state stays; 0 = there is none [ms]
  double contacts_per_vertex = 0, bytes_per_vertex = 0;
  double sweep = 0;               // on all threads [ms]
  double bandwidth_fraction = 0;  // of copying, of what a sweep must move at least [1]
};

/// A sheet that has fallen over a ball onto a table: many contacts.
struct ClothDrapeRow {
  int vertices = 0;
  double one = 0, all = 0;  // [ms]
  double contacts_per_vertex = 0;
  double smallest_distance = 0;  // of layers, over the thickness [1]
};

/// The linear system of one frame of a flag until the residual is below a tenth of its right-hand side.
struct ClothSolverRow {
  std::string method;
  int sweeps = 0;  // or iterations; 0 = more than were tried
  double ms = 0;   // on all threads
  double residual = 0;
};

struct ClothBench {
  int threads = 0;
  double copy_bandwidth = 0;  // all threads [B/s]
  std::string gpu;            // its name, or why there is none
  std::vector<ClothFrameRow> frames;
  ClothDrapeRow drape;
  std::vector<ClothSolverRow> solvers;
};

/// Squares of 2500 to 1 000 000 vertices, those up to `largest`.
ClothBench bench_cloth(const Exec& exec, int largest, const Progress& progress);

/// The tables, with other engines' figures beside.
void print(const ClothBench& bench);
std::string to_json_text(const ClothBench& bench);

}  // namespace turgor
