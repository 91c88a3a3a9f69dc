#include "turgor/pictures/run_scene.hpp"

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fstream>

#include <sys/wait.h>
#include <unistd.h>

#include "tests/sim/four_kinds.hpp"
#include "turgor/io/files/hdf5_file.hpp"
#include "turgor/io/files/image.hpp"
#include "turgor/pictures/motion.hpp"
#include "turgor/view/drawing_process.hpp"
#include "turgor/view/video.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;

Json must_run(const Scene& scene, const fs::path& out, const RunCallbacks& callbacks = {}) {
  Result<Json> report = run_scene(Exec(2), scene, {.out = out}, callbacks);
  EXPECT_TRUE(report) << report.error().message;
  return report ? *report : Json();
}

/// The physics of a report: without wall times, values that only snapshots sample (and the verdict made of
/// them), the text of the scene, and pictures.
Json physics(Json report) {
  for (const char* key : {"timing", "machine", "pictures", "more_pictures", "files", "solver", "scene",
                          "warnings", "verdict", "parameters", "scene_text", "deformed_ct"})
    report.erase(key);
  const auto is_time = [](const std::string& key) {
    return key.ends_with("_s") && key != "force_max_at_s" && key != "slipped_at_s" &&
           key != "passed_surface_at_s" && key != "jump_at_s" && key != "simulated_s";
  };
  for (const char* list : {"bodies", "costs", "tools"})
    for (Json& one : report[list]) {
      std::vector<std::string> wall;
      for (const auto& [key, value] : one.items())
        if (is_time(key) || key.find("p50") != key.npos || key.find("p99") != key.npos ||
            key == "tick_max_us" || key == "patch" || key == "green" || key == "snapshots" ||
            key == "largest_residual_relative" || (list == std::string("bodies") && key == "series"))
          wall.push_back(key);
      for (const std::string& key : wall) one.erase(key);
    }
  return report;
}

/// Duration of a video [s]. Needs ffprobe, which is part of ffmpeg.
double video_seconds(const fs::path& file) {
  const std::string command =
      "ffprobe -v error -show_entries format=duration -of csv=p=0 '" + file.string() + "'";
  FILE* pipe = popen(command.c_str(), "r");
  double seconds = 0;
  EXPECT_EQ(pipe ? std::fscanf(pipe, "%lf", &seconds) : 0, 1) << file;
  if (pipe) pclose(pipe);
  return seconds;
}

// The rate of snapshots does not change state or measures.
TEST(RunScene, SnapshotRateKeepsMeasures) {
  const fs::path folder = test::fresh_folder();
  const Json seldom = must_run(
      test::four_kinds_scene(folder, {"output.snapshots.every=10", "output.video=false",
                                      "output.meshes=false", "output.recording=false", "output.obj=false"}),
      folder / "seldom");
  const Json often = must_run(
      test::four_kinds_scene(folder, {"output.snapshots.every=0.04", "output.video=true"}), folder / "often");
  EXPECT_EQ(often["state_hash"], seldom["state_hash"]);
  EXPECT_EQ(physics(often), physics(seldom));
  EXPECT_GT(seldom["wounds"][0]["gape_max_mm"].get<double>(), 0.1);
  EXPECT_EQ(bodies_of(seldom, BodyKind::kRhombus)[0]["pressed_volume_ml"],
            bodies_of(often, BodyKind::kRhombus)[0]["pressed_volume_ml"]);
  EXPECT_GT(often["pictures"].size(), 3u);
}

// A replay writes the same pictures, meshes and force tables.
TEST(RunScene, ReplayDrawsSameFiles) {
  const fs::path folder = test::fresh_folder();
  const Scene scene = test::four_kinds_scene(folder, {"output.frames=true"});
  const Json ran = must_run(scene, folder / "ran");
  const Result<Json> again =
      replay_recording(Exec(2), folder / "ran/recording.h5", {}, {.out = folder / "again"});
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_EQ((*again)["state_hash"], ran["state_hash"]);
  EXPECT_EQ((*again)["pictures"], ran["pictures"]);
  EXPECT_EQ((*again)["warnings"], ran["warnings"]);
  EXPECT_FALSE(ran["warnings"].empty());
  int compared = 0;
  for (const char* sub : {".", "frames", "meshes"})
    for (const std::string& name : test::names_in(folder / "ran" / sub)) {
      const bool drawn = name.ends_with(".png") || name.ends_with(".vtu") || name.ends_with(".obj");
      if (!drawn && name != "forces.csv") continue;
      EXPECT_EQ(test::bytes_of(folder / "ran" / sub / name), test::bytes_of(folder / "again" / sub / name))
          << sub << "/" << name;
      compared++;
    }
  EXPECT_GT(compared, 25);
}

