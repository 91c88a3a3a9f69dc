#include "turgor/pictures/run_autosave.hpp"

#include <csignal>
#include <fstream>
#include <functional>

#include <sys/wait.h>
#include <unistd.h>

#include "tests/sim/four_kinds.hpp"
#include "turgor/io/files/hdf5_file.hpp"
#include "turgor/pictures/run_scene.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;

constexpr double kEveryFrame = 1e-9;  // interval of autosaves [s]

Scene resumed_scene(const fs::path& folder) {
  return test::four_kinds_scene(folder, {"output.vtkhdf=true", "output.usd=true", "output.gltf=true",
                                         "output.snapshots={ every = 0.06, size = [64, 64] }"});
}

/// Runs in another process, which SIGKILL ends in this frame, after the autosave of the frame before it.
void run_killed(const Scene& scene, const fs::path& out, int frame, bool resume = false) {
  const pid_t child = fork();
  if (child == 0) {
    RunCallbacks callbacks;
    callbacks.frame = [frame](const World& world) { return world.frame < frame || raise(SIGKILL) != 0; };
    (void)run_scene(Exec(2), scene, {.out = out, .autosave_interval = kEveryFrame, .resume = resume},
                    callbacks);
    _exit(1);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL) << status;
}

std::vector<fs::path> hidden_in(const fs::path& folder) {
  std::vector<fs::path> found;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().filename().string().starts_with(".")) found.push_back(entry.path());
  return found;
}

/// Sentence of a resumed run that fails, in another process; nothing remains of its results.
std::string error_of_resume(const Scene& scene, const fs::path& out) {
  const fs::path answer = out.string() + ".txt";
  const pid_t child = fork();
  if (child == 0) {
    const Result<Json> report = run_scene(Exec(1), scene, {.out = out, .resume = true});
    std::ofstream(answer) << (report ? "the run was resumed" : report.error().message);
    _exit(0);
  }
  waitpid(child, nullptr, 0);
  EXPECT_FALSE(fs::exists(out));
  return test::bytes_of(answer);
}

/// Values of a dataset, whatever its type.
std::string values_of(const Hdf5File& file, const std::string& name) {
  const std::size_t count = file.count(name, std::size_t(1) << 30).value();
  std::string bytes;
  const auto add = [&](const auto& values) {
    if (values)
      bytes.assign(reinterpret_cast<const char*>(values->data()), values->size() * sizeof((*values)[0]));
    return bool(values);
  };
  if (add(file.read<float>(name, count)) || add(file.read<double>(name, count)) ||
      add(file.read<std::int32_t>(name, count)) || add(file.read<std::int64_t>(name, count)) ||
      add(file.read<std::uint64_t>(name, count)) || add(file.read<std::uint8_t>(name, count)))
    return bytes;
  return file.read_text(name).value();
}

/// Sets the wall times of recorded ticks to 0.
std::string without_times(std::string ticks) {
  constexpr std::size_t kRow = 27, kTickSeconds = 13;  // numbers of a tick, and the index of its wall time
  for (std::size_t at = kTickSeconds; at * 8 < ticks.size(); at += kRow) std::fill_n(&ticks[at * 8], 8, '\0');
  return ticks;
}

void expect_same_hdf5(const fs::path& a, const fs::path& b) {
  const Result<Hdf5File> one = Hdf5File::open(a), other = Hdf5File::open(b);
  ASSERT_TRUE(one && other) << a;
  ASSERT_EQ(one->datasets(), other->datasets());
  EXPECT_GT(one->datasets().size(), 5u);
  for (const std::string& name : one->datasets()) {
    if (name == "/report") continue;  // has wall times
    const bool is_log = name.ends_with("/ticks");
    const std::string in_one = values_of(*one, name), in_other = values_of(*other, name);
    EXPECT_TRUE(is_log ? without_times(in_one) == without_times(in_other) : in_one == in_other) << a << name;
  }
}

