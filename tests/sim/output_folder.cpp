#include "turgor/sim/output_folder.hpp"

#include <csignal>
#include <fstream>
#include <set>

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include "folders.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;

using test::fresh_folder;
using test::names_in;
using test::write;

std::string text_of(const fs::path& path) {
  std::ifstream stream(path);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// Makes a complete output that says `text`.
void leave_output(const fs::path& goal, const std::string& text) {
  Result<OutputFolder> folder = OutputFolder::create(goal);
  ASSERT_TRUE(folder) << folder.error().message;
  write(folder->path() / kReportFile, text);
  ASSERT_TRUE(folder->commit());
}

TEST(OutputFolder, AppearsUnderItsNameOnlyWhenCommitted) {
  const fs::path root = fresh_folder(), goal = root / "deep" / "out";
  {
    Result<OutputFolder> folder = OutputFolder::create(goal);
    ASSERT_TRUE(folder) << folder.error().message;
    write(folder->path() / kReportFile, "first");
    EXPECT_FALSE(fs::exists(goal));
    ASSERT_TRUE(folder->commit());
  }
  EXPECT_EQ(text_of(goal / kReportFile), "first");
  EXPECT_EQ(names_in(goal.parent_path()), std::set<std::string>{"out"});
}

TEST(OutputFolder, ReplacesAnEarlierOutputOnlyAtTheEnd) {
  const fs::path root = fresh_folder(), goal = root / "out";
  leave_output(goal, "first");
  {
    Result<OutputFolder> folder = OutputFolder::create(goal);
    ASSERT_TRUE(folder);
    write(folder->path() / kReportFile, "second");
    EXPECT_EQ(text_of(goal / kReportFile), "first");
    ASSERT_TRUE(folder->commit());
  }
  EXPECT_EQ(text_of(goal / kReportFile), "second");
  EXPECT_EQ(names_in(root), std::set<std::string>{"out"});
}

TEST(OutputFolder, LeavesNothingWithoutCommit) {
  const fs::path root = fresh_folder(), goal = root / "out";
  leave_output(goal, "first");
  { ASSERT_TRUE(OutputFolder::create(goal)); }
  EXPECT_EQ(text_of(goal / kReportFile), "first");
  EXPECT_EQ(names_in(root), std::set<std::string>{"out"});
}

TEST(OutputFolder, RefusesFilesAndFoldersOfOthers) {
  const fs::path root = fresh_folder();
  write(root / "thesis.tex", "ten years of work");
  const auto error = [](const fs::path& goal) { return OutputFolder::create(goal).error().message; };
  EXPECT_EQ(error(root), root.string() +
                             ": the folder is not empty and is not the output of a run (it has no "
                             "report.json); choose another one with --out");
  EXPECT_EQ(error(root / "thesis.tex"),
            (root / "thesis.tex").string() + ": expected a folder for the results, found a file");
  EXPECT_EQ(names_in(root), std::set<std::string>{"thesis.tex"});
  EXPECT_NE(error("/proc/out").find("/proc/.out.partial-"), std::string::npos) << error("/proc/out");
}

/// Runs `work` in a child process that then waits; sends it a signal when it says it is ready; returns how it
/// ended.
int signal_while(const std::function<void()>& work, int signal) {
  int ready[2];
  EXPECT_EQ(pipe(ready), 0);
  const pid_t child = fork();
  if (child == 0) {
    remove_partial_folders_when_interrupted();
    work();
    (void)!::write(ready[1], "x", 1);
    for (;;) pause();
  }
  close(ready[1]);
  char byte;
  EXPECT_EQ(::read(ready[0], &byte, 1), 1) << "the child ended before it was ready";
  kill(child, signal);
  int status = 0;
  waitpid(child, &status, 0);
  close(ready[0]);
  return status;
}

TEST(OutputFolder, AnInterruptRemovesThePartialFolderAndEndsWith130) {
  for (const int signal : {SIGINT, SIGTERM}) {
    const fs::path root = fresh_folder(), goal = root / "out";
    leave_output(goal, "first");
    const int status = signal_while(
        [&] {
          static OutputFolder folder = OutputFolder::create(goal).value();
          write(folder.path() / "half.txt", "half");
        },
        signal);
    ASSERT_TRUE(WIFEXITED(status));
    EXPECT_EQ(WEXITSTATUS(status), 130);
    EXPECT_EQ(text_of(goal / kReportFile), "first");
    EXPECT_EQ(names_in(root), std::set<std::string>{"out"});
  }
}

TEST(OutputFolder, AKilledRunLeavesTheEarlierOneWholeAndTheNextCleansUp) {
  const fs::path root = fresh_folder(), goal = root / "out";
  leave_output(goal, "first");
  const int status =
      signal_while([&] { static OutputFolder folder = OutputFolder::create(goal).value(); }, SIGKILL);
  ASSERT_TRUE(WIFSIGNALED(status));
  EXPECT_EQ(names_in(root).size(), 2u);  // the earlier output and what the killed run left
  EXPECT_EQ(text_of(goal / kReportFile), "first");
  leave_output(goal, "second");
  EXPECT_EQ(text_of(goal / kReportFile), "second");
  EXPECT_EQ(names_in(root), std::set<std::string>{"out"});
}

TEST(OutputFolder, FoldersOfRunsThatStillWorkAreLeftAlone) {
  const fs::path root = fresh_folder(), goal = root / "out";
  const fs::path other = root / (".out.partial-" + std::to_string(getppid()));
  fs::create_directory(other);
  leave_output(goal, "first");
  EXPECT_TRUE(fs::exists(other));
}

TEST(OutputFolder, AnEarlierOutputThatWasMovedAsideComesBack) {
  const fs::path root = fresh_folder(), goal = root / "out";
  const pid_t child = fork();
  if (child == 0) _exit(0);
  waitpid(child, nullptr, 0);  // a process that is certainly gone
  leave_output(goal, "first");
  fs::rename(goal, root / (".out.old-" + std::to_string(child)));
  { ASSERT_TRUE(OutputFolder::create(goal)); }
  EXPECT_EQ(text_of(goal / kReportFile), "first");
}

}  // namespace
}  // namespace turgor