// A picture of a tool beside a wound shows its walls in their own color, also in a replay.
TEST(RunScene, PictureOfToolShowsWalls) {
  const fs::path folder = test::fresh_folder();
  const Scene scene = test::block_scene(
      folder,
      {"tool.tip={ body = 'block', shape = { sphere = 0.005 }, press = { at_fraction = [0.66, 0, 0.5], "
       "depth = 0.003, start = 0.2, duration = 0.1, hold = 0.05 } }",
       "world.duration=0.4", "output.video=false", "output.snapshots.size=[160, 120]"});
  must_run(scene, folder / "ran");
  const Result<Json> again =
      replay_recording(Exec(2), folder / "ran/recording.h5", {}, {.out = folder / "again"});
  ASSERT_TRUE(again) << again.error().message;
  for (const char* run : {"ran", "again"}) {
    const Result<Image> picture = read_png(folder / run / "block-near.png");
    ASSERT_TRUE(picture) << picture.error().message;
    int red = 0;
    for (const Rgb p : picture->pixels) red += p.r > 50 && p.r > 2 * p.g && p.r > 2 * p.b;
    EXPECT_GT(red, 100) << run;
  }
}

/// Times of the steps in a VTKHDF file.
std::vector<double> times_of(const fs::path& vtkhdf) {
  const Result<Hdf5File> file = Hdf5File::open(vtkhdf);
  EXPECT_TRUE(file) << (file ? "" : file.error().message);
  const std::vector<std::int64_t> steps = file->read_numbers("/VTKHDF/Steps", "NSteps");
  EXPECT_EQ(steps.size(), 1u);
  return file->read<double>("/VTKHDF/Steps/Values", std::size_t(steps.at(0))).value();
}

// One VTKHDF file per body holds all time steps and can replace the VTU files.
TEST(RunScene, VtkHdfReplacesVtuFiles) {
  const fs::path folder = test::fresh_folder(), out = folder / "ran";
  must_run(test::four_kinds_scene(folder, {"output.video=false", "output.vtkhdf=true",
                                           "output.snapshots={ every = 0.1, size = [64, 64] }"}),
           out);
  for (const char* name : {"pad", "liver", "block", "sheet", "tools/finger", "forces/on-tools"}) {
    const std::vector<double> times = times_of(out / "meshes" / (std::string(name) + ".vtkhdf"));
    ASSERT_EQ(times.size(), 4u) << name;
    EXPECT_NEAR(times[2], 0.2, 1e-9);
  }
  const Result<Json> again =
      replay_recording(Exec(2), out / "recording.h5", {"output.meshes=false"}, {.out = folder / "again"});
  ASSERT_TRUE(again) << again.error().message;
  for (const std::string& name : test::names_in(folder / "again" / "meshes"))
    EXPECT_FALSE(name.ends_with(".vtu")) << name;
  EXPECT_FALSE(fs::exists(folder / "again" / "meshes.pvd"));
  EXPECT_EQ(times_of(folder / "again/meshes/block.vtkhdf").size(), 4u);
  if (std::system("python3 -c 'import vtk; vtk.vtkHDFReader().GetNumberOfSteps()' >/dev/null 2>&1") != 0) {
    std::printf("no VTK 9.3 for python3: it has not read them\n");
    return;
  }
  const std::string read = "python3 '" TURGOR_SOURCE_DIR "/tests/pictures/read_vtkhdf.py' '";
  EXPECT_EQ(std::system((read + (out / "meshes").string() + "'").c_str()), 0);
}

// Pictures that the 3D view of the page replaces are drawn on request, also by a replay.
TEST(RunScene, MorePicturesOnRequest) {
  if (!has_motion_view()) GTEST_SKIP() << "three.js is not installed: all pictures are drawn";
  const fs::path folder = test::fresh_folder();
  const Scene scene = test::four_kinds_scene(folder, {"output.snapshots.every=0.1"});
  const Json main = must_run(scene, folder / "main");
  ASSERT_TRUE(replay_recording(Exec(2), folder / "main/recording.h5", {"output.pictures=all"},
                               {.out = folder / "all"}));
  const Json all = Json::parse(test::bytes_of(folder / "all/report.json"));
  const char* main_name = "cut-before-after.png";
  EXPECT_EQ(test::bytes_of(folder / "main" / main_name), test::bytes_of(folder / "all" / main_name));
  for (const char* name :
       {"skin-before-after.png", "cut-colored.png", "cut-across.png", "cut-sections-after.png"}) {
    EXPECT_FALSE(fs::exists(folder / "main" / name)) << name;
    EXPECT_TRUE(fs::exists(folder / "all" / name)) << name;
  }
  const std::string how = main.at("more_pictures").get<std::string>();
  EXPECT_EQ(how, "turgor run --replay recording.h5 --set output.pictures=all");
  EXPECT_NE(test::bytes_of(folder / "main/report.html").find(how), std::string::npos);
  EXPECT_EQ(all.at("more_pictures"), "");
}

