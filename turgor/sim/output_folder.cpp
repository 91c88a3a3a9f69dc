#include "turgor/sim/output_folder.hpp"

#include <cerrno>
#include <cstdio>
#include <cstring>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include "turgor/sim/output_manifest.hpp"

namespace turgor {

namespace {

namespace fs = std::filesystem;

/// Removes earlier results. Returns the folder of remaining foreign files, empty if there are none.
fs::path remove_earlier(const fs::path& earlier, const fs::path& goal,
                        const std::vector<std::string>& removed_foreign) {
  if (remove_ours(earlier, removed_foreign)) return {};
  const fs::path kept = unused_name_beside(goal, "kept");
  return rename(earlier.c_str(), kept.c_str()) == 0 ? kept : earlier;
}

/// Removes remains of killed runs, and restores an earlier result that such a run had moved aside.
void clean_up(const fs::path& goal) {
  std::error_code error;
  for (const fs::path& partial : leftovers_beside(goal, "partial")) {
    // a complete one had been exchanged with the goal: it is the earlier result
    if (foreign_files(partial))
      remove_earlier(partial, goal, {});
    else
      fs::remove_all(partial, error);
  }
  for (const fs::path& old : leftovers_beside(goal, "old")) {
    if (fs::exists(goal, error))
      remove_earlier(old, goal, {});
    else
      fs::rename(old, goal, error);
  }
}

/// Limit of listed files; only listed files are removed.
constexpr std::size_t kMostNamed = 20;

std::string named(const std::vector<std::string>& files) {
  const std::size_t count = std::min(files.size(), kMostNamed);
  std::string text = fmt::format("{}", fmt::join(files.begin(), files.begin() + std::ptrdiff_t(count), ", "));
  return files.size() == count ? text : text + fmt::format(" and {} more", files.size() - count);
}

/// Mount points cannot be renamed.
bool is_mount_point(const fs::path& goal) {
  struct stat inside {
  }, outside{};
  return stat(goal.c_str(), &inside) == 0 && stat(goal.parent_path().c_str(), &outside) == 0 &&
         inside.st_dev != outside.st_dev;
}

/// Foreign files in the goal if it may be replaced.
Result<std::vector<std::string>> check_goal(const fs::path& goal, Foreign foreign) {
  std::error_code error;

  // no folder, or no results
  if (!fs::exists(goal, error)) return std::vector<std::string>{};
  if (!fs::is_directory(goal, error))
    return Error{fmt::format("{}: expected a folder for the results, found a file", goal.string())};
  if (is_mount_point(goal))
    return Error{fmt::format("{}: is a mount point; expected a folder in it", goal.string())};
  if (fs::is_empty(goal, error)) return std::vector<std::string>{};

  // foreign files
  Result<std::vector<std::string>> files = foreign_files(goal);
  if (!files)
    return Error{
        fmt::format("{}: the folder is not empty and is not the output of a run ({}); choose another one "
                    "with --out",
                    goal.string(), files.error().message)};
  if (foreign == Foreign::kRefuse && !files->empty())
    return Error{
        fmt::format("{}: holds files that turgor did not write, or that were changed since: {}; choose "
                    "another folder with --out, or remove them with --force",
                    goal.string(), named(*files))};
  if (files->size() > kMostNamed)
    return Error{fmt::format("{}: holds too many files that turgor did not write for --force: {}",
                             goal.string(), named(*files))};
  return files;
}

/// Renames `partial` to `goal`. Returns the new path of the earlier goal, if any.
Result<fs::path> swap_in(const fs::path& partial, const fs::path& goal) {
  constexpr int kTries = 3;  // another run may interfere
  for (int i = 0; i < kTries; i++) {
    if (rename(partial.c_str(), goal.c_str()) == 0) return fs::path();  // no goal, or an empty folder
    if (errno != ENOTEMPTY && errno != EEXIST) break;
    // one atomic exchange if the file system supports it
    if (renameat2(AT_FDCWD, partial.c_str(), AT_FDCWD, goal.c_str(), RENAME_EXCHANGE) == 0) return partial;
    if (errno == ENOENT) continue;
    const fs::path old = hidden_beside(goal, "old");
    if (rename(goal.c_str(), old.c_str()) != 0) break;
    if (rename(partial.c_str(), goal.c_str()) == 0) return old;
    const int reason = errno;
    rename(old.c_str(), goal.c_str());
    errno = reason;
    break;
  }
  return Error{fmt::format("{}: cannot rename the results: {}", goal.string(), std::strerror(errno))};
}

}  // namespace

Result<OutputFolder> OutputFolder::create(const fs::path& requested, Foreign foreign) {
  // goal
  const Result<fs::path> goal = resolved_goal(requested);
  if (!goal) return goal.error();
  if (!goal->has_filename())
    return Error{fmt::format("{}: expected the name of a folder for the results", requested.string())};
  std::error_code error;

  // parent folders
  MadeFolders made;
  for (fs::path p = goal->parent_path(); p.has_relative_path() && !fs::exists(p, error); p = p.parent_path())
    made.paths.push_back(p);
  fs::create_directories(goal->parent_path(), error);
  if (error)
    return Error{
        fmt::format("{}: cannot make the folder: {}", goal->parent_path().string(), error.message())};

  // earlier results
  clean_up(*goal);
  Result<std::vector<std::string>> removed_foreign = check_goal(*goal, foreign);
  if (!removed_foreign) return removed_foreign.error();

  // hidden folder to write into
  OutputFolder folder(*goal, std::move(made), std::move(*removed_foreign));
  if (!fs::create_directory(folder.path(), error))
    return Error{fmt::format("{}: cannot make the folder: {}", folder.path().string(), error.message())};
  folder.partial_.hold();
  return folder;
}

MadeFolders::~MadeFolders() {
  std::error_code ignored;  // for folders that are not empty
  for (const fs::path& path : paths) fs::remove(path, ignored);
}

OutputFolder::OutputFolder(fs::path goal, MadeFolders made, std::vector<std::string> removed_foreign)
    : goal_(std::move(goal)),
      removed_foreign_(std::move(removed_foreign)),
      made_(std::move(made)),
      partial_(goal_) {}

Status OutputFolder::check_input(const fs::path& file) const {
  std::error_code error;
  const fs::path canonical = fs::weakly_canonical(file, error);
  const fs::path inside = canonical.lexically_relative(goal_);
  if (error || inside.empty() || *inside.begin() == "..") return Done{};
  return Error{fmt::format("{}: is in {}, which would be replaced; choose another folder with --out",
                           file.string(), goal_.string())};
}

Status OutputFolder::replace_goal() {
  const Result<fs::path> earlier = swap_in(path(), goal_);
  if (!earlier) return earlier.error();
  if (!earlier->empty()) kept_ = remove_earlier(*earlier, goal_, removed_foreign_);
  return Done{};
}

Status OutputFolder::commit() {
  Status status = write_manifest(path());
  const Status moved = partial_.keep([&]() -> Result<fs::path> {
    if (status) status = replace_goal();
    if (status) return goal_;
    const fs::path aside = unused_name_beside(goal_, "results");  // keeps the results under another name
    if (rename(path().c_str(), aside.c_str()) != 0) return status.error();
    status = Error{fmt::format("{}; the results are in {}", status.error().message, aside.string())};
    return aside;
  });
  return status ? moved : status;
}

std::string removed_foreign_note(const OutputFolder& folder) {
  if (folder.removed_foreign().empty()) return {};
  return fmt::format("{}: --force removes, with the earlier results: {}", folder.goal().string(),
                     fmt::join(folder.removed_foreign(), ", "));
}

std::string kept_note(const OutputFolder& folder) {
  if (folder.kept().empty()) return {};
  return fmt::format("{}: files that turgor did not write were added; they are now in {}",
                     folder.goal().string(), folder.kept().string());
}

}  // namespace turgor
