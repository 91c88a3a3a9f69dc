#include "turgor/pictures/motion.hpp"

#include <algorithm>

#include <gtest/gtest.h>

#include "turgor/pictures/picture_items.hpp"
#include "turgor/sim/report/json_numbers.hpp"

namespace turgor {
namespace {

/// A sheet of n × n squares that is cut along its middle column. At rest the lips coincide without being
/// connected.
BodySnapshot cut_sheet(int n) {
  BodySnapshot body;
  body.name = "</script>", body.look = Look::kCloth;
  const int columns = n + 2, cut = n / 2;  // the middle column is duplicated
  for (int j = 0; j <= n; j++)
    for (int i = 0; i < columns; i++)
      body.rest.push_back({Real(i > cut ? i - 1 : i) * 0.01f, Real(j) * 0.01f, 0});
  for (int j = 0; j < n; j++)
    for (int i = 0; i + 1 < columns; i++) {
      if (i == cut) continue;
      const int a = j * columns + i;
      body.triangles.push_back({a, a + 1, a + columns + 1});
      body.triangles.push_back({a, a + columns + 1, a + columns});
    }
  body.x = body.rest;
  body.wall_begin = body.triangles.size();
  return body;
}

WorldSnapshot at_time(double time, Real opening) {
  WorldSnapshot snapshot{.time = time, .frame = 0, .bodies = {cut_sheet(60)}, .tools = {}, .obstacles = {}};
  BodySnapshot& body = snapshot.bodies[0];
  for (std::size_t v = 0; v < body.x.size(); v++)
    body.x[v].x = body.rest[v].x + (int(v) % 62 <= 30 ? -opening : opening);
  return snapshot;
}

Motion moved(int frames, const MotionLimits& limits = {}) {
  Motion motion;
  for (int f = 0; f < frames; f++) add_moment(at_time(0.05 * f, Real(0.001) * Real(f)), motion, limits);
  return motion;
}

// Walls with colors of layers replace those of the body: their vertices move with the corners between which
// they lie.
TEST(Motion, WallsHaveColorsOfLayers) {
  WorldSnapshot snapshot = at_time(0, 0);
  BodySnapshot& body = snapshot.bodies[0];
  body.normals.assign(body.x.size(), {0, 0, 1});
  body.wall_begin -= 1;  // the last triangle is a wall
  const Int3 wall = body.triangles.back();
  body.wall_layers.looks = {{"fat", Rgb{240, 214, 120}}};
  body.wall_layers.corner.assign(4, wall);
  body.wall_layers.weight = {{1, 0, 0}, {0.5f, 0.5f, 0}, {0, 1, 0}, {0, 0, 1}};
  body.wall_layers.layer = {0, 0, 0, WallLayers::kNoLayer};
  body.wall_layers.triangles = {{0, 1, 3}, {1, 2, 3}};
  Motion motion;
  add_moment(snapshot, motion);
  snapshot.time = 1;
  body.x[std::size_t(wall.x)].z += 0.01f;
  add_moment(snapshot, motion);
  const MovingSurface& surface = motion.things[0].surfaces.at(0);
  ASSERT_EQ(surface.triangles.size(), surface.wall_begin + 2);
  ASSERT_EQ(surface.colors.size(), surface.vertex.size());
  EXPECT_EQ(surface.colors[0], (Rgb{255, 255, 255}));
  const Int3 first = surface.triangles[surface.wall_begin];
  EXPECT_EQ(surface.colors[std::size_t(first.y)], (Rgb{240, 214, 120}));
  EXPECT_EQ(surface.colors[std::size_t(first.z)], (Rgb{166, 58, 50}));
  EXPECT_NEAR(motion.frames[1].moved[0][std::size_t(first.x)].z, 0.01, 1e-6);
  EXPECT_NEAR(motion.frames[1].moved[0][std::size_t(first.y)].z, 0.005, 1e-6);
  EXPECT_NE(motion_json(motion, 1'000'000).find("\"colors\""), std::string::npos);
}

// Beside walls with colors of layers, caps where the CT ends have the color of sections, and do not share
// vertices with skin, which is white.
TEST(Motion, CapsBesideLayersHaveColorOfSections) {
  WorldSnapshot snapshot = at_time(0, 0);
  BodySnapshot& body = snapshot.bodies[0];
  body.normals.assign(body.x.size(), {0, 0, 1});
  body.wall_begin -= 1, body.cap_count = 1;
  const Int3 wall = body.triangles.back();
  body.wall_layers.looks = {{"fat", Rgb{240, 214, 120}}};
  body.wall_layers.corner.assign(3, wall);
  body.wall_layers.weight = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  body.wall_layers.layer = {0, 0, 0};
  body.wall_layers.triangles = {{0, 1, 2}};
  Motion motion;
  add_moment(snapshot, motion);
  const MovingSurface& surface = motion.things[0].surfaces.at(0);
  ASSERT_EQ(surface.triangles.size(), surface.wall_begin + 2);
  const Int3 cap = surface.triangles[surface.wall_begin];
  for (int corner = 0; corner < 3; corner++) {
    EXPECT_EQ(surface.colors[std::size_t(cap[corner])], section_color(body));
    for (std::size_t t = 0; t < surface.wall_begin; t++)
      for (int other = 0; other < 3; other++) EXPECT_NE(surface.triangles[t][other], cap[corner]);
  }
}

// Simplification of the surface never joins the lips of a wound.
TEST(Motion, SimplificationKeepsLipsApart) {
  const Motion motion = moved(2, {.triangles = 500, .numbers = 1'000'000});
  const MovingSurface& surface = motion.things.at(0).surfaces.at(0);
  EXPECT_LE(surface.triangles.size(), 700u);
  EXPECT_GT(surface.triangles.size(), 4u);
  int checked = 0;
  for (const Int3 t : surface.triangles) {  // every triangle moves with one lip, none spans the gap
    for (int corner = 1; corner < 3; corner++)
      EXPECT_NEAR(motion.frames[1].moved[0][std::size_t(t[0])].x,
                  motion.frames[1].moved[0][std::size_t(t[corner])].x, 1e-6);
    checked++;
  }
  EXPECT_EQ(std::size_t(checked), surface.triangles.size());
}

// Stored displacements are those of the displayed vertices.
TEST(Motion, DisplacementsMatchVertices) {
  const Motion motion = moved(3);
  const MovingSurface& surface = motion.things.at(0).surfaces.at(0);
  const WorldSnapshot last = at_time(0.1, 0.002f);
  for (std::size_t v = 0; v < surface.vertex.size(); v++) {
    const Vec3 now = surface.rest[v] + motion.frames[2].moved[0][v];
    EXPECT_EQ(now, last.bodies[0].x[std::size_t(surface.vertex[v])]);
  }
}

// Memory is limited by dropping moments; the first and the last one are kept.
TEST(Motion, MemoryIsLimited) {
  const Motion motion = moved(200, {.triangles = 40'000, .numbers = 400'000});
  EXPECT_LE(motion.numbers, 400'000u);
  EXPECT_EQ(motion.frames.front().time, 0);
  EXPECT_DOUBLE_EQ(motion.frames.back().time, 0.05 * 199);
  EXPECT_GT(motion.frames.size(), 5u);
}

// Surfaces that no kept moment uses are freed.
TEST(Motion, UnusedSurfacesAreFreed) {
  Motion motion;
  for (int f = 0; f < 60; f++) {  // a growing cut: other triangles each time
    WorldSnapshot snapshot = at_time(0.05 * f, 0);
    snapshot.bodies[0].triangles.resize(snapshot.bodies[0].triangles.size() - std::size_t(f));
    snapshot.bodies[0].wall_begin = snapshot.bodies[0].triangles.size();
    add_moment(snapshot, motion, {.triangles = 40'000, .numbers = 400'000});
  }
  const std::vector<MovingSurface>& surfaces = motion.things.at(0).surfaces;
  const auto kept = std::count_if(surfaces.begin(), surfaces.end(),
                                  [](const MovingSurface& s) { return !s.triangles.empty(); });
  EXPECT_EQ(surfaces.size(), 60u);
  EXPECT_EQ(std::size_t(kept), motion.frames.size());
  EXPECT_GT(kept, 2);
  std::size_t numbers = 0;
  for (const MovingSurface& s : surfaces) numbers += 4 * s.rest.size() + 3 * s.triangles.size();
  for (const MotionFrame& frame : motion.frames) numbers += 3 * frame.moved[0].size();
  EXPECT_EQ(motion.numbers, numbers);
  EXPECT_LE(numbers, 400'000u);
  const Json page = Json::parse(motion_json(motion, 10'000'000));
  EXPECT_EQ(page["things"][0]["surfaces"].size(), 60u);
}

// The page holds as many moments as fit into its size.
TEST(Motion, PageHoldsMomentsThatFit) {
  const Motion motion = moved(40);
  const std::string all = motion_json(motion, 10'000'000), fewer = motion_json(motion, all.size() * 2 / 3);
  EXPECT_EQ(Json::parse(all)["frames"].size(), 40u);
  ASSERT_FALSE(fewer.empty());
  EXPECT_LE(fewer.size(), all.size() * 2 / 3);
  const Json frames = Json::parse(fewer)["frames"];
  EXPECT_GE(frames.size(), 2u);
  EXPECT_LT(frames.size(), 40u);
  EXPECT_EQ(frames.front()["time_s"], 0.0);
  EXPECT_EQ(frames.back()["time_s"], 0.05 * 39);
  EXPECT_EQ(motion_json(motion, 1000), "");
  EXPECT_EQ(motion_json({}, 10'000'000), "");
}

// A body name with a closing script tag does not end the script.
TEST(Motion, NamesAreEscapedInScript) {
  const std::string text = motion_json(moved(1), 10'000'000);
  EXPECT_EQ(text.find('<'), text.npos);
  EXPECT_EQ(Json::parse(text)["things"][0]["name"], "</script>");
}

// A new cut adds a new surface.
TEST(Motion, NewCutAddsSurface) {
  Motion motion = moved(2);
  WorldSnapshot cut = at_time(0.2, 0.002f);
  cut.bodies[0].triangles.resize(cut.bodies[0].triangles.size() - 10), cut.bodies[0].wall_begin -= 10;
  add_moment(cut, motion);
  EXPECT_EQ(motion.things[0].surfaces.size(), 2u);
  EXPECT_EQ(motion.frames[1].surface[0], 0u);
  EXPECT_EQ(motion.frames[2].surface[0], 1u);
}

}  // namespace
}  // namespace turgor
