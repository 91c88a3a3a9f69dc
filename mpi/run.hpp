// Simulation of one body in several processes, with displacements at the nodes and a report.
#pragma once

#include <filesystem>

#include "mpi/ranks.hpp"
#include "turgor/core/exec.hpp"
#include "turgor/sim/report/json_numbers.hpp"
#include "turgor/sim/scene/scene.hpp"

namespace turgor::mpi {

/// Writes a folder that appears when it is complete: report.json, displacement.mhd and displacement.raw.
/// Returns the report. Error: the same on all ranks.
Result<Json> run(const Exec& exec, const Ranks& ranks, const Scene& scene, const std::filesystem::path& out);

}  // namespace turgor::mpi
