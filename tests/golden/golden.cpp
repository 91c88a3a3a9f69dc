// Prints the table of golden state hashes of this build: golden tests/golden/states.txt Each line of the
// table is a scene with the number of its frames; # begins a comment.
#include <cstdio>
#include <fstream>
#include <sstream>

#include <fmt/format.h>

#include "turgor/core/hash.hpp"
#include "turgor/sim/scene/scene.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {
namespace {

/// hash scene.toml frames [key=value …]
struct Line {
  std::string scene;
  int frames = 0;
  std::vector<std::string> overrides;
};

Line parse(const std::string& text) {
  std::istringstream words(text);
  Line line;
  std::string hash;
  words >> hash >> line.scene >> line.frames;
  for (std::string word; words >> word;) line.overrides.push_back(word);
  return line;
}

Result<std::string> state_after(const Line& line, const std::filesystem::path& scenes) {
  const Exec exec;
  const Result<Scene> scene = read_scene(scenes / line.scene, line.overrides);
  if (!scene) return scene.error();
  Result<World> world = load_world(exec, *scene);
  if (!world) return world.error();
  for (int frame = 0; frame < line.frames; frame++)
    if (const Result<FrameReport> done = step(exec, *world); !done) return done.error();
  return hash_text(state_hash(*world));
}

int print_states(const char* file) {
  const std::filesystem::path scenes = std::filesystem::path(TURGOR_SOURCE_DIR) / "scenes";
  std::ifstream table(file);
  int status = table ? 0 : 2;
  for (std::string text; std::getline(table, text);) {
    if (text.empty() || text[0] == '#') {
      fmt::print("{}\n", text);
      continue;
    }
    const Result<std::string> hash = state_after(parse(text), scenes);
    if (!hash) fmt::print(stderr, "golden: {}\n", hash.error().message), status = 2;
    fmt::print("{}{}\n", hash ? *hash : std::string(16, '?'), text.substr(text.find(' ')));
    std::fflush(stdout);
  }
  return status;
}

}  // namespace
}  // namespace turgor

int main(int count, char** arguments) { return count == 2 ? turgor::print_states(arguments[1]) : 2; }
