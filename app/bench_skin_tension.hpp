// Table 4 of the skin tension paper beside figures of this engine, with the limits of this machine measured
// in the same run. [STC 5.4]
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/bench_growth.hpp"
#include "turgor/core/exec.hpp"
#include "turgor/core/progress.hpp"
#include "turgor/core/vec.hpp"

namespace turgor {

/// Times of one data set [ms], of the paper (RTX 3090) or of this engine, without and with the skin tension
/// constraint.
struct SkinTensionTimes {
  double grouping_without = 0, grouping_with = 0;
  double frame_without = 0, frame_with = 0;
};

/// Time of a frame [ms]: both orderings of a sweep, measured in alternation, and a GPU with resident state,
/// as a graph and kernel by kernel. 0 without a GPU.
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
  // A sweep without skin on all threads, relative to the copy bandwidth and to the rate of dense products
  // [1].
  double bandwidth_fraction = 0, arithmetic_fraction = 0;
  double vbd_bandwidth_fraction = 0, vbd_arithmetic_fraction = 0;
  double vbd_frame_one = 0, vbd_frame = 0;      // 5 sweeps with skin [ms]
  OrderingTimes pbd_frames, vbd_frames;         // with skin, all threads
  double residual_pbd = 0, residual_vbd = 0;    // rms after a frame [N]
  double resample_half = 0, resample_full = 0;  // to half and to full size [ms]
};

struct SkinTensionBench {
  int threads = 0;
  std::string gpu;                          // name of the GPU, or the reason why it cannot be used
  double copy_bandwidth = 0;                // all threads [B/s]
  double arithmetic_rate = 0;               // all threads, single precision [1/s]
  double bar_frame_one = 0, bar_frame = 0;  // 51 000 tetrahedra, springs and volumes, 5 sweeps [ms]
  int bar_tets = 0;
  std::vector<GrowthRow> growth;
  std::vector<SkinTensionRow> rows;
};

/// Runs phantoms of the paper's sizes divided by `shrink` (1 = full size). `only` = "A", "B" or "C".
SkinTensionBench bench_skin_tension(const Exec& exec, int shrink, const std::optional<std::string>& only,
                                    const Progress& progress);

}  // namespace turgor
