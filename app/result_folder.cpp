#include "app/result_folder.hpp"

namespace turgor {

void add_force_option(CLI::App& command, bool& force) {
  command.add_flag(
      "--force", force,
      "Replace earlier results also where files were added or changed; they are named, and removed");
}

OutputFolder open_result_folder(const std::filesystem::path& goal, bool force) {
  OutputFolder folder = required(OutputFolder::create(goal, force ? Foreign::kRemove : Foreign::kRefuse));
  if (const std::string doomed = doomed_note(folder); !doomed.empty()) note(doomed);
  return folder;
}

void commit_results(OutputFolder& folder) {
  required(folder.commit());
  if (const std::string kept = kept_note(folder); !kept.empty()) note(kept);
}

}  // namespace turgor
