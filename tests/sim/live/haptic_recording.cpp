// Haptic recordings are replayed without devices, without a clock and on other numbers of threads.
#include "turgor/sim/live/haptic_recording.hpp"

#include <chrono>
#include <fstream>

#include "tests/sim/four_kinds.hpp"
#include "tests/sim/live/replayed_world.hpp"
#include "tests/sim/live/watched_session.hpp"
#include "tests/sim/renamed_datasets.hpp"
#include "turgor/core/timing.hpp"
#include "turgor/sim/live/haptic_replay.hpp"
#include "turgor/sim/live/session.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;
using test::fresh_folder;
using test::kOneThread;
using test::wait_until;

/// All four models with rough surfaces, with a small patch that must follow its finger. The scene has no cut
/// and no touch before a request.
fs::path four_kinds_file(const fs::path& folder) {
  EXPECT_TRUE(write_ct(folder / "block.nii", test::block_ct()));
  std::string text = test::four_kinds_text();
  text.erase(text.find("[incision.cut]"));
  text.replace(text.find("cache = false"), 13, "cache = false\npatch = { radius = 0.01 }");
  for (const char* key : {"young = 5e3\n", "bulge = 0.4\n", "ct = \"block.nii\"\n"})
    text.insert(text.find(key), "texture = { roughness = 5e-6, wavelength = 2e-3 }\n");
  std::ofstream(folder / "four.toml") << text;
  return folder / "four.toml";
}

void advance(Session& session, double time) {
  const double begin = session.now().snapshot.time;
  ASSERT_TRUE(
      wait_until(session, [&](const SessionStatus& now) { return now.snapshot.time > begin + time; }));
}

/// Presses every body with its tool, away from the middle by a fraction of the body's size.
void press_all(Session& session, double offset, int teleports) {
  const SessionStatus& now = session.now();
  for (const MouseTool& mouse : now.mouse) {
    const ToolSnapshot& tool = now.snapshot.tools[std::size_t(mouse.tool)];
    const BodySnapshot& body = body_snapshot(now.snapshot, tool.body);
    const Vec3d middle = (body.box.low + body.box.high) * 0.5,
                position = {middle.x + offset * (body.box.high.x - body.box.low.x), middle.y,
                            body.box.high.z};
    double tip = 0;
    for (const Vec3 x : tool.mesh.vertices) tip = std::max(tip, -double(x.z));
    const auto at = [&](double height) { return position + Vec3d{0, 0, tip + height}; };
    mouse.device->set_target(
        {.pose = {at(-0.008), {}}, .hold = teleports == 2, .teleports = teleports, .teleport_to = at(0.004)});
  }
}

/// State hash after a replay.
std::uint64_t replayed_hash(const HapticRecording& run, int threads) {
  return state_hash(test::replayed_world(run, threads));
}

HapticRecording saved_run(Session& session, const fs::path& file) {
  session.request(SaveRequest{file});
  EXPECT_TRUE(wait_until(session, [](const SessionStatus& now) { return !now.saved.empty(); }));
  Result<HapticRecording> run = read_haptic_recording(file);
  EXPECT_TRUE(run) << session.now().saved << run.error().message;
  return run ? *run : HapticRecording();
}

/// Hands on four models, wind on the fifth, at two paces, with a single step, a cut, and a larger tension.
HapticRecording recorded_run(const fs::path& folder) {
  Session session(four_kinds_file(folder), {}, kOneThread);
  EXPECT_TRUE(wait_until(session, [](const SessionStatus& now) { return now.snapshot.frame > 2; }));
  press_all(session, -0.2, 1);
  advance(session, 0.4);
  session.request(WindRequest{.body = 0, .velocity = Vec3d{3, 0, 1}});
  session.request(CutRequest{.blade = {.name = "cut",
                                       .from = {0.002, -0.02, -0.03},
                                       .to = {0.002, -0.02, 0.03},
                                       .depth = 0.012,
                                       .duration = 0.1},
                             .body = 0});
  session.request(PaceRequest{.plays = true, .pace = 0.5});
  press_all(session, 0.25, 2);
  advance(session, 0.3);
  session.request(ChangeRequest{"body.block.skin.tension", "90"});
  session.request(PaceRequest{.plays = false, .pace = 1});
  session.request(StepRequest{});
  session.request(PaceRequest{});
  press_all(session, 0, 3);
  advance(session, 0.4);
  return saved_run(session, folder / "haptic.h5");
}