/// The report without wall times, and without the capacity of arrays, which memory_bytes counts.
Json without_wall_times(Json report) {
  for (const char* key : {"timing", "machine"}) report.erase(key);
  const auto is_wall_time = [](const std::string& key) {
    return key.starts_with("memory_bytes") || key == "patch_seconds" || key.find("p50") != key.npos ||
           key.find("p99") != key.npos || key == "tick_max_us" || key == "build_s" || key == "read_s" ||
           key.ends_with("_seconds") || key == "seconds" || key == "patch" || key == "green" ||
           key == "shape_s" || key == "deformed_ct" || key.find("surface_ms") != key.npos ||
           key.find("frame_ms") != key.npos || key.find("step_m") != key.npos;
  };
  const std::function<void(Json&)> clean = [&](Json& json) {
    if (json.is_object())
      for (auto entry = json.begin(); entry != json.end();)
        entry = is_wall_time(entry.key()) ? json.erase(entry) : (clean(*entry), std::next(entry));
    else if (json.is_array())
      for (Json& one : json) clean(one);
  };
  clean(report);
  for (Json& body : report["bodies"])
    if (body.contains("series") && body["series_columns"][1] == "step_ms")
      for (Json& row : body["series"]) row[1] = 0;
  return report;
}

// A run that is killed twice, while a blade cuts, and resumed on another number of threads ends with the bits
// of an unbroken run: state, report, recording, meshes and pictures.
TEST(RunAutosave, ResumedRunHasSameBits) {
  const fs::path folder = test::fresh_folder();
  const Scene scene = resumed_scene(folder);
  run_killed(scene, folder / "broken", 5);
  ASSERT_EQ(hidden_in(folder).size(), 2u) << "the autosave, and the unfinished results";
  run_killed(scene, folder / "broken", 9, true);
  std::vector<std::string> notes;
  RunCallbacks callbacks;
  callbacks.note = [&](const std::string& sentence) { notes.push_back(sentence); };
  const Result<Json> broken =
      run_scene(Exec(1), scene, {.out = folder / "broken", .resume = true}, callbacks);
  ASSERT_TRUE(broken) << broken.error().message;
  ASSERT_FALSE(notes.empty());
  EXPECT_EQ(notes[0], "resuming at 0.160 s of 0.3 s");
  EXPECT_TRUE(hidden_in(folder).empty()) << "a complete run leaves no autosave";

  const Result<Json> whole = run_scene(Exec(2), scene, {.out = folder / "whole"});
  ASSERT_TRUE(whole) << whole.error().message;
  EXPECT_EQ((*broken)["state_hash"], (*whole)["state_hash"]);
  const Json one = without_wall_times(*broken), other = without_wall_times(*whole);
  EXPECT_EQ(one, other) << Json::diff(one, other).dump(1);
  EXPECT_GT((*broken)["timing"]["resumed_after_s"].get<double>(), 0);
  EXPECT_FALSE((*whole)["timing"].contains("resumed_after_s"));
  int compared = 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder / "whole")) {
    const fs::path name = entry.path().lexically_relative(folder / "whole");
    const std::string ending = name.extension().string();
    if (ending == ".h5" || ending == ".vtkhdf") expect_same_hdf5(entry.path(), folder / "broken" / name);
    const bool same_bytes = ending == ".vtu" || ending == ".obj" || ending == ".png" || ending == ".pvd" ||
                            ending == ".usda" || ending == ".glb";
    if (!same_bytes) continue;
    EXPECT_EQ(test::bytes_of(entry.path()), test::bytes_of(folder / "broken" / name)) << name;
    compared++;
  }
  EXPECT_GT(compared, 20);
}

// The same for a finger that drags over an organ, which turns its elements, builds patches as it moves and
// computes Green's functions on demand, and for cloth of second order with implicit contacts.
TEST(RunAutosave, PatchesAndHistoryAreResumed) {
  const fs::path folder = test::fresh_folder();
  const Scene scene = test::four_kinds_scene(
      folder,
      {"tool.finger.press=", "tool.finger.path=[[0, 0.012, 0.03, 0.034], [0.3, 0.05, 0.03, 0.034]]",
       "body.pad.patch={ radius = 0.008, refinement = 2 }", "body.pad.memory=0.001",
       "body.pad.rotations=true", "body.pad.viscosity={ ratio = 0.5, time = 0.1 }",
       "body.sheet.fabric.law=sheet", "body.sheet.solver={ method = 'two_level', integrator = 'bdf2' }",
       "body.sheet.collision.self=true"});
  run_killed(scene, folder / "broken", 10);
  const Result<Json> broken = run_scene(Exec(1), scene, {.out = folder / "broken", .resume = true}),
                     whole = run_scene(Exec(2), scene, {.out = folder / "whole"});
  ASSERT_TRUE(broken && whole) << (broken ? whole : broken).error().message;
  EXPECT_TRUE(bodies_of(*whole, BodyKind::kSfem)[0]["green"]["on_demand"].get<bool>());
  EXPECT_GT(bodies_of(*whole, BodyKind::kSfem)[0]["patch"]["rebuilds"].get<int>(), 1);
  const Json one = without_wall_times(*broken), other = without_wall_times(*whole);
  EXPECT_EQ(one, other) << Json::diff(one, other).dump(1);
  expect_same_hdf5(folder / "whole/recording.h5", folder / "broken/recording.h5");
}

