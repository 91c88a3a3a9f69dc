#include "app/result_folder.hpp"

#include <fmt/format.h>

namespace turgor {

void add_force_option(CLI::App& command, bool& force) {
  command.add_flag(
      "--force", force,
      "Replace earlier results also where files were added or changed; they are named, and removed");
}

OutputFolder open_result_folder(const std::filesystem::path& goal, bool force) {
  Result<OutputFolder> folder = OutputFolder::create(goal, force ? Foreign::kRemove : Foreign::kRefuse);
  if (!folder) throw Failure{2, folder.error().message};
  if (!folder->doomed().empty())
    note(fmt::format("{}: --force removes, with the earlier results: {}", folder->goal().string(),
                     fmt::join(folder->doomed(), ", ")));
  return std::move(*folder);
}

void commit_results(OutputFolder& folder) {
  if (const Status status = folder.commit(); !status) throw Failure{2, status.error().message};
  if (!folder.kept().empty())
    note(fmt::format("{}: files that turgor did not write had come there; they are in {} now",
                     folder.goal().string(), folder.kept().string()));
}

}  // namespace turgor