// The video lasts as long as the run, also in a replay.
TEST(RunScene, VideoHasRunDuration) {
  if (!has_ffmpeg()) GTEST_SKIP() << "ffmpeg is not installed";
  const fs::path folder = test::fresh_folder();
  const Scene scene = test::four_kinds_scene(folder, {"output.video=true", "output.snapshots.every=0.1"});
  must_run(scene, folder / "ran");
  const Result<Json> again =
      replay_recording(Exec(2), folder / "ran/recording.h5", {}, {.out = folder / "again"});
  ASSERT_TRUE(again) << again.error().message;
  // 50 frames per second, a picture every third: 60 ms each, except where a snapshot already exists.
  EXPECT_NEAR(video_seconds(folder / "ran/video.mp4"), 0.3, 0.08);
  EXPECT_NEAR(video_seconds(folder / "again/video.mp4"), 0.4, 0.05)
      << "four snapshots, a tenth of a second each";
  const Result<Json> slow =
      replay_recording(Exec(2), folder / "ran/recording.h5",
                       {"output.video_speed=0.5", "output.video_quality=full"}, {.out = folder / "slow"});
  ASSERT_TRUE(slow) << slow.error().message;
  EXPECT_NEAR(video_seconds(folder / "slow/video.mp4"), 0.8, 0.1);
}

// Each wound has a close-up video.
TEST(RunScene, EachWoundHasCloseUpVideo) {
  if (!has_ffmpeg()) GTEST_SKIP() << "ffmpeg is not installed";
  const fs::path folder = test::fresh_folder();
  EXPECT_TRUE(write_ct(folder / "block.nii", test::block_ct()));
  const std::string text = test::four_kinds_text() + "video = true\n[incision.second]\nbody = \"block\"\n" +
                           "from = [-0.04, -0.02, -0.02]\nto = [-0.04, -0.02, 0.02]\ndepth = 0.012\n";
  const Scene scene = parse_scene(text, folder / "four.toml", {}).value();
  const Json report = must_run(scene, folder / "out");
  for (const char* name : {"video-cut.mp4", "video-second.mp4"}) {
    EXPECT_GT(video_seconds(folder / "out" / name), 0.2);
    EXPECT_NE(test::bytes_of(folder / "out/report.html").find(name), std::string::npos);
    EXPECT_EQ(std::count(report["files"].begin(), report["files"].end(), name), 1);
  }
  EXPECT_NE(test::bytes_of(folder / "out/video-cut.mp4"), test::bytes_of(folder / "out/video-second.mp4"));
  EXPECT_FALSE(fs::exists(folder / "out/video.mp4"));
  EXPECT_FALSE(fs::exists(folder / "out/.video"));
}

// A camera of the scene adds its own pictures.
TEST(RunScene, SceneCameraAddsPictures) {
  const fs::path folder = test::fresh_folder();
  const Scene scene =
      test::four_kinds_scene(folder, {"camera.side.from=[0.3, 0.03, 0.1]", "camera.side.at=[0.03, 0.03, 0]",
                                      "camera.side.angle=20", "output.frames=true"});
  ASSERT_EQ(scene.cameras.size(), 1u);
  const Json report = must_run(scene, folder / "out");
  EXPECT_TRUE(fs::exists(folder / "out/frames/side-0000.png"));
  EXPECT_TRUE(fs::exists(folder / "out/side-before-after.png"));
}

// The timing separates physics, drawing and files.
TEST(RunScene, TimingSeparatesPhases) {
  const fs::path folder = test::fresh_folder();
  const Json timing =
      must_run(test::four_kinds_scene(folder, {"output.video=false"}), folder / "out")["timing"];
  const auto seconds = [&](const char* key) { return timing.at(key).get<double>(); };
  for (const char* key : {"physics_s", "drawing_s", "files_s"}) EXPECT_GT(seconds(key), 0) << key;
  EXPECT_LE(seconds("physics_s"), seconds("simulation_s"));
  EXPECT_LT(seconds("physics_s") + seconds("drawing_s") + seconds("files_s"), seconds("total_s"));
}

