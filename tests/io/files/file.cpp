#include "turgor/io/files/file.hpp"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <thread>

#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/folders.hpp"
#include "tests/refused.hpp"
#include "tests/small_disk.hpp"
#include "turgor/io/ct.hpp"
#include "turgor/io/files/hdf5_file.hpp"
#include "turgor/io/files/image.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;
using test::bytes_of;
using test::fresh_folder;
using test::names_in;
using test::on_a_small_disk;
using test::write;

constexpr rlim_t kFew = 300;  // bytes

/// Volume of noise, which cannot be compressed.
CtVolume noise() {
  CtVolume ct{{.size = {20, 20, 20}, .spacing = {1e-3, 1e-3, 1e-3}}, {}};
  std::uint32_t state = 1;
  for (std::size_t n = 0; n < sample_count(ct.grid); n++)
    ct.samples.push_back(std::int16_t((state = state * 1664525u + 1013904223u) >> 16));
  return ct;
}

Image noisy_picture() {
  Image image = make_image(40, 40);
  const CtVolume ct = noise();
  for (std::size_t p = 0; p < image.pixels.size(); p++)
    image.pixels[p] = {std::uint8_t(ct.samples[p]), std::uint8_t(ct.samples[p] >> 8), std::uint8_t(p)};
  return image;
}

// On a full disk every writer fails with a message and keeps the earlier file.
TEST(File, FullDiskKeepsOldFile) {
  struct Writer {
    const char* name;
    std::function<Status(const fs::path&)> write;
  };
  const auto ct = [](const fs::path& path) { return write_ct(path, noise()); };
  const Writer writers[] = {
      {"a.txt", [](const fs::path& path) { return write_file(path, std::string(1000, 'x')); }},
      {"a.nii", ct},
      {"a.nii.gz", ct},
      {"a.nrrd", ct},
      {"a.mha", ct},
      {"a.png", [](const fs::path& path) { return write_png(path, noisy_picture()); }}};
  for (const Writer& writer : writers) {
    const fs::path folder = fresh_folder(), file = folder / writer.name;
    write(file, "earlier");
    EXPECT_TRUE(on_a_small_disk(kFew, [&] {
      const Status status = writer.write(file);
      return !status && status.error().message == file.string() + ": cannot write the file: File too large";
    })) << writer.name;
    EXPECT_EQ(bytes_of(file), "earlier") << writer.name;
    EXPECT_EQ(names_in(folder), std::set<std::string>{writer.name});
    EXPECT_TRUE(writer.write(file)) << "with enough space the file is written";
    EXPECT_GT(fs::file_size(file), kFew);
  }
}

// On a full disk writing a DICOM folder fails with a message and leaves no files.
TEST(File, FullDiskLeavesNoDicomFolder) {
  const fs::path folder = fresh_folder();
  EXPECT_TRUE(on_a_small_disk(kFew, [&] {
    const Status status = write_dicom(Exec(1), folder / "ct", noise(), patient_alone("Anonymous"));
    return !status &&
           status.error().message.find("cannot write the file: File too large") != std::string::npos;
  }));
  EXPECT_EQ(names_in(folder), std::set<std::string>{});
}

// On a full disk writing an HDF5 file fails without crashing the program.
TEST(File, FullDiskHdf5FailsCleanly) {
  const fs::path folder = fresh_folder();
  for (const std::size_t count : {std::size_t{10}, std::size_t{100000}})
    EXPECT_TRUE(on_a_small_disk(kFew, [&] {
      Result<Hdf5File> file = Hdf5File::create(folder / "a.h5");
      if (!file) return true;
      const std::vector<float> values(count, 1);
      const Status written = file->write<float>("/values", values, 1, Hdf5Packing::kPlain);
      return !written || !file->close();
    })) << count;
}