// A hand on a sheet replays to the same bits.
TEST(HapticRecording, SheetReplaysExactly) {
  const fs::path folder = fresh_folder();
  std::ofstream(folder / "sheet.toml") << R"(
[world]
gravity = [0, 0, -9.81]
[body.sheet]
model = "cloth"
sheet = { corner = [0, 0, 0], side = [0.12, 0, 0], up = [0, 0.1, 0], columns = 12, rows = 10 }
fabric = { law = "sheet" }
solver = { method = "two_level" }
hold.left = { box = [[-1, -1, -1], [0.001, 1, 1]] }
hold.right = { box = [[0.119, -1, -1], [1, 1, 1]] }
)";
  Session session(folder / "sheet.toml", {}, kOneThread);
  ASSERT_TRUE(wait_until(session, [](const SessionStatus& now) { return now.snapshot.frame > 2; }));
  ASSERT_EQ(session.now().mouse.size(), 1u) << "the mouse has a fingertip for the sheet";
  press_all(session, -0.2, 1);
  advance(session, 0.4);
  press_all(session, 0.2, 1);
  advance(session, 0.3);
  const HapticRecording run = saved_run(session, folder / "haptic.h5");
  ASSERT_EQ(run.tools.size(), 1u);
  EXPECT_GT(run.tools[0].ticks.size(), 400u);
  EXPECT_EQ(replayed_hash(run, 1), run.hash);
  EXPECT_EQ(replayed_hash(run, 3), run.hash);
}

// Hands on every model, cuts, winds and changes replay to the same bits.
TEST(HapticRecording, AllModelsReplayExactly) {
  HapticRecording run = recorded_run(fresh_folder());
  ASSERT_EQ(run.tools.size(), 4u);
  EXPECT_EQ(run.requests.size(), 3u);
  int patches = 0;
  for (const HapticTool& tool : run.tools) {
    EXPECT_GT(tool.ticks.size(), 800u) << tool.name;
    for (const HapticTick& tick : tool.ticks) patches = std::max(patches, tick.inputs_used.patch);
  }
  EXPECT_GT(patches, 0) << "the patch followed the finger";
  EXPECT_EQ(replayed_hash(run, 1), run.hash);
  EXPECT_EQ(replayed_hash(run, 3), run.hash);

  HapticRecording other = run;
  other.tools[0].ticks = {};
  for (HapticTick tick : run.tools[0].ticks) {
    if (other.tools[0].ticks.size() == run.tools[0].ticks.size() / 2) tick.command.pose.position.z -= 1e-6;
    other.tools[0].ticks.append(tick);
  }
  EXPECT_NE(replayed_hash(other, 1), run.hash) << "a micrometer in one tick changes the run";
  other = run, other.requests.pop_back();
  EXPECT_NE(replayed_hash(other, 1), run.hash) << "without the requested tension";
}

// The recorded ticks per frame determine the replay; the clock does not.
TEST(HapticRecording, FrameInputsDetermineReplay) {
  HapticRecording run = recorded_run(fresh_folder());
  for (HapticTool& tool : run.tools)  // as if every frame had received ten ticks later
    for (FrameInputs& inputs_used : tool.frames) inputs_used.ticks = std::max(0, inputs_used.ticks - 10);
  EXPECT_NE(replayed_hash(run, 1), run.hash) << "the ticks that a frame received determine the result";
}

