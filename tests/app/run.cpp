#include <algorithm>
#include <csignal>
#include <sstream>
#include <vector>

#include "tests/app/program.hpp"

namespace turgor {
namespace {

using nlohmann::json;
using namespace test;

// A run writes pictures, meshes, the deformed CT, a recording and a report.
TEST(RunCommand, WritesAllOutputs) {
  const fs::path folder = fresh_folder();
  write(folder / "s.toml",
        small_scene("", "displacement = \"u.nrrd\"\njacobian = \"j.nrrd\"\nvolume_rendering = \"skin\"\n"));
  const Ended ended = run_program("run s.toml --out results/first", folder);
  ASSERT_EQ(ended.code, 0) << ended.printed;
  EXPECT_NE(ended.printed.find("  gape, largest                     "), std::string::npos) << ended.printed;
  const fs::path out = folder / "results" / "first";
  EXPECT_EQ(names_in(folder / "results"), std::set<std::string>{"first"});
  for (const char* name :
       {"report.json", "report.html", "recording.h5", "deformed.nii.gz", "u.nrrd", "j.nrrd", "torso.obj",
        "meshes.pvd", "meshes/torso-0000.vtu", "meshes/torso-0010.vtu", "torso-volume.png",
        "midline-across.png", "midline-sections-after.png"})
    EXPECT_TRUE(fs::exists(out / name)) << name;
  const json report = report_in(out);
  EXPECT_EQ(report["wounds"][0]["name"], "midline");
  EXPECT_GT(report["wounds"][0]["edges_cut"].get<int>(), 0);
  EXPECT_EQ(report["timing"]["frames"], 10);
  EXPECT_LT(std::abs(report["deformed_ct"][0]["mass_error"].get<double>()), 0.05);
  for (const json& picture : report["pictures"])
    EXPECT_TRUE(fs::exists(out / picture["file"].get<std::string>()));
}

// With --progress the run prints its ascending fraction; the mesh has groups for skin and wound.
TEST(RunCommand, ReportsProgressAndWoundGroups) {
  const fs::path folder = fresh_folder();
  write(folder / "s.toml", small_scene());
  const char* plain = " --set output.video=false --set output.volume_rendering=false";
  const Ended ended = run_program(std::string("run s.toml --progress --out out") + plain, folder);
  ASSERT_EQ(ended.code, 0) << ended.printed;
  std::vector<double> reported_fractions;
  std::istringstream lines(ended.printed);
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with("simulating ")) reported_fractions.push_back(std::stod(line.substr(11)));
  ASSERT_GT(reported_fractions.size(), 5u) << ended.printed;
  EXPECT_TRUE(std::is_sorted(reported_fractions.begin(), reported_fractions.end())) << ended.printed;
  EXPECT_LT(reported_fractions.front(), 0.2);
  EXPECT_EQ(reported_fractions.back(), 1);
  const std::string obj = bytes_of(folder / "out" / "torso.obj");
  const std::size_t skin = obj.find("\ng skin\n"), wound = obj.find("\ng wound\n");
  ASSERT_NE(skin, std::string::npos);
  ASSERT_NE(wound, std::string::npos);
  EXPECT_LT(skin, wound);
  EXPECT_EQ(run_program(std::string("run s.toml -q --out out") + plain, folder).printed.find("simulating"),
            std::string::npos);
}

// A folder name for the deformed CT yields a DICOM series of the same patient.
TEST(RunCommand, WritesDeformedCtAsDicom) {
  const fs::path folder = fresh_folder();
  ASSERT_EQ(run_program("phantom torso --size 64 48 40 --spacing 6.5 6.5 6.5 -o ct", folder).code, 0);
  std::string scene = small_scene();
  const std::string phantom =
      "ct = { phantom = \"torso\", size = [64, 48, 40], spacing_mm = [6.5, 6.5, 6.5] }";
  scene.replace(scene.find(phantom), phantom.size(), "ct = \"ct\"");
  write(folder / "s.toml", scene);
  const Ended ended = run_program("run s.toml -q --out out --set output.deformed_ct=deformed", folder);
  ASSERT_EQ(ended.code, 0) << ended.printed;
  EXPECT_EQ(names_in(folder / "out" / "deformed").size(), 40u);
  const Ended info = run_program("info out/deformed", folder);
  EXPECT_EQ(info.code, 0) << info.printed;
  for (const char* word : {"Phantom^torso", "64 x 48 x 40"})
    EXPECT_NE(info.printed.find(word), std::string::npos) << info.printed;
  for (const char* name : {"frames", "a/b", "deformed.png"})
    EXPECT_EQ(run_program(std::string("run s.toml --out o --set output.deformed_ct=") + name, folder).code,
              2);
}

// The state hash is equal on 1, 2 and 8 threads.
TEST(RunCommand, EqualStateHashOnAnyThreads) {
  const fs::path folder = fresh_folder();
  write(folder / "s.toml", small_scene());
  std::set<std::string> hashes;
  for (const char* threads : {"1", "2", "8"}) {
    const std::string out = std::string("out") + threads;
    const Ended ended = run_program(std::string("run s.toml -q --threads ") + threads + " --out " + out +
                                        " --set output.video=false --set output.volume_rendering=false",
                                    folder);
    ASSERT_EQ(ended.code, 0) << ended.printed;
    EXPECT_EQ(ended.printed, "");
    hashes.insert(report_in(folder / out)["state_hash"].get<std::string>());
  }
  EXPECT_EQ(hashes.size(), 1u);
}

// With --check the command reports the expected cost and writes no files.
TEST(RunCommand, CheckWritesNothing) {
  const fs::path folder = fresh_folder();
  write(folder / "s.toml", small_scene());
  const Ended ended = run_program("run s.toml --check", folder);
  EXPECT_EQ(ended.code, 0) << ended.printed;
  for (const char* word : {"s.toml: valid", "torso", "lattice", "loading", "memory", "simulating"})
    EXPECT_NE(ended.printed.find(word), std::string::npos) << word << " in " << ended.printed;
  EXPECT_FALSE(fs::exists(folder / "out"));
  const Ended wrong = run_program("run s.toml --check --set body.torso.skin.tension=-4", folder);
  EXPECT_EQ(wrong.code, 2);
  EXPECT_NE(wrong.printed.find("body.torso.skin.tension"), std::string::npos);
}

// Without ffmpeg the run continues and names the missing package.
TEST(RunCommand, ContinuesWithoutFfmpeg) {
  const fs::path folder = fresh_folder();
  write(folder / "s.toml", small_scene());
  const std::string path = getenv("PATH");
  setenv("PATH", "/nowhere", 1);
  const Ended ended =
      run_program("run s.toml --out out --set output.video=true --set output.volume_rendering=false", folder);
  setenv("PATH", path.c_str(), 1);
  ASSERT_EQ(ended.code, 0) << ended.printed;
  EXPECT_NE(ended.printed.find("no video: ffmpeg is not on the PATH (Debian: apt-get install ffmpeg)"),
            std::string::npos)
      << ended.printed;
  EXPECT_FALSE(fs::exists(folder / "out" / "video.mp4"));
}

// A replay draws the same pictures and rejects changes of keys outside of output.
TEST(RunCommand, ReplayDrawsEqualPictures) {
  const fs::path folder = fresh_folder();
  write(folder / "s.toml", small_scene());
  ASSERT_EQ(run_program("run s.toml --out first", folder).code, 0);
  const Ended ended = run_program("run --replay first/recording.h5 --out again", folder);
  ASSERT_EQ(ended.code, 0) << ended.printed;
  const json first = report_in(folder / "first"), again = report_in(folder / "again");
  EXPECT_EQ(first["wounds"], again["wounds"]);
  EXPECT_EQ(first["state_hash"], again["state_hash"]);
  int compared = 0;
  for (const json& picture : first["pictures"]) {
    const std::string name = picture["file"].get<std::string>();
    EXPECT_EQ(system(("cmp -s '" + (folder / "first" / name).string() + "' '" +
                      (folder / "again" / name).string() + "'")
                         .c_str()),
              0)
        << name;
    compared++;
  }
  EXPECT_GE(compared, 4);
  const Ended other =
      run_program("run --replay first/recording.h5 --out third --set body.torso.ct.seed=9", folder);
  EXPECT_EQ(other.code, 2);
  EXPECT_NE(other.printed.find("a replay may only change output.*"), std::string::npos) << other.printed;
}

/// Starts a long run, waits until it writes, and sends a signal; returns how it ended.
int signal_run(const fs::path& folder, int signal) {
  const pid_t child = fork();
  if (child == 0) {
    (void)!chdir(folder.c_str());
    (void)!freopen("/dev/null", "w", stderr);
    execl(TURGOR_PROGRAM, "turgor", "run", "s.toml", "-q", "--out", "out", "--set", "world.duration=300",
          nullptr);
    _exit(127);
  }
  for (int tries = 0; tries < 600; tries++) {
    usleep(50000);
    bool drawn = false;
    for (const std::string& name : names_in(folder))
      if (name.starts_with(".out.partial-")) drawn = fs::exists(folder / name / "recording.h5");
    if (drawn) break;
  }
  kill(child, signal);
  int status = 0;
  waitpid(child, &status, 0);
  return status;
}

// Interrupted and killed runs keep earlier results; the next run removes their partial folders.
TEST(RunCommand, StoppedRunsKeepEarlierResults) {
  const fs::path folder = fresh_folder();
  write(folder / "s.toml", small_scene("", "video = false\nvolume_rendering = false\n"));
  ASSERT_EQ(run_program("run s.toml -q --out out", folder).code, 0);
  const json first = report_in(folder / "out");
  const int interrupted = signal_run(folder, SIGINT);
  ASSERT_TRUE(WIFEXITED(interrupted));
  EXPECT_EQ(WEXITSTATUS(interrupted), 130);
  EXPECT_EQ(names_in(folder), (std::set<std::string>{"out", "s.toml"}));
  EXPECT_EQ(report_in(folder / "out"), first);
  const int killed = signal_run(folder, SIGKILL);
  ASSERT_TRUE(WIFSIGNALED(killed));
  EXPECT_EQ(report_in(folder / "out"), first);
  EXPECT_EQ(names_in(folder).size(), 3u);  // the hidden partial folder of the killed run remains
  ASSERT_EQ(run_program("run s.toml -q --out out --set world.duration=0.1", folder).code, 0);
  EXPECT_EQ(names_in(folder), (std::set<std::string>{"out", "s.toml"}));
  EXPECT_EQ(report_in(folder / "out")["timing"]["frames"], 5);
}

// One override replaces the phantom of a scene by a real CT.
TEST(RunCommand, RunsOnRealCt) {
  const fs::path ct = fs::path(TURGOR_SOURCE_DIR) / "../shared/data/ct/torso-3mm.nii.gz";
  if (!fs::exists(ct)) GTEST_SKIP() << "no real CT at " << ct;
  const fs::path folder = fresh_folder();
  const Ended ended = run_program(
      "run '" TURGOR_SOURCE_DIR "/scenes/incision.toml' --out out --set body.torso.ct='" + ct.string() +
          "' --set world.duration=0.5 --set body.torso.spacing=0.006 --set output.video=false",
      folder);
  ASSERT_EQ(ended.code, 0) << ended.printed;
  EXPECT_GT(report_in(folder / "out")["wounds"][0]["edges_cut"].get<int>(), 30);
}

}  // namespace
}  // namespace turgor
