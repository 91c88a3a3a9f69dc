#include "app/result_folder.hpp"

namespace turgor {

void add_force_option(CLI::App& command, bool& force) {
  command.add_flag("--force", force,
                   "Replace earlier results even if files were added or changed; removed files are listed");
}

OutputFolder open_result_folder(const std::filesystem::path& goal, bool force) {
  OutputFolder folder = required(OutputFolder::create(goal, force ? Foreign::kRemove : Foreign::kRefuse));
  if (const std::string removed_foreign = removed_foreign_note(folder); !removed_foreign.empty())
    note(removed_foreign);
  return folder;
}

void commit_results(OutputFolder& folder) {
  required(folder.commit());
  if (const std::string kept = kept_note(folder); !kept.empty()) note(kept);
}

}  // namespace turgor
