// A world with the fifth model of docs/adding-a-model.md. It is read, simulated, displayed, reported, hashed,
// recorded and restored by the same functions as every other model.
#include <cmath>
#include <cstdio>
#include <filesystem>

#include <unistd.h>

#include "turgor/sim/recording/recording.hpp"
#include "turgor/sim/report/report.hpp"
#include "turgor/sim/run.hpp"

namespace {

int failures = 0;

void check(bool holds, const char* claim) {
  if (!holds) failures++, std::fprintf(stderr, "failed: %s\n", claim);
}

}  // namespace

int main() {
  using namespace turgor;
  namespace fs = std::filesystem;
  const Exec exec(1);
  const Result<Scene> scene = read_scene(FIFTH_MODEL_SCENE);
  if (!scene) return std::fprintf(stderr, "%s\n", scene.error().message.c_str()), 1;
  Result<World> world = load_world(exec, *scene);
  if (!world) return std::fprintf(stderr, "%s\n", world.error().message.c_str()), 1;
  const std::uint64_t hash_before = state_hash(*world);

  const fs::path file = fs::temp_directory_path() / ("turgor-fifth-" + std::to_string(getpid()) + ".h5");
  Result<RecordingWriter> writer = RecordingWriter::create(file, *scene, *world);
  check(bool(writer), "the recording is created");
  RunEvents events;
  float farthest_back = 0;  // half a period, the opposite extreme
  events.snapshot = [&](const World& now, const WorldSnapshot& snapshot) {
    farthest_back = std::min(farthest_back, snapshot.bodies.back().displacement[0].x);
    return writer->add_snapshot(now, snapshot);
  };
  const Result<Simulated> done = simulate(exec, *scene, *world, events);
  check(bool(done), "the scene runs");
  const Vec3d u = world->spring_bodies[0].state.u;
  check(std::abs(u.x - 0.03) < 1e-6, "the ball is back after one period");
  check(std::abs(farthest_back + 0.03f) < 1e-5, "the ball is at the opposite extreme after half a period");
  check(state_hash(*world) != hash_before, "the state hash changes");

  const Json report = simulation_report(exec, *scene, *world, done->measures, {});
  check(report["bodies"].size() == 1 && report["bodies"][0]["model"] == "spring", "the report has the body");
  check(report["bodies"][0]["displacement_mm"] == 30.0, "the report has its displacement");

  check(bool(writer->finish(*world, done->snapshot, done->measures.pressed, "{\"timing\": 0}")),
        "the recording is finished");
  const Result<Recording> recording = Recording::open(file);
  check(recording && recording->snapshot_count() == 5, "the recording has all snapshots");
  Result<World> drawn = load_world(exec, *recording->scene({}), {}, Purpose::kDraw);
  WorldSnapshot snapshot;
  check(drawn && recording->restore(exec, 4, *drawn, snapshot), "the last snapshot is restored");
  check(snapshot.bodies.size() == 1 && snapshot.bodies[0].x == done->snapshot.bodies[0].x,
        "the restored positions are equal");
  check(snapshot.bodies[0].triangles.size() > 100, "the snapshot has a surface");
  check(state_hash(*drawn) == state_hash(*world), "the restored state has the same bits");

  const Result<Scene> misspelled = parse_scene("[body.a]\nmodel = \"spring\"\nmas = 1\n", "s.toml");
  check(!misspelled && misspelled.error().message.find("mass") != std::string::npos,
        "a misspelled key is reported");
  fs::remove(file);
  return failures == 0 ? 0 : 1;
}