// Callbacks receive progress, frames and snapshots and can stop the run.
TEST(RunScene, CallbacksReportAndStop) {
  const fs::path folder = test::fresh_folder();
  std::vector<int> frames, snapshots;
  std::vector<std::string> labels;
  RunCallbacks callbacks;
  callbacks.begin = [&](const std::string& label, const std::string&) {
    labels.push_back(label);
    return Progress();
  };
  callbacks.frame = [&](const World& now) { return frames.push_back(now.frame), now.frame < 7; };
  callbacks.snapshot = [&](const WorldSnapshot& snapshot) -> Status {
    EXPECT_EQ(snapshot.bodies.size(), 5u);
    return snapshots.push_back(snapshot.frame), Done{};
  };
  const Scene scene = test::four_kinds_scene(folder, {"output.video=false"});
  const Json report = must_run(scene, folder / "out", callbacks);
  EXPECT_EQ(frames.size(), 7u);
  EXPECT_EQ(snapshots, (std::vector<int>{0, 5, 7}));
  ASSERT_GE(labels.size(), 2u);
  EXPECT_EQ(labels[labels.size() - 2], "simulating");
  EXPECT_EQ(labels.back(), "drawing");
  EXPECT_EQ(report["stopped"], "stopped after 0.140 s of 0.3 s, on request");
  EXPECT_EQ(report["finite"], true);
  EXPECT_TRUE(fs::exists(folder / "out/report.html"));
}

// Forceps are drawn with their current opening, also in a replay.
TEST(RunScene, ForcepsJawsAreDrawn) {
  const fs::path folder = test::fresh_folder();
  const Result<Scene> scene = parse_scene(
      "[world]\nduration = 0.4\nframe_rate = 50\n[body.liver]\nmodel = \"rhombus\"\n"
      "surface = { phantom = \"liver\", detail = 0.3 }\n[tool.forceps]\nbody = \"liver\"\n"
      "shape = { forceps = \"phantom\" }\n"
      "grasp = { at_fraction = [0.3, 0.5, 1], depth = 0.004, pull = 0.006, start = 0, duration = 0.1 }\n"
      "[camera.aside]\nfrom = [0.5, 0, 0]\nat = [0, 0, 0]\n"
      "[output]\nsnapshots = { every = 0.2, size = [160, 120] }\n",
      folder / "forceps.toml");
  ASSERT_TRUE(scene) << scene.error().message;
  std::set<double> openings;
  RunCallbacks callbacks;
  callbacks.snapshot = [&](const WorldSnapshot& snapshot) -> Status {
    openings.insert(snapshot.tools[0].opening);
    EXPECT_TRUE(snapshot.tools[0].has_jaws);
    return Done{};
  };
  const Json ran = must_run(*scene, folder / "ran", callbacks);
  EXPECT_GT(openings.size(), 1u) << "the jaws close";
  ASSERT_TRUE(replay_recording(Exec(2), folder / "ran/recording.h5", {"output.frames=true"},
                               {.out = folder / "again"}));
  EXPECT_FALSE(fs::exists(folder / "ran/frames")) << "frames were not requested";
  EXPECT_EQ(test::names_in(folder / "again/frames").size(), 6u) << "three snapshots from two cameras";
  EXPECT_FALSE(fs::exists(folder / "ran/body-before-after.png")) << "at the end the tools are retracted";
  for (const char* name : {"liver-near.png", "liver-displacement.png", "aside-before-after.png"})
    EXPECT_EQ(test::bytes_of(folder / "ran" / name), test::bytes_of(folder / "again" / name)) << name;
  EXPECT_FALSE(fs::exists(folder / "ran/liver-pressure.png")) << "this model has no pressure";
}

// A run that fails leaves no files.
TEST(RunScene, ErrorLeavesNoFiles) {
  const fs::path folder = test::fresh_folder();
  RunCallbacks callbacks;
  callbacks.snapshot = [](const WorldSnapshot& snapshot) -> Status {
    return snapshot.frame < 5 ? Status(Done{}) : Status(Error{"the disk is full"});
  };
  const Scene scene = test::four_kinds_scene(folder, {"output.video=false"});
  const Result<Json> report = run_scene(Exec(2), scene, {.out = folder / "out"}, callbacks);
  ASSERT_FALSE(report);
  EXPECT_EQ(report.error().message, "the disk is full");
  EXPECT_EQ(test::names_in(folder), std::set<std::string>{"block.nii"});
}

