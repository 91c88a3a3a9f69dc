// One body in several processes from the first frame to the last, and what is left of it: displacements at
// the nodes and a report.
#pragma once

#include <filesystem>

#include "mpi/ranks.hpp"
#include "turgor/core/exec.hpp"
#include "turgor/sim/report/json_numbers.hpp"
#include "turgor/sim/scene/scene.hpp"

namespace turgor::mpi {

/// Into a folder that appears when it is complete: report.json and displacement.mhd with its samples beside
/// it. Returns the report. Error: the same on all ranks.
Result<Json> run(const Exec& exec, const Ranks& ranks, const Scene& scene, const std::filesystem::path& out);

}  // namespace turgor::mpi