// After a reset the recording holds only later events.
TEST(HapticRecording, ResetStartsNewRecording) {
  const fs::path folder = fresh_folder();
  Session session(four_kinds_file(folder), {}, kOneThread);
  ASSERT_TRUE(wait_until(session, [](const SessionStatus& now) { return now.snapshot.frame > 10; }));
  session.request(ChangeRequest{"body.sheet.wind.velocity", "[0, 5, 0]"});
  session.request(ResetRequest{});
  const int world = session.now().world;
  ASSERT_TRUE(wait_until(
      session, [world](const SessionStatus& now) { return now.world > world && now.snapshot.frame > 5; }));
  const HapticRecording run = saved_run(session, folder / "haptic.h5");
  EXPECT_TRUE(run.requests.empty()) << "the reset scene contains the change";
  EXPECT_EQ(run.overrides, std::vector<std::string>{"body.sheet.wind.velocity=[0, 5, 0]"});
  EXPECT_EQ(replayed_hash(run, 2), run.hash);
}

// Foreign and damaged files are refused with a message that names the file; old dataset names are read.
TEST(HapticRecording, RejectsDamagedFiles) {
  const fs::path folder = fresh_folder();
  std::ofstream(folder / "text.h5") << "no HDF5";
  EXPECT_FALSE(read_haptic_recording(folder / "text.h5"));
  EXPECT_FALSE(read_haptic_recording(folder / "none.h5"));
  HapticRecording run{.file = "a.toml", .folder = folder, .text = "[world]\n", .frames = 2, .hash = 7};
  run.tools.push_back({.name = "tip",
                       .ticks = {{.time = 0.001, .step = 0.001}, {.time = 0.002, .step = 0.001}},
                       .frames = {{.ticks = 1}, {.ticks = 2}}});
  run.requests.push_back({1, WindRequest{0, Vec3d{1, 0.1, 1e-17}}});
  const fs::path file = folder / "haptic.h5";
  ASSERT_TRUE(write_haptic_recording(file, run));
  Result<HapticRecording> read = read_haptic_recording(file);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(std::get<WindRequest>(read->requests[0].what).velocity->z, 1e-17) << "bit for bit";
  EXPECT_EQ(read->hash, 7u);
  EXPECT_FALSE(read->has_whole_cells);

  // the dataset names of the previous format, which has no default of cells
  ASSERT_EQ(test::write_with_names(file, folder / "old.h5",
                                   {{"tick_inputs", "ticks_knew"},
                                    {"frame_inputs", "frames_knew"},
                                    {"requests", "asks"},
                                    {"default_cells", "unknown"}},
                                   "turgor felt run 1"),  // check_words: ok
            4);
  const Result<HapticRecording> old = read_haptic_recording(folder / "old.h5");
  ASSERT_TRUE(old) << old.error().message;
  EXPECT_EQ(std::get<WindRequest>(old->requests[0].what).velocity->z, 1e-17);
  EXPECT_EQ(old->tools[0].frames[1].ticks, 2);
  EXPECT_EQ(old->tools[0].ticks.size(), 2u);
  EXPECT_EQ(old->hash, 7u);
  EXPECT_TRUE(old->has_whole_cells);
  ASSERT_TRUE(write_haptic_recording(file, *old));
  EXPECT_TRUE(read_haptic_recording(file)->has_whole_cells) << "written again";
  const auto refused = [&](const HapticRecording& wrong) {
    EXPECT_TRUE(write_haptic_recording(file, wrong));
    const Result<HapticRecording> again = read_haptic_recording(file);
    EXPECT_FALSE(again);
    EXPECT_NE((again ? std::string() : again.error().message).find("haptic.h5"), std::string::npos);
  };
  HapticRecording wrong = run;
  wrong.tools[0].frames[1].ticks = 3;
  refused(wrong);
  wrong = run, wrong.tools[0].frames.pop_back();
  refused(wrong);
  wrong = run, wrong.tools[0].ticks = {{.time = 0.001, .step = -1}, {.time = 0.002, .step = 0.001}};
  refused(wrong);
  EXPECT_FALSE(write_haptic_recording(file, {})) << "an empty recording";
  EXPECT_FALSE(write_haptic_recording(folder / "nowhere" / "haptic.h5", run));
}

}  // namespace
}  // namespace turgor
