#include "turgor/io/files/reader_program.hpp"

#include <csignal>
#include <cstdlib>
#include <string>

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "tests/folders.hpp"

namespace turgor::io {
namespace {

namespace fs = std::filesystem;

/// A program that ends with this status.
fs::path script(const std::string& status) {
  const fs::path file = test::fresh_folder() / "turgor-read";
  test::write(file, "#!/bin/sh\nexit " + status + "\n");
  fs::permissions(file, fs::perms::owner_all);
  return file;
}

std::string line_of(const std::string& text, const std::string& start) {
  const std::size_t at = text.find(start);
  return at == text.npos ? "" : text.substr(at, text.find('\n', at) - at);
}

// The program of the build is found from a test of the build, without the PATH.
TEST(ReaderProgram, IsFoundInBuildTree) {
  const std::string path = std::getenv("PATH");
  setenv("PATH", "", 1);
  const Result<fs::path> program = find_reader();
  setenv("PATH", path.c_str(), 1);
  ASSERT_TRUE(program) << program.error().message;
  EXPECT_EQ(program->filename(), "turgor-read");
}

// TURGOR_READ has priority; a path that is no program is named.
TEST(ReaderProgram, VariableHasPriority) {
  const fs::path program = script("0"), text = test::fresh_folder() / "text";
  test::write(text, "no program");
  setenv("TURGOR_READ", program.c_str(), 1);
  EXPECT_EQ(find_reader().value(), program);
  for (const fs::path& wrong : {text, text / "none", text.parent_path()}) {
    setenv("TURGOR_READ", wrong.c_str(), 1);
    const Result<fs::path> found = find_reader();
    ASSERT_FALSE(found) << wrong;
    EXPECT_NE(found.error().message.find("TURGOR_READ"), std::string::npos);
    EXPECT_NE(found.error().message.find(wrong.string()), std::string::npos);
  }
  unsetenv("TURGOR_READ");
}

// A program of another version is refused by name, and its status is no verdict on the file.
TEST(ReaderProgram, RejectsOtherVersion) {
  for (const char* status : {"253", "2"}) {
    const fs::path program = script(status);
    setenv("TURGOR_READ", program.c_str(), 1);
    const Child child = start_reader(find_reader().value(), {"hdf5", "some.h5"}, {});
    const Result<ChildEnd> end = end_of_reader(wait_for({&child, 1}, {})[0]);
    ASSERT_FALSE(end);
    EXPECT_EQ(end.error().message, program.string() + " is of another version of turgor");
    unsetenv("TURGOR_READ");
  }
}

// A status that turgor-read does not have, as of a program without its libraries, is no verdict on the file.
TEST(ReaderProgram, ForeignStatusIsNoVerdict) {
  for (const char* status : {"127", "255"}) {
    const fs::path program = script(status);
    setenv("TURGOR_READ", program.c_str(), 1);
    const Child child = start_reader(find_reader().value(), {"hdf5", "some.h5"}, {});
    const Result<ChildEnd> end = end_of_reader(wait_for({&child, 1}, {})[0]);
    ASSERT_FALSE(end);
    EXPECT_EQ(end.error().message, program.string() + " ended with status " + status);
    unsetenv("TURGOR_READ");
  }
}

// Work that the program does not know ends with a status, not with a crash.
TEST(ReaderProgram, UnknownWorkIsRefused) {
  for (const std::vector<std::string>& work : {std::vector<std::string>{},
                                               {"jpeg", "a"},
                                               {"dicom", "0", "0"},
                                               {"dicom", "0", "1"},
                                               {"hdf5", "/no/file"}}) {
    const Child child = start_reader(find_reader().value(), work, {});
    const ChildEnd end = wait_for({&child, 1}, {})[0];
    EXPECT_EQ(end.kind, ChildEnd::Kind::kExited);
    EXPECT_NE(end.number, 0);
  }
}

// While it opens a file, here a pipe without a writer, the program has its limits and no rights.
TEST(ReaderProgram, RunsWithoutRights) {
  const fs::path pipe = test::fresh_folder() / "pipe.h5";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  const ChildLimits limits{.seconds = 60, .memory = std::size_t{256} << 20};
  const Child child = start_reader(find_reader().value(), {"hdf5", pipe.string()}, limits);
  const std::string folder = "/proc/" + std::to_string(child.id) + "/";
  usleep(100000);
  std::string status, most;
  for (int n = 0; n < 1000 && line_of(status, "NoNewPrivs:") != "NoNewPrivs:\t1"; n++) {
    usleep(10000);
    status = test::bytes_of(folder + "status");
  }
  usleep(100000);
  status = test::bytes_of(folder + "status"), most = test::bytes_of(folder + "limits");
  kill(child.id, SIGKILL);
  EXPECT_EQ(wait_for({&child, 1}, limits)[0].number, SIGKILL);
  EXPECT_EQ(line_of(status, "NoNewPrivs:"), "NoNewPrivs:\t1") << status;
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  EXPECT_EQ(line_of(status, "Seccomp:"), "Seccomp:\t2") << status;
#endif
  EXPECT_NE(line_of(most, "Max file size").find(" 0 "), std::string::npos) << most;
  EXPECT_EQ(line_of(most, "Max address space").find("unlimited"), std::string::npos) << most;
}

}  // namespace
}  // namespace turgor::io
