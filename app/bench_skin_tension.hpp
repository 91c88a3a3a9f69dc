// The paper's Table 4 beside ours, with the limits of this machine measured in the same run. [STC 5.4]
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/bench_growth.hpp"
#include "turgor/core/exec.hpp"
#include "turgor/core/progress.hpp"
#include "turgor/core/vec.hpp"

namespace turgor {

/// Milliseconds of one data set, paper (RTX 3090) or ours, without and with the skin tension constraint.
struct SkinTensionTimes {
  double grouping_without = 0, grouping_with = 0;
  double frame_without = 0, frame_with = 0;
};

/// Frames of one body by both orders of a sweep, in turns, and on a GPU, where the state stays, as a graph
/// and kernel by kernel; 0: there is none [ms].
struct OrderingTimes {
  double slabs = 0, colors = 0, gpu = 0, gpu_one_by_one = 0;
};

struct SkinTensionRow {
  std::string name;
  Int3 voxels, nodes;
  std::size_t skin_triangles = 0;
  SkinTensionTimes paper, one_thread, all_threads;
  double body_seconds = 0;  // from the CT in memory
  double bytes_per_node = 0;
  // Of a sweep without skin, on all threads: of what copying and dense products reach.
  double bandwidth_fraction = 0, arithmetic_fraction = 0;
  double descent_bandwidth_fraction = 0, descent_arithmetic_fraction = 0;
  double descent_frame_one = 0, vbd_frame = 0;    // 5 sweeps with skin [ms]
  OrderingTimes pbd_frames, descent_frames;       // with skin, all threads
  double residual_pbd = 0, residual_descent = 0;  // rms after a frame [N]
  double resample_half = 0, resample_full = 0;    // to half and to full size [ms]
};

struct SkinTensionBench {
  int threads = 0;
  std::string gpu;                          // its name, or why there is none
  double copy_bandwidth = 0;                // all threads [B/s]
  double arithmetic_rate = 0;               // all threads, single precision [1/s]
  double bar_frame_one = 0, bar_frame = 0;  // 51 000 tetrahedra, springs and volumes, 5 sweeps [ms]
  int bar_tets = 0;
  std::vector<GrowthRow> growth;
  std::vector<SkinTensionRow> rows;
};

/// Runs it on phantoms of the paper's sizes divided by `shrink` (1 = the paper's own). `only` = "A", "B" or
/// "C".
SkinTensionBench bench_skin_tension(const Exec& exec, int shrink, const std::optional<std::string>& only,
                                    const Progress& progress);

}  // namespace turgor
