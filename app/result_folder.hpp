// Result folders of commands. Prints notes about files in them that turgor did not write.
#pragma once

#include "app/commands.hpp"
#include "turgor/sim/output_folder.hpp"

namespace turgor {

/// Adds --force.
void add_force_option(CLI::App& command, bool& force);

/// Throws Failure if the folder cannot take results.
OutputFolder open_result_folder(const std::filesystem::path& goal, bool force);
void commit_results(OutputFolder& folder);

}  // namespace turgor