// Without an autosave a resumed run starts at the beginning; a run without --resume leaves an autosave until
// it is complete.
TEST(RunAutosave, RunWithoutResumeStartsAgain) {
  const fs::path folder = test::fresh_folder();
  const Scene scene = resumed_scene(folder);
  run_killed(scene, folder / "out", 3);
  std::vector<std::string> notes;
  RunCallbacks callbacks;
  callbacks.note = [&](const std::string& sentence) { notes.push_back(sentence); };
  const Result<Json> report = run_scene(Exec(2), scene, {.out = folder / "out"}, callbacks);
  ASSERT_TRUE(report) << report.error().message;
  ASSERT_FALSE(notes.empty());
  EXPECT_NE(notes[0].find("an earlier run was interrupted; --resume goes on"), std::string::npos);
  EXPECT_TRUE(hidden_in(folder).empty());
  EXPECT_FALSE((*report)["timing"].contains("resumed_after_s"));
  notes.clear();
  ASSERT_TRUE(run_scene(Exec(2), scene, {.out = folder / "out", .resume = true}, callbacks));
  EXPECT_NE(notes.at(0).find("starting at the beginning"), std::string::npos);
}

// An autosave that is damaged, cut short, incomplete, of another scene or of other inputs gives one sentence.
TEST(RunAutosave, RefusesUnfitAutosave) {
  const fs::path folder = test::fresh_folder(), out = folder / "out";
  const Scene scene = resumed_scene(folder);
  run_killed(scene, out, 4);
  const auto state = [&] {
    for (const fs::path& hidden : hidden_in(folder))
      if (fs::exists(hidden / "state")) return hidden / "state";
    return fs::path();
  };
  const std::string sound = test::bytes_of(state());
  ASSERT_GT(sound.size(), 1000u);
  const auto write = [&](const std::string& bytes) { std::ofstream(state(), std::ios::binary) << bytes; };
  // the state
  for (const std::size_t at : {std::size_t(40), sound.size() / 2, sound.size() - 1}) {
    std::string damaged = sound;
    damaged[at] = char(damaged[at] ^ 1);
    write(damaged);
    EXPECT_NE(error_of_resume(scene, out).find("the autosave is damaged"), std::string::npos) << at;
  }
  for (const std::size_t length : {std::size_t(20), sound.size() / 2}) {
    write(sound.substr(0, length));
    EXPECT_NE(error_of_resume(scene, out).find("the autosave is damaged"), std::string::npos) << length;
  }
  write("solid cube");
  EXPECT_NE(error_of_resume(scene, out).find("expected an autosave of turgor run"), std::string::npos);
  write(sound);
  // another scene, and other inputs
  const Scene other = test::four_kinds_scene(folder, {"tool.ball.press.depth=0.007"});
  EXPECT_NE(error_of_resume(other, out).find("of another scene"), std::string::npos);
  const std::string ct = test::bytes_of(folder / "block.nii");
  std::string changed = ct;
  changed[changed.size() / 2] = char(changed[changed.size() / 2] ^ 3);
  std::ofstream(folder / "block.nii", std::ios::binary) << changed;
  EXPECT_NE(error_of_resume(scene, out).find("inputs of the scene have changed"), std::string::npos);
  std::ofstream(folder / "block.nii", std::ios::binary) << ct;
  // a kept file
  fs::remove_all(state().parent_path() / "growing-3");
  EXPECT_NE(error_of_resume(scene, out).find("the autosave is damaged: expected a file"), std::string::npos);
}

}  // namespace
}  // namespace turgor
