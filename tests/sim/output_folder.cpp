#include "turgor/sim/output_folder.hpp"

#include <chrono>
#include <csignal>
#include <fstream>
#include <set>
#include <thread>

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

TEST(OutputFolder, FoldersAroundItGoAgainWhenNothingIsInThem) {
  const fs::path root = fresh_folder();
  { ASSERT_TRUE(OutputFolder::create(root / "study/patient/out")); }
  EXPECT_EQ(names_in(root), std::set<std::string>{});
  fs::create_directory(root / "mine");
  { ASSERT_TRUE(OutputFolder::create(root / "mine/out")); }
  EXPECT_EQ(names_in(root), std::set<std::string>{"mine"}) << "it was there before";
  leave_output(root / "study/out", "kept");
  { ASSERT_TRUE(OutputFolder::create(root / "study/other")); }
  EXPECT_EQ(names_in(root / "study"), std::set<std::string>{"out"});
}

std::string error_of(const fs::path& goal, Foreign foreign = Foreign::kRefuse) {
  const Result<OutputFolder> folder = OutputFolder::create(goal, foreign);
  return folder ? "" : folder.error().message;
}

TEST(OutputFolder, RefusesFilesAndFoldersOfOthers) {
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

TEST(OutputFolder, AReportOfSomebodyElseMakesNoFolderOurs) {
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

TEST(OutputFolder, FilesThatWereAddedOrChangedAreNamedAndStay) {
  const fs::path root = fresh_folder(), goal = root / "out";
  leave_output(goal, "first");
  fs::create_directory(goal / "mine");
  write(goal / "mine" / "notes.md", "seen twice");
  fs::create_symlink("/", goal / "link");
  write(goal / kReportFile, "First");  // of the same size
  EXPECT_EQ(error_of(goal),
            goal.string() +
                ": holds files that turgor did not write, or that were changed since: link, "
                "mine/notes.md, report.json; choose another folder with --out, or let them be "
                "removed with --force");
  EXPECT_EQ(text_of(goal / "mine" / "notes.md"), "seen twice");
  EXPECT_EQ(text_of(goal / kReportFile), "First");
  EXPECT_EQ(names_in(root), std::set<std::string>{"out"});
}

TEST(OutputFolder, ForceRemovesWhatItNamedAndNothingElse) {
  const fs::path root = fresh_folder(), goal = root / "out";
  leave_output(goal, "first");
  write(goal / "notes.md", "seen twice");
  Result<OutputFolder> folder = OutputFolder::create(goal, Foreign::kRemove);
  ASSERT_TRUE(folder) << folder.error().message;
  EXPECT_EQ(folder->doomed(), std::vector<std::string>{"notes.md"});
  write(folder->path() / kReportFile, "second");
  write(goal / "later.md", "came while it ran");
  ASSERT_TRUE(folder->commit());
  EXPECT_EQ(text_of(goal / kReportFile), "second");
  EXPECT_EQ(folder->kept(), root / "out.kept");
  EXPECT_EQ(text_of(root / "out.kept" / "later.md"), "came while it ran");
  EXPECT_FALSE(fs::exists(root / "out.kept" / "notes.md"));
  EXPECT_FALSE(fs::exists(root / "out.kept" / kReportFile));
}

TEST(OutputFolder, TooManyFilesToNameAreNotForcedAway) {
  const fs::path goal = fresh_folder() / "out";
  leave_output(goal, "first");
  for (int n = 0; n < 21; n++) write(goal / ("mine-" + std::to_string(n)), "x");
  EXPECT_NE(error_of(goal, Foreign::kRemove).find("and 1 more"), std::string::npos);
}

TEST(OutputFolder, FilesThatComeWhileARunWorksAreKeptBesideIt) {
  const fs::path root = fresh_folder(), goal = root / "out";
  leave_output(goal, "first");
  Result<OutputFolder> folder = OutputFolder::create(goal);
  ASSERT_TRUE(folder);
  write(folder->path() / kReportFile, "second");
  write(goal / "notes.md", "came while it ran");
  fs::create_directory(root / "out.kept");  // of an earlier time
  ASSERT_TRUE(folder->commit());
  EXPECT_EQ(text_of(goal / kReportFile), "second");
  EXPECT_EQ(folder->kept(), root / "out.kept-2");
  EXPECT_EQ(names_in(folder->kept()), (std::set<std::string>{".turgor-output", "notes.md"}));
}

TEST(OutputFolder, ResultsThatCannotHaveTheirNameKeepAnother) {
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

TEST(OutputFolder, OfTwoRunsIntoOneGoalTheLaterOneStaysWhole) {
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

TEST(OutputFolder, ALinkStaysAndTheFolderItNamesIsReplaced) {
  const fs::path root = fresh_folder();
  fs::create_directory(root / "disk");
  fs::create_symlink("disk", root / "out");
  leave_output(root / "out", "first");
  leave_output(root / "out", "second");
  EXPECT_TRUE(fs::is_symlink(root / "out"));
  EXPECT_EQ(text_of(root / "disk" / kReportFile), "second");
  fs::create_symlink("nowhere", root / "broken");
  EXPECT_EQ(error_of(root / "broken"),
            (root / "broken").string() + ": is a link to nowhere, where there is nothing");
}

TEST(OutputFolder, AnInputInTheGoalIsNotReplaced) {
  const fs::path root = fresh_folder(), goal = root / "out";
  leave_output(goal, "first");
  const Result<OutputFolder> folder = OutputFolder::create(goal);
  ASSERT_TRUE(folder);
  EXPECT_FALSE(folder->check_input(goal / "recording.h5"));
  EXPECT_TRUE(folder->check_input(root / "recording.h5"));
}

TEST(OutputFolder, WhatOthersPutIntoAnExchangedResultOutlivesAKill) {
  const fs::path root = fresh_folder(), goal = root / "out";
  const pid_t child = fork();
  if (child == 0) _exit(0);
  waitpid(child, nullptr, 0);  // a process that is certainly gone
  leave_output(goal, "first");
  write(goal / "notes.md", "came while it ran");
  fs::rename(goal, root / (".out.partial-" + std::to_string(child) + "-0"));  // killed after the exchange
  leave_output(goal, "second");
  EXPECT_EQ(names_in(root), (std::set<std::string>{"out", "out.kept"}));
  EXPECT_EQ(text_of(root / "out.kept" / "notes.md"), "came while it ran");
}

/// Runs `work` in a child process that then waits; sends it a signal when it says it is ready; returns how it
/// ended.
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

TEST(OutputFolder, AnInterruptRemovesPartialFoldersAndFilesAndEndsWith130) {
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

TEST(OutputFolder, ASignalThatIsIgnoredStaysIgnored) {
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
