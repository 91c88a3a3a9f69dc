// A world with the fifth model of docs/adding-a-model.md: read, simulated, shown, reported, hashed, recorded
// and restored by the same functions as every other.
#include <cmath>
#include <cstdio>
#include <filesystem>

#include <unistd.h>

#include "turgor/sim/recording/recording.hpp"
#include "turgor/sim/report/report.hpp"
#include "turgor/sim/run.hpp"

namespace {

int failures = 0;

void check(bool holds, const char* sentence) {
  if (!holds) failures++, std::fprintf(stderr, "not so: %s\n", sentence);
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
  check(bool(writer), "a recording begins");
  RunEvents events;
  float farthest_back = 0;  // at half a swing
  events.snapshot = [&](const World& now, const WorldSnapshot& snapshot) {
    farthest_back = std::min(farthest_back, snapshot.bodies.back().displacement[0].x);
    return writer->add_snapshot(now, snapshot);
  };
  const Result<Simulated> done = simulate(exec, *scene, *world, events);
  check(bool(done), "it runs");
  const Vec3d u = world->spring_bodies[0].state.u;
  check(std::abs(u.x - 0.03) < 1e-6, "after its period the ball is where it was");
  check(std::abs(farthest_back + 0.03f) < 1e-5, "after half of it, on the other side");
  check(state_hash(*world) != hash_before, "the hash sees it");

  const Json report = simulation_report(exec, *scene, *world, done->measures, {});
  check(report["bodies"].size() == 1 && report["bodies"][0]["model"] == "spring", "it is reported");
  check(report["bodies"][0]["displacement_mm"] == 30.0, "with its numbers");

  check(bool(writer->finish(*world, done->snapshot, done->measures.pressed, "{\"timing\": 0}")),
        "it is recorded");
  const Result<Recording> recording = Recording::open(file);
  check(recording && recording->snapshot_count() == 5, "with all snapshots");
  Result<World> drawn = load_world(exec, *recording->scene({}), {}, Purpose::kDraw);
  WorldSnapshot snapshot;
  check(drawn && recording->restore(exec, 4, *drawn, snapshot), "and restored");
  check(snapshot.bodies.size() == 1 && snapshot.bodies[0].x == done->snapshot.bodies[0].x,
        "to the same places");
  check(snapshot.bodies[0].triangles.size() > 100, "with its surface");
  check(state_hash(*drawn) == state_hash(*world), "and the same bits");

  const Result<Scene> misspelt = parse_scene("[body.a]\nmodel = \"spring\"\nmas = 1\n", "s.toml");
  check(!misspelt && misspelt.error().message.find("mass") != std::string::npos, "a misspelt key is told");
  fs::remove(file);
  return failures == 0 ? 0 : 1;
}
