#include "turgor/sim/output_folder.hpp"

#include <chrono>
#include <csignal>
#include <fstream>
#include <set>
#include <thread>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/folders.hpp"
#include "turgor/io/files/file.hpp"

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

/// Writes a complete output whose report is `text`.
void leave_output(const fs::path& goal, const std::string& text) {
  Result<OutputFolder> folder = OutputFolder::create(goal);
  ASSERT_TRUE(folder) << folder.error().message;
  write(folder->path() / kReportFile, text);
  ASSERT_TRUE(folder->commit());
}

// The folder appears under its name only when it is committed.
TEST(OutputFolder, AppearsOnCommit) {
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

// An earlier output is replaced only by the commit.
TEST(OutputFolder, ReplacesEarlierOutputOnCommit) {
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

// Without a commit no new files remain.
TEST(OutputFolder, RemovesFilesWithoutCommit) {
  const fs::path root = fresh_folder(), goal = root / "out";
  leave_output(goal, "first");
  { ASSERT_TRUE(OutputFolder::create(goal)); }
  EXPECT_EQ(text_of(goal / kReportFile), "first");
  EXPECT_EQ(names_in(root), std::set<std::string>{"out"});
}

// Parent folders that it created are removed again if they are empty.
TEST(OutputFolder, RemovesEmptyParentFolders) {
  const fs::path root = fresh_folder();
  { ASSERT_TRUE(OutputFolder::create(root / "study/patient/out")); }
  EXPECT_EQ(names_in(root), std::set<std::string>{});
  fs::create_directory(root / "mine");
  { ASSERT_TRUE(OutputFolder::create(root / "mine/out")); }
  EXPECT_EQ(names_in(root), std::set<std::string>{"mine"}) << "an existing folder is kept";
  leave_output(root / "study/out", "kept");
  { ASSERT_TRUE(OutputFolder::create(root / "study/other")); }
  EXPECT_EQ(names_in(root / "study"), std::set<std::string>{"out"});
}

std::string error_of(const fs::path& goal, Foreign foreign = Foreign::kRefuse) {
  const Result<OutputFolder> folder = OutputFolder::create(goal, foreign);
  return folder ? "" : folder.error().message;
}

// Files, and folders that are not outputs, are refused.
TEST(OutputFolder, RejectsForeignPaths) {
  const fs::path root = fresh_folder();
  write(root / "thesis.tex", "ten years of work");
  EXPECT_EQ(error_of(root), root.string() +
                                ": the folder is not empty and is not the output of a run (it has no "
                                ".turgor-output); choose another one with --out");
  EXPECT_EQ(error_of(root / "thesis.tex"),
            (root / "thesis.tex").string() + ": expected a folder for the results, found a file");
  EXPECT_EQ(names_in(root), std::set<std::string>{"thesis.tex"});
  EXPECT_NE(error_of("/proc/out").find("/proc/.out.partial-"), std::string::npos) << error_of("/proc/out");
}

// A folder with a foreign report.json is not an output.
TEST(OutputFolder, ForeignReportIsNoOutput) {
  const fs::path goal = fresh_folder() / "project";
  fs::create_directory(goal);
  write(goal / "report.json", "{}");
  write(goal / "thesis.tex", "ten years of work");
  for (const Foreign foreign : {Foreign::kRefuse, Foreign::kRemove})
    EXPECT_NE(error_of(goal, foreign).find("is not the output of a run"), std::string::npos);
  write(goal / ".turgor-output", "no list");
  EXPECT_NE(error_of(goal, Foreign::kRemove).find("(its .turgor-output is damaged)"), std::string::npos);
  EXPECT_EQ(text_of(goal / "thesis.tex"), "ten years of work");
}

// Added and changed files are named and kept.
TEST(OutputFolder, KeepsAddedAndChangedFiles) {
  const fs::path root = fresh_folder(), goal = root / "out";
  leave_output(goal, "first");
  fs::create_directory(goal / "mine");
  write(goal / "mine" / "notes.md", "seen twice");
  fs::create_symlink("/", goal / "link");
  write(goal / kReportFile, "First");  // same size
  EXPECT_EQ(error_of(goal),
            goal.string() +
                ": holds files that turgor did not write, or that were changed since: link, "
                "mine/notes.md, report.json; choose another folder with --out, or remove them "
                "with --force");
  EXPECT_EQ(text_of(goal / "mine" / "notes.md"), "seen twice");
  EXPECT_EQ(text_of(goal / kReportFile), "First");
  EXPECT_EQ(names_in(root), std::set<std::string>{"out"});
}

// Force removes only the files that it named.
TEST(OutputFolder, ForceRemovesOnlyNamedFiles) {
  const fs::path root = fresh_folder(), goal = root / "out";
  leave_output(goal, "first");
  write(goal / "notes.md", "seen twice");
  Result<OutputFolder> folder = OutputFolder::create(goal, Foreign::kRemove);
  ASSERT_TRUE(folder) << folder.error().message;
  EXPECT_EQ(folder->removed_foreign(), std::vector<std::string>{"notes.md"});
  write(folder->path() / kReportFile, "second");
  write(goal / "later.md", "came while it ran");
  ASSERT_TRUE(folder->commit());
  EXPECT_EQ(text_of(goal / kReportFile), "second");
  EXPECT_EQ(folder->kept(), root / "out.kept");
  EXPECT_EQ(text_of(root / "out.kept" / "later.md"), "came while it ran");
  EXPECT_FALSE(fs::exists(root / "out.kept" / "notes.md"));
  EXPECT_FALSE(fs::exists(root / "out.kept" / kReportFile));
}

// Force refuses to remove more files than it can name.
TEST(OutputFolder, ForceRejectsTooManyFiles) {
  const fs::path goal = fresh_folder() / "out";
  leave_output(goal, "first");
  for (int n = 0; n < 21; n++) write(goal / ("mine-" + std::to_string(n)), "x");
  EXPECT_NE(error_of(goal, Foreign::kRemove).find("and 1 more"), std::string::npos);
}

// Files that appear during a run are moved to a separate folder.
TEST(OutputFolder, KeepsFilesAddedDuringRun) {
  const fs::path root = fresh_folder(), goal = root / "out";
  leave_output(goal, "first");
  Result<OutputFolder> folder = OutputFolder::create(goal);
  ASSERT_TRUE(folder);
  write(folder->path() / kReportFile, "second");
  write(goal / "notes.md", "came while it ran");
  fs::create_directory(root / "out.kept");  // from an earlier run
  ASSERT_TRUE(folder->commit());
  EXPECT_EQ(text_of(goal / kReportFile), "second");
  EXPECT_EQ(folder->kept(), root / "out.kept-2");
  EXPECT_EQ(names_in(folder->kept()), (std::set<std::string>{".turgor-output", "notes.md"}));
}

// Results whose name is blocked are kept under another name.
TEST(OutputFolder, BlockedNameGetsAlternative) {
  const fs::path root = fresh_folder(), goal = root / "out";
  Result<OutputFolder> folder = OutputFolder::create(goal);
  ASSERT_TRUE(folder);
  write(folder->path() / kReportFile, "hours of work");
  write(goal, "a file came there");
  const Status status = folder->commit();
  ASSERT_FALSE(status);
  EXPECT_NE(status.error().message.find("the results are in " + (root / "out.results").string()),
            std::string::npos)
      << status.error().message;
  EXPECT_EQ(text_of(root / "out.results" / kReportFile), "hours of work");
  EXPECT_EQ(text_of(goal), "a file came there");
}

// The later of two runs with the same output is complete.
TEST(OutputFolder, LaterOfTwoRunsIsComplete) {
  const fs::path root = fresh_folder(), goal = root / "out";
  Result<OutputFolder> one = OutputFolder::create(goal), two = OutputFolder::create(goal);
  ASSERT_TRUE(one && two);
  write(one->path() / kReportFile, "one"), write(one->path() / "of-one", "x");
  write(two->path() / kReportFile, "two");
  ASSERT_TRUE(one->commit());
  ASSERT_TRUE(two->commit());
  EXPECT_EQ(names_in(goal), (std::set<std::string>{".turgor-output", kReportFile}));
  EXPECT_EQ(text_of(goal / kReportFile), "two");
  EXPECT_EQ(names_in(root), std::set<std::string>{"out"});
}

// A symbolic link is kept and its target is replaced.
TEST(OutputFolder, ReplacesTargetOfLink) {
  const fs::path root = fresh_folder();
  fs::create_directory(root / "disk");
  fs::create_symlink("disk", root / "out");
  leave_output(root / "out", "first");
  leave_output(root / "out", "second");
  EXPECT_TRUE(fs::is_symlink(root / "out"));
  EXPECT_EQ(text_of(root / "disk" / kReportFile), "second");
  fs::create_symlink("nowhere", root / "broken");
  EXPECT_EQ(error_of(root / "broken"),
            (root / "broken").string() + ": is a link to nowhere, which does not exist");
}

// An input inside the output folder is refused.
TEST(OutputFolder, RejectsInputInOutput) {
  const fs::path root = fresh_folder(), goal = root / "out";
  leave_output(goal, "first");
  const Result<OutputFolder> folder = OutputFolder::create(goal);
  ASSERT_TRUE(folder);
  EXPECT_FALSE(folder->check_input(goal / "recording.h5"));
  EXPECT_TRUE(folder->check_input(root / "recording.h5"));
}

// Foreign files in a result survive a run that is killed after the exchange.
TEST(OutputFolder, ForeignFilesSurviveKill) {
  const fs::path root = fresh_folder(), goal = root / "out";
  const pid_t child = fork();
  if (child == 0) _exit(0);
  waitpid(child, nullptr, 0);  // a process that has certainly ended
  leave_output(goal, "first");
  write(goal / "notes.md", "came while it ran");
  fs::rename(goal, root / (".out.partial-" + std::to_string(child) + "-0"));  // killed after the exchange
  leave_output(goal, "second");
  EXPECT_EQ(names_in(root), (std::set<std::string>{"out", "out.kept"}));
  EXPECT_EQ(text_of(root / "out.kept" / "notes.md"), "came while it ran");
}

/// Runs `work` in a child process that then waits, sends it a signal when it is ready, and returns its exit
/// status.
int signal_while(
    const std::function<void()>& work, int signal, const std::function<void()>& before = [] {}) {
  int ready[2];
  EXPECT_EQ(pipe(ready), 0);
  const pid_t child = fork();
  if (child == 0) {
    before();
    remove_unfinished_when_interrupted();
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

// An interrupt removes partial folders and files and ends with code 130.
TEST(OutputFolder, InterruptRemovesPartialFiles) {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGQUIT}) {
    const fs::path root = fresh_folder(), goal = root / "out";
    leave_output(goal, "first");
    const int status = signal_while(
        [&] {
          static OutputFolder folder = OutputFolder::create(goal).value();
          write(folder.path() / "half.txt", "half");
          static FileWriter file = FileWriter::create(root / "half.nrrd").value();
          file.write("half");
        },
        signal);
    ASSERT_TRUE(WIFEXITED(status));
    EXPECT_EQ(WEXITSTATUS(status), 130);
    EXPECT_EQ(text_of(goal / kReportFile), "first");
    EXPECT_EQ(names_in(root), std::set<std::string>{"out"});
  }
}

// An interrupt after the results are complete names them.
TEST(OutputFolder, InterruptNamesCompleteResults) {
  const fs::path root = fresh_folder(), goal = root / "out", printed = root / "printed";
  for (const bool complete : {false, true}) {
    const int status = signal_while(
        [&] {
          if (complete) leave_output(goal, "first");
          const int file = open(printed.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
          dup2(file, STDERR_FILENO);
        },
        SIGTERM);
    ASSERT_TRUE(WIFEXITED(status));
    EXPECT_EQ(WEXITSTATUS(status), 130);
    EXPECT_EQ(fs::exists(goal), complete);
    EXPECT_EQ(text_of(printed).find("interrupted; complete: " + goal.string() + ";") != std::string::npos,
              complete)
        << text_of(printed);
    EXPECT_EQ(text_of(printed).find("earlier results are unchanged") == std::string::npos, complete);
  }
}

// A signal that is ignored at the start remains ignored.
TEST(OutputFolder, IgnoredSignalStaysIgnored) {
  const fs::path root = fresh_folder();
  const int status = signal_while(
      [&] {
        write(root / "started", "");
        std::thread([&] {
          std::this_thread::sleep_for(std::chrono::milliseconds(200));
          _exit(7);
        }).detach();
      },
      SIGHUP, [] { std::signal(SIGHUP, SIG_IGN); });
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 7) << "as with nohup";
}

// A killed run keeps the earlier output, and the next run removes its partial folder.
TEST(OutputFolder, NextRunCleansUpAfterKill) {
  const fs::path root = fresh_folder(), goal = root / "out";
  leave_output(goal, "first");
  const int status =
      signal_while([&] { static OutputFolder folder = OutputFolder::create(goal).value(); }, SIGKILL);
  ASSERT_TRUE(WIFSIGNALED(status));
  EXPECT_EQ(names_in(root).size(), 2u);  // the earlier output and the partial folder of the killed run
  EXPECT_EQ(text_of(goal / kReportFile), "first");
  leave_output(goal, "second");
  EXPECT_EQ(text_of(goal / kReportFile), "second");
  EXPECT_EQ(names_in(root), std::set<std::string>{"out"});
}

// Partial folders of active runs are kept.
TEST(OutputFolder, KeepsFoldersOfActiveRuns) {
  const fs::path root = fresh_folder(), goal = root / "out";
  const fs::path other = root / (".out.partial-" + std::to_string(getppid()));
  fs::create_directory(other);
  leave_output(goal, "first");
  EXPECT_TRUE(fs::exists(other));
}

// An earlier output that a killed run had renamed is restored.
TEST(OutputFolder, RestoresRenamedOutput) {
  const fs::path root = fresh_folder(), goal = root / "out";
  const pid_t child = fork();
  if (child == 0) _exit(0);
  waitpid(child, nullptr, 0);  // a process that has certainly ended
  leave_output(goal, "first");
  fs::rename(goal, root / (".out.old-" + std::to_string(child)));
  { ASSERT_TRUE(OutputFolder::create(goal)); }
  EXPECT_EQ(text_of(goal / kReportFile), "first");
}

}  // namespace
}  // namespace turgor
