// The folder of results as commands use it: what happens to files that turgor did not write is said.
#pragma once

#include "app/commands.hpp"
#include "turgor/sim/output_folder.hpp"

namespace turgor {

/// Adds --force.
void add_force_option(CLI::App& command, bool& force);

/// Throws Failure when results may not be put there.
OutputFolder open_result_folder(const std::filesystem::path& goal, bool force);
void commit_results(OutputFolder& folder);

}  // namespace turgor