// Devices are written into and never replaced by a file.
TEST(File, DevicesAreNeverReplaced) {
  EXPECT_REFUSED(write_file("/dev/full", "x"), "/dev/full: cannot write the file: No space left on device");
  EXPECT_TRUE(write_file("/dev/null", "x"));
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
  EXPECT_TRUE(fs::is_character_file("/dev/full"));
  const fs::path folder = fresh_folder();
  fs::create_symlink("/dev/full", folder / "a.mha");
  EXPECT_REFUSED(write_ct(folder / "a.mha", noise()),
                 "a.mha: cannot write the file: No space left on device");
  EXPECT_TRUE(fs::is_symlink(folder / "a.mha"));
}

// Writing through a link keeps the link and replaces its target.
TEST(File, WriteFollowsLink) {
  const fs::path folder = fresh_folder();
  fs::create_directory(folder / "data");
  write(folder / "data" / "a.txt", "earlier");
  fs::create_symlink("data/a.txt", folder / "latest");
  ASSERT_TRUE(write_file(folder / "latest", "new"));
  EXPECT_TRUE(fs::is_symlink(folder / "latest"));
  EXPECT_EQ(bytes_of(folder / "data" / "a.txt"), "new");
  fs::create_symlink("nowhere/a.txt", folder / "broken");
  EXPECT_REFUSED(write_file(folder / "broken", "new"),
                 "broken: is a link to nowhere/a.txt, which does not exist");
}

// A replaced file keeps its permissions.
TEST(File, ReplacementKeepsPermissions) {
  const fs::path file = fresh_folder() / "patient.txt";
  write(file, "earlier");
  chmod(file.c_str(), 0600);
  ASSERT_TRUE(write_file(file, "new"));
  EXPECT_EQ(fs::status(file).permissions(), fs::perms(0600));
}

// A folder as target, or a missing folder, is rejected and named.
TEST(File, BadTargetIsNamed) {
  const fs::path folder = fresh_folder();
  write(folder / "text", "x");
  EXPECT_REFUSED(check_file_goal(folder), "is a folder; expected the name of a file");
  EXPECT_REFUSED(check_file_goal(folder / ""), "is a folder; expected the name of a file");
  EXPECT_REFUSED(check_file_goal(folder / "none" / "a.txt"), "none does not exist");
  EXPECT_REFUSED(check_file_goal(folder / "text" / "a.txt"), "text is not a folder");
}

// A write-protected file is not replaced.
TEST(File, WriteProtectedFileIsKept) {
  if (geteuid() == 0) GTEST_SKIP() << "root can write every file";
  const fs::path file = fresh_folder() / "kept.txt";
  write(file, "earlier");
  chmod(file.c_str(), 0444);
  EXPECT_REFUSED(write_file(file, "new"), "kept.txt: cannot write the file: Permission denied");
  EXPECT_EQ(bytes_of(file), "earlier");
}

// A writer that is destroyed before commit leaves no file.
TEST(File, UncommittedWriteLeavesNothing) {
  const fs::path folder = fresh_folder();
  {
    Result<FileWriter> file = FileWriter::create(folder / "a.txt");
    ASSERT_TRUE(file);
    file->write("half");
    EXPECT_EQ(names_in(folder).size(), 1u);
  }
  EXPECT_EQ(names_in(folder), std::set<std::string>{});
}

// The temporary file of a killed program is removed by the next write.
TEST(File, NextWriteRemovesStaleTemporary) {
  const fs::path folder = fresh_folder(), file = folder / "a.txt";
  const pid_t child = fork();
  if (child == 0) {
    Result<FileWriter> half = FileWriter::create(file);
    half->write("half");
    raise(SIGKILL);
  }
  waitpid(child, nullptr, 0);
  EXPECT_EQ(names_in(folder).size(), 1u);
  ASSERT_TRUE(write_file(file, "whole"));
  EXPECT_EQ(names_in(folder), std::set<std::string>{"a.txt"});
}

