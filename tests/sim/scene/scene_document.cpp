// Tables of keys in docs/scene.md and docs/scene/*.md, compared with the readers of scenes.
// scripts/scene-docs regenerates them.
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

/// Scenes that lead through every branch of the readers; their values do not matter.
constexpr const char* kScenes[] = {
    R"([body.a]
model = "lattice"
fixed = { sides = "back" }
[body.a.inside.x]
[body.a.ct]
phantom = "torso"
[incision.cut]
body = "a"
[incision.other]
body = "a"
from_fraction = [0, 0, 0]
[excision.mole]
body = "a"
center_fraction = [0, 0, 0]
[suture.row]
wound = "cut"
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
[tool.f]
body = "a"
path = [[0, 0, 0, 0]]
shape = { needle = 0.1 }
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
)",
    R"([body.a]
model = "sfem"
block = {}
[attachment.a]
[contact.a]
[organs]
bodies = ["b"]
labels = "m"
)",
    R"([body.a]
model = "rigid"
[body.b]
model = "rigid"
shape = { sphere = 1 }
[body.c]
model = "rigid"
shape = { capsule = [1, 1] }
[body.d]
model = "rigid"
shape = { mesh = "m" }
)"};

/// Keys by group, in the order of the readers.
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

/// Text of docs/scene.md and of every page of docs/scene, by file.
std::map<fs::path, std::string> scene_pages() {
  const fs::path docs = fs::path(TURGOR_SOURCE_DIR) / "docs";
  std::map<fs::path, std::string> pages;
  pages[docs / "scene.md"] = read_file(docs / "scene.md").value();
  for (const auto& entry : fs::directory_iterator(docs / "scene"))
    pages[entry.path()] = read_file(entry.path()).value();
  return pages;
}

// The tables of the documents match the keys of the readers.
TEST(SceneDocument, TablesMatchReaders) {
  std::map<fs::path, std::string> pages = scene_pages();
  const bool writes = std::getenv("TURGOR_WRITE_DOCUMENTS") != nullptr;
  for (const auto& [group, keys] : all_keys()) {
    const std::string begin = fmt::format("<!-- keys: {} -->\n", group);
    int tables = 0;
    for (auto& [file, page] : pages) {
      const std::size_t from = page.find(begin);
      if (from == page.npos) continue;
      tables++;
      const std::size_t at = from + begin.size(), to = page.find("<!-- end -->", at);
      ASSERT_NE(to, page.npos) << file << ": expected <!-- end --> after the table of " << group;
      if (writes)
        page.replace(at, to - at, table_of(keys));
      else
        EXPECT_EQ(page.substr(at, to - at), table_of(keys)) << file << ": run scripts/scene-docs";
    }
    EXPECT_EQ(tables, 1) << "expected one table of the keys of " << group
                         << " in docs/scene.md and docs/scene";
  }
  if (!writes) return;
  for (const auto& [file, page] : pages) ASSERT_TRUE(write_file(file, page));
}

// No reader has a key that is missing in the tables.
TEST(SceneDocument, ReadersHaveNoUndocumentedKey) {
  std::set<std::string> listed;
  for (const auto& [group, keys] : all_keys())
    for (const SceneKey& key : keys) listed.insert(key.key.substr(key.key.rfind('.') + 1));
  const std::regex reader_call(R"re(\.(?:read|read_path|read_choice(?:<[^>(]*>)?|describe)\(\s*"(\w+)")re");
  int found = 0;
  for (const auto& entry : fs::directory_iterator(fs::path(TURGOR_SOURCE_DIR) / "turgor" / "sim" / "scene")) {
    if (entry.path().extension() != ".cpp") continue;
    const std::string text = read_file(entry.path()).value();
    for (std::sregex_iterator hit(text.begin(), text.end(), reader_call), end; hit != end; ++hit, found++)
      EXPECT_TRUE(listed.contains((*hit)[1])) << entry.path().filename() << ": " << (*hit)[1];
  }
  EXPECT_GT(found, 100);
}

// A key has its unit, its limits and its default.
TEST(SceneDocument, KeyHasUnitLimitsAndDefault) {
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
