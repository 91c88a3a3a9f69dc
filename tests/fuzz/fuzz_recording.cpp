// Any bytes as a recording of a small scene: an error, or a world whose bodies have finite positions, never a
// crash.
#include <cmath>
#include <cstdint>
#include <fstream>

#include "fuzz_input.hpp"
#include "tests/folders.hpp"
#include "turgor/sim/recording/recording.hpp"

namespace {

namespace fs = std::filesystem;

const turgor::Exec kOne(1);

/// The scene of the corpus: its bodies need no file.
turgor::World small_world() {
  auto scene = turgor::read_scene(fs::path(TURGOR_SOURCE_DIR) / "tests/fuzz/recorded.toml");
  require(bool(scene));
  auto loaded = load_world(kOne, *scene, {}, turgor::Purpose::kDraw);
  require(bool(loaded));
  return std::move(*loaded);
}

void replay(const turgor::Recording& recording) {
  static const turgor::World untouched = small_world();
  if (!recording.check_world(untouched)) return;
  turgor::World world = small_world();
  turgor::WorldSnapshot snapshot;
  std::vector<turgor::Pressed> pressed;
  for (int s = 0; s < std::min(recording.snapshot_count(), 4); s++) {
    if (!recording.restore(kOne, s, world, snapshot)) return;
    for (const turgor::LatticeBody& body : world.lattice_bodies)
      for (const float x : body.state->motion.u.x) require(std::isfinite(x));
    for (const turgor::ClothBody& body : world.cloth_bodies)
      for (const turgor::Vec3 x : turgor::cloth::model_surface(body.model, body.state).vertices)
        require(std::isfinite(dot(x, x)));
  }
  (void)bool(recording.restore_touch(world, pressed));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  static const fs::path folder = turgor::test::fresh_folder();
  const fs::path file = folder / "recording.h5";
  std::ofstream(file, std::ios::binary).write(reinterpret_cast<const char*>(bytes), std::streamsize(size));
  const turgor::Result<turgor::Recording> recording = turgor::Recording::open(file);
  if (!recording) return require(recording.error().message.find("/recording.h5") != std::string::npos), 0;
  const turgor::Result<turgor::Scene> scene = recording->scene({});
  if (!scene) require(!scene.error().message.empty());
  replay(*recording);
  return 0;
}