// The temporary file of a killed program is removed while that is a zombie.
TEST(File, ZombieOwnsNoTemporary) {
  const fs::path folder = fresh_folder(), file = folder / "a.txt";
  const pid_t child = fork();
  if (child == 0) {
    Result<FileWriter> half = FileWriter::create(file);
    raise(SIGKILL);
  }
  siginfo_t ended{};
  ASSERT_EQ(waitid(P_PID, id_t(child), &ended, WEXITED | WNOWAIT), 0);  // it stays a zombie
  EXPECT_EQ(names_in(folder).size(), 1u);
  ASSERT_TRUE(write_file(file, "whole"));
  EXPECT_EQ(names_in(folder), std::set<std::string>{"a.txt"});
  waitpid(child, nullptr, 0);
}

/// Id of a child that waits until it is killed.
pid_t waiting_child() {
  const pid_t child = fork();
  if (child == 0) {
    pause();
    _exit(0);
  }
  return child;
}

void end_child(pid_t child) {
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
}

// A process that started after the last change of a temporary file does not own it, whatever its id.
TEST(File, LaterProcessOwnsNoTemporary) {
  const fs::path folder = fresh_folder(), file = folder / "a.txt";
  const auto temporary = [&](pid_t id) { return folder / (".a.txt.partial-" + std::to_string(id) + "-0"); };
  const auto is_left = [&](pid_t id) {
    const std::vector<fs::path> all = leftovers_beside(file, "partial");
    return std::find(all.begin(), all.end(), temporary(id)) != all.end();
  };
  const pid_t earlier = waiting_child();
  constexpr int kIds = 2000;  // other programs take some of them
  for (int n = 0; n < kIds; n++) write(temporary(earlier + n), "half");
  std::this_thread::sleep_for(std::chrono::milliseconds(1300));
  const pid_t later = waiting_child();
  EXPECT_FALSE(is_left(earlier)) << "the owner runs";
  const bool reached = fs::exists(temporary(later));
  EXPECT_EQ(is_left(later), reached);
  end_child(earlier), end_child(later);
  EXPECT_TRUE(is_left(earlier)) << "the owner has ended";
  if (!reached) GTEST_SKIP() << "the system gave an id far away";
}

// A locked temporary file is kept even if no process has its id, as with owners in other containers.
TEST(File, LockedTemporaryIsKept) {
  const fs::path folder = fresh_folder(), file = folder / "a.txt";
  const pid_t ended = waiting_child();
  end_child(ended);
  const fs::path other = folder / (".a.txt.partial-" + std::to_string(ended) + "-0");
  Unfinished held(file);
  write(held.path(), "half");
  held.hold();
  fs::rename(held.path(), other);
  EXPECT_TRUE(leftovers_beside(file, "partial").empty());
  EXPECT_TRUE(leftovers_in(folder).empty());
  { const Unfinished ends(std::move(held)); }
  EXPECT_EQ(leftovers_beside(file, "partial"), std::vector<fs::path>{other});
  EXPECT_EQ(leftovers_in(folder), std::vector<fs::path>{other});
}

// Files of the kernel look like plain ones and are refused, because reading some of them never ends.
TEST(File, KernelFilesAreRefused) {
  EXPECT_REFUSED(read_file("/proc/kmsg"), "/proc/kmsg: is a file of the kernel");
  EXPECT_REFUSED(read_file("/proc/self/status"), "expected a file on a disk");
}

// Two writers of one file do not mix their contents; the later commit wins.
TEST(File, ConcurrentWritersAreIndependent) {
  const fs::path folder = fresh_folder(), file = folder / "a.txt";
  Result<FileWriter> one = FileWriter::create(file), two = FileWriter::create(file);
  ASSERT_TRUE(one && two);
  one->write("one"), two->write("two");
  ASSERT_TRUE(one->commit());
  EXPECT_EQ(bytes_of(file), "one");
  ASSERT_TRUE(two->commit());
  EXPECT_EQ(bytes_of(file), "two");
  EXPECT_EQ(names_in(folder), std::set<std::string>{"a.txt"});
}

}  // namespace
}  // namespace turgor
