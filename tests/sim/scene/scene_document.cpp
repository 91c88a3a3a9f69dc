// docs/scene.md against what the readers of scenes ask for. scripts/scene-docs writes its tables anew.
#include <cstdlib>
#include <map>
#include <regex>
#include <set>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "turgor/io/files/file.hpp"
#include "turgor/sim/scene/scene_key.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;

/// Scenes that lead through every branch of the readers; what they say is of no interest.
constexpr const char* kScenes[] = {
    R"([body.a]
model = "lattice"
fixed = { sides = "back" }
[body.a.ct]
phantom = "torso"
[incision.cut]
body = "a"
[incision.other]
body = "a"
from_fraction = [0, 0, 0]
[camera.side]
from = [0, 0, 0]
[output]
deformed_size = [1, 1, 1]
)",
    R"([body.a]
model = "sfem"
mesh = "m"
fixed = { sides = "back" }
[body.a.inside.x]
[body.a.inclusion.x]
[tool.a]
body = "a"
path = "f"
shape = { mesh = "m" }
[tool.b]
body = "a"
press = { to = [0, 0, 0] }
shape = { forceps = "f" }
[tool.c]
body = "a"
grasp = {}
shape = { sphere = 1 }
[tool.d]
body = "a"
path = [[0, 0, 0, 0]]
shape = { capsule = [1, 1] }
[tool.e]
body = "a"
hand = "f"
shape = { sphere = 1 }
)",
    R"([body.a]
model = "sfem"
surface = "m"
[body.b]
model = "sfem"
labels = "m"
[body.c]
model = "sfem"
block = {}
[body.d]
model = "rhombus"
surface = "x"
stiffness = { labels = "m" }
[body.e]
model = "rhombus"
surface = { phantom = "liver" }
stiffness = { ct = "m" }
)",
    R"([body.a]
model = "cloth"
sheet = {}
[body.b]
model = "cloth"
mesh = "m"
[body.b.hold.h]
ball = {}
[body.b.obstacle.plane]
[body.b.obstacle.sphere]
sphere = {}
[body.b.obstacle.capsule]
capsule = {}
[body.b.obstacle.mesh]
mesh = "m"
)"};

/// By group, in the order in which they are asked for.
std::map<std::string, std::vector<SceneKey>> all_keys() {
  std::map<std::string, std::vector<SceneKey>> groups;
  std::set<std::pair<std::string, std::string>> known;
  for (const char* scene : kScenes)
    for (const SceneKey& key : scene_keys(scene, "s.toml"))
      if (known.insert({key.group, key.key}).second) groups[key.group].push_back(key);
  return groups;
}

std::string table_of(const std::vector<SceneKey>& keys) {
  std::string text = "| key | unit | default | range | meaning |\n|---|---|---|---|---|\n";
  for (const SceneKey& key : keys)
    text += fmt::format("| `{}` | {} | {} | {} | {} |\n", key.key, key.unit, key.fallback,
                        limits_text(key.allowed), key.meaning);
  return text;
}

TEST(SceneDocument, ItsTablesAreWhatTheReadersAskFor) {
  const fs::path file = fs::path(TURGOR_SOURCE_DIR) / "docs" / "scene.md";
  std::string document = read_file(file).value();
  const bool writes = std::getenv("TURGOR_WRITE_DOCUMENTS") != nullptr;
  for (const auto& [group, keys] : all_keys()) {
    const std::string begin = fmt::format("<!-- keys: {} -->\n", group);
    const std::size_t from = document.find(begin), to = document.find("<!-- end -->", from);
    ASSERT_NE(to, std::string::npos) << "docs/scene.md has no table of the keys of " << group;
    const std::size_t at = from + begin.size();
    if (writes)
      document.replace(at, to - at, table_of(keys));
    else
      EXPECT_EQ(document.substr(at, to - at), table_of(keys)) << "run scripts/scene-docs";
  }
  if (writes) {
    ASSERT_TRUE(write_file(file, document));
  }
}

TEST(SceneDocument, NoReaderKnowsAKeyThatNoTableHas) {
  std::set<std::string> listed;
  for (const auto& [group, keys] : all_keys())
    for (const SceneKey& key : keys) listed.insert(key.key.substr(key.key.rfind('.') + 1));
  const std::regex asked(R"re(\.(?:read|read_path|read_choice(?:<[^>(]*>)?|describe)\(\s*"(\w+)")re");
  int found = 0;
  for (const auto& entry : fs::directory_iterator(fs::path(TURGOR_SOURCE_DIR) / "turgor" / "sim" / "scene")) {
    if (entry.path().extension() != ".cpp") continue;
    const std::string text = read_file(entry.path()).value();
    for (std::sregex_iterator hit(text.begin(), text.end(), asked), end; hit != end; ++hit, found++)
      EXPECT_TRUE(listed.contains((*hit)[1])) << entry.path().filename() << ": " << (*hit)[1];
  }
  EXPECT_GT(found, 100);
}

TEST(SceneDocument, AKeyHasItsUnitItsLimitsAndWhatHoldsWithoutIt) {
  const auto groups = all_keys();
  for (const SceneKey& key : groups.at("lattice")) {
    if (key.key != "solver.damping") continue;
    EXPECT_EQ(key.path, "body.a.solver.damping");
    EXPECT_EQ(key.unit, "1/s");
    EXPECT_EQ(key.fallback, "1.2");
    EXPECT_EQ(key.allowed.low, 0);
    EXPECT_FALSE(key.allowed.open);
    return;
  }
  FAIL() << "solver.damping is not listed";
}

}  // namespace
}  // namespace turgor