// A program that is killed while it draws has lost only pictures: report, recording, tables and meshes are
// complete in the folder, which the next run replaces without --force.
TEST(RunScene, KilledWhileDrawingKeepsResults) {
  const fs::path folder = test::fresh_folder();
  const Scene scene = test::four_kinds_scene(folder, {"output.frames=true"});
  const pid_t killed = fork();
  ASSERT_GE(killed, 0);
  if (killed == 0) {
    RunCallbacks killer;
    killer.begin = [](const std::string& label, const std::string&) -> Progress {
      if (label == "drawing") _exit(9);
      return {};
    };
    (void)run_scene(Exec(1), scene, {.out = folder / "out"}, killer);
    _exit(1);
  }
  int ended = 0;
  ASSERT_EQ(waitpid(killed, &ended, 0), killed);
  ASSERT_TRUE(WIFEXITED(ended) && WEXITSTATUS(ended) == 9) << "the run does not reach its drawing";
  for (const char* name : {"report.html", "recording.h5", "forces.csv", "meshes.pvd"})
    EXPECT_TRUE(fs::exists(folder / "out" / name)) << name;
  std::ifstream file(folder / "out" / "report.json");
  const Json report = Json::parse(file, nullptr, false);
  ASSERT_TRUE(report.is_object());
  EXPECT_GT(report["tools"].size(), 0u);
  EXPECT_NE(report["warnings"].dump().find("no pictures: the program ended while it drew them"),
            std::string::npos);
  const Json again = must_run(scene, folder / "out");
  EXPECT_GT(again["pictures"].size(), 3u);
  EXPECT_EQ(again["warnings"].dump().find("no pictures: "), std::string::npos);
  for (const auto& entry : fs::directory_iterator(folder))
    EXPECT_EQ(entry.path().filename().string().find(".partial"), std::string::npos) << entry.path();
}

/// This test program draws for its parent if that asks for it.
constexpr const char* kServesRun = "TURGOR_TEST_SERVES_DRAWINGS_OF_RUN";
const bool is_run_parent = [] {
  if (std::getenv(kServesRun)) _exit(serve_drawings());
  return true;
}();

// A drawing process that is killed during a run costs pictures and nothing else: every state is in the
// recording before it is drawn.
TEST(RunScene, KilledDrawingCostsOnlyPictures) {
  ASSERT_TRUE(is_run_parent);
  const fs::path folder = test::fresh_folder(), number = folder / "pid";
  const Scene scene = test::four_kinds_scene(folder, {"output.frames=true", "output.snapshots.every=0.1"});
  // a process that states its number and then draws
  const std::string program = fs::read_symlink("/proc/self/exe").string();
  setenv(kServesRun, "1", 1);
  set_drawing_program(
      {.arguments = {"/bin/sh", "-c", "echo $$ > '" + number.string() + "'; exec '" + program + "'"}});
  int snapshots = 0;
  RunCallbacks killer;
  killer.snapshot = [&](const WorldSnapshot&) -> Status {
    pid_t drawing = 0;
    if (snapshots++ == 1 && std::ifstream(number) >> drawing) kill(drawing, SIGKILL);
    return Done{};
  };
  const Json report = must_run(scene, folder / "killed", killer);
  unsetenv(kServesRun);
  set_drawing_program({});
  const Json whole = must_run(scene, folder / "whole");
  if (whole["warnings"].dump().find("cannot draw") != std::string::npos) GTEST_SKIP() << "no OpenGL";
  EXPECT_NE(report["warnings"].dump().find("no pictures of surfaces: cannot draw"), std::string::npos)
      << report["warnings"];
  EXPECT_EQ(report["state_hash"], whole["state_hash"]);
  EXPECT_EQ(physics(report), physics(whole));
  const std::size_t drawn = test::names_in(folder / "killed/frames").size();
  EXPECT_GT(drawn, 0u);
  EXPECT_LT(drawn, test::names_in(folder / "whole/frames").size());
  // the recording is complete, and a replay draws what is missing
  const Result<Json> again =
      replay_recording(Exec(2), folder / "killed/recording.h5", {}, {.out = folder / "again"});
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_EQ(test::names_in(folder / "again/frames"), test::names_in(folder / "whole/frames"));
}

}  // namespace
}  // namespace turgor
