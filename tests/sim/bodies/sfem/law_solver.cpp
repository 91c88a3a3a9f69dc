// Solutions of a nonlinear patch beside a haptic thread.
#include "turgor/sim/bodies/sfem/law_solver.hpp"

#include <fstream>

#include <pthread.h>
#include <sys/resource.h>
#include <unistd.h>

#include "tests/sim/live/replayed_world.hpp"
#include "tests/sim/sfem_scene_text.hpp"
#include "turgor/sim/live/live_run.hpp"
#include "turgor/sim/run.hpp"

namespace turgor {
namespace {

Scene law_scene() {
  const std::filesystem::path folder = test::fresh_folder();
  return test::body_scene(folder,
                          "patch = { radius = 0.013, refinement = 2 }\n"
                          "law = \"exponential\"\nstiffening = 4\n",
                          {"tool.finger.press.depth=0.004"});
}

/// A recorded run with a virtual hand, of 40 frames or until ticks have used some solutions.
HapticRecording recorded_law_run(World& world, const Scene& scene) {
  LiveRun live = start_live(world, {}, scene.duration).value();
  for (int frame = 0; frame < 40 || (world.sfem_bodies[0].law_summary.solutions < 10 && frame < 900);
       frame++) {
    EXPECT_TRUE(step(Exec(1), world));
    live.touch->record_frame_inputs();
    live.touch->wait_for_frame();
  }
  live.touch->stop();
  EXPECT_TRUE(live.touch->notes().empty() || live.touch->notes()[0].find("nonlinear") == std::string::npos);
  HapticRecording run = live.touch->haptic_recording().value();
  set_scene(scene, false, run);
  return run;
}

// Ticks use solutions of a thread of its own, whose order a replay repeats: the same bits on any number of
// threads, also from a file.
TEST(LawSolver, LiveSolutionsReplayExactly) {
  const Scene scene = law_scene();
  World world = test::sfem_world(Exec(1), scene);
  const HapticRecording run = recorded_law_run(world, scene);
  // solutions are of earlier ticks, and each is of later forces than the one before
  int used = 0;
  std::int32_t tick = 0, before = 0, patch = 0;
  for (const HapticTick& one : run.tools[0].ticks) {
    tick++;
    const TickInputs& inputs = one.inputs_used;
    ASSERT_GE(inputs.solution, 0);
    ASSERT_LT(inputs.solution, tick);
    ASSERT_TRUE(inputs.patch != patch || inputs.solution >= before);
    used += inputs.solution > 0 && inputs.solution != before;
    before = inputs.solution, patch = inputs.patch;
  }
  EXPECT_GT(used, 5);
  const LawSummary& sum = world.sfem_bodies[0].law_summary;
  EXPECT_GE(sum.solutions, used);
  EXPECT_FALSE(world.sfem_bodies[0].haptic);
  // replays
  EXPECT_EQ(state_hash(test::replayed_world(run, 1)), run.hash);
  const std::filesystem::path file = test::fresh_folder() / "haptic.h5";
  ASSERT_TRUE(write_haptic_recording(file, run));
  const Result<HapticRecording> read = read_haptic_recording(file);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(state_hash(test::replayed_world(*read, 3)), run.hash);
  // without a hand the world goes on
  EXPECT_TRUE(step(Exec(1), world));
}

// Other solutions at a tick are other bits: the recorded ticks determine the replay.
TEST(LawSolver, RecordedTicksDetermineReplay) {
  const Scene scene = law_scene();
  World world = test::sfem_world(Exec(1), scene);
  const HapticRecording run = recorded_law_run(world, scene);
  HapticRecording other = run;
  other.tools[0].ticks = {};
  for (HapticTick tick : run.tools[0].ticks) {
    tick.inputs_used.solution = 0;  // the patch stays as it was built
    other.tools[0].ticks.append(tick);
  }
  EXPECT_NE(state_hash(test::replayed_world(other, 1)), run.hash);
}

// A solution of another patch than the one in use is ignored; forces on such a patch have none.
TEST(LawSolver, OtherPatchesAreIgnored) {
  World world = test::sfem_world(Exec(1), law_scene());
  SfemBody& body = world.sfem_bodies[0];
  for (int frame = 0; frame < 4; frame++) ASSERT_TRUE(step(Exec(1), world));
  begin_haptics(body, world.tools);
  ASSERT_TRUE(begin_solutions(body, true));
  LawSolver& solver = *body.haptic->solver;
  contact::LawForces forces{
      .patch_number = body.touch.patch_number, .ticks = 7, .force = body.touch.state.force};
  const std::optional<contact::PatchSolution> solution = solver.solve(forces);
  ASSERT_TRUE(solution);
  EXPECT_EQ(solution->tick, 7);
  contact::PatchSolution other = *solution;
  other.base++;
  const auto in_use = body.touch.patch;
  contact::take_solution(body.touch, other);
  EXPECT_EQ(body.touch.patch, in_use);
  contact::take_solution(body.touch, *solution);
  EXPECT_EQ(body.touch.patch, solution->patch);
  EXPECT_EQ(body.touch.solution_tick, 7);
  forces.patch_number++;
  EXPECT_FALSE(solver.solve(forces));
  EXPECT_EQ(solver.take_progress().sum.solutions, 1);
  EXPECT_EQ(solver.take_progress().sum.solutions, 0) << "progress is taken once";
  end_haptics(body);
  EXPECT_TRUE(step(Exec(1), world));
}

// A replay finds the forces and the exponent after a tick, also if later ticks did not change them.
TEST(LawSolver, ReplayedForcesAreOfTheirTick) {
  ReplayedForces forces;
  EXPECT_EQ(forces.after(1), nullptr);
  for (const long tick : {1, 2, 3, 4})
    forces.push({.ticks = tick, .force = {Vec3d{tick < 3 ? 1.0 : double(tick), 0, 0}}});
  forces.push({.ticks = 6, .force = {Vec3d{4, 0, 0}}, .stiffening = 3});
  EXPECT_EQ(forces.after(0), nullptr);
  EXPECT_EQ(forces.after(2)->force[0].x, 1);
  EXPECT_EQ(forces.after(3)->force[0].x, 3);
  EXPECT_EQ(forces.after(5)->force[0].x, 4);
  EXPECT_EQ(forces.after(5)->stiffening, 0);
  EXPECT_EQ(forces.after(9)->stiffening, 3);
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // sanitizers need memory of their own
/// 0 if a thread that the system refuses leaves the solutions to the frames.
int begin_without_thread() {
  World world = test::sfem_world(Exec(1), law_scene());
  SfemBody& body = world.sfem_bodies[0];
  begin_haptics(body, world.tools);
  // memory for the patch, not for a thread's stack, nor an old stack that fits
  std::size_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  const rlim_t most = rlim_t(pages) * rlim_t(sysconf(_SC_PAGESIZE)) + (rlim_t(64) << 20);
  const rlimit limit{most, most};
  setrlimit(RLIMIT_AS, &limit);
  pthread_attr_t large;
  pthread_attr_init(&large);
  pthread_attr_setstacksize(&large, std::size_t(1) << 30);
  pthread_setattr_default_np(&large);
  const Status status = begin_solutions(body, false);
  if (status) return 1;
  std::fprintf(stderr, "%s\n", status.error().message.c_str());
  return !body.haptic->solver && tick_inputs(body, 0).solution == -1 ? 0 : 2;
}

// Frames solve the patch when the system refuses the thread.
TEST(LawSolverDeathTest, RefusedThreadLeavesSolutionsToFrames) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(_exit(begin_without_thread()), testing::ExitedWithCode(0),
              "cannot start the thread of the nonlinear patch");
}
#endif

}  // namespace
}  // namespace turgor
