#include "turgor/io/mesh/surface_animation.hpp"

#include <cstring>
#include <fstream>
#include <sstream>

#include <gtest/gtest.h>

#include "tests/folders.hpp"
#include "tests/refused.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;

const TriMesh kTriangle{.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, .triangles = {{0, 1, 2}}};

SurfaceAnimation animation_of(std::size_t times) {
  SurfaceAnimation animation{.frame_rate = 50, .times = {}, .surfaces = {{.name = "left lobe"}}};
  for (std::size_t t = 0; t < times; t++) {
    animation.times.push_back(0.02 * double(t));
    add_sample(kTriangle, animation.surfaces[0]);
  }
  return animation;
}

std::string content_of(const fs::path& file) {
  std::ostringstream out;
  out << std::ifstream(file, std::ios::binary).rdbuf();
  return out.str();
}

// A triangulation is stored again only when triangles or the number of points change.
TEST(SurfaceAnimation, TrianglesAreStoredWhenTheyChange) {
  AnimatedSurface surface;
  TriMesh other = kTriangle;
  other.triangles = {{0, 2, 1}};
  TriMesh more = other;
  more.vertices.push_back({0, 0, 1});
  for (const TriMesh& mesh : {kTriangle, kTriangle, other, more, more}) add_sample(mesh, surface);
  EXPECT_EQ(surface.triangulations.size(), 3u);
  EXPECT_EQ(surface.samples[1].triangulation, 0u);
  EXPECT_EQ(surface.samples[4].triangulation, 2u);
}

// Colors of points are in both files: linear in COLOR_0, which the material multiplies by white, and as a
// primvar that the material reads. They make a new triangulation where they change.
TEST(SurfaceAnimation, FilesHaveColorsOfPoints) {
  SurfaceAnimation animation{.frame_rate = 50, .times = {0, 0.02, 0.04}, .surfaces = {{.name = "wound"}}};
  AnimatedSurface& surface = animation.surfaces[0];
  const std::vector<Vec3> colors{{0.5f, 0.25f, 0}, {1, 0, 0}, {0, 1, 0}};
  add_sample({}, surface), add_sample(kTriangle, surface, colors), add_sample(kTriangle, surface, colors);
  EXPECT_EQ(surface.triangulations.size(), 2u);
  const fs::path folder = test::fresh_folder();
  ASSERT_TRUE(write_usda(folder / "a.usda", animation));
  const std::string usd = content_of(folder / "a.usda");
  EXPECT_NE(usd.find("1: [(0.5, 0.25, 0), (1, 0, 0), (0, 1, 0)],"), std::string::npos) << usd;
  EXPECT_NE(usd.find("diffuseColor.connect = </Turgor/Materials/wound/Colors.outputs:result>"),
            std::string::npos);
  ASSERT_TRUE(write_glb(folder / "a.glb", animation));
  const std::string glb = content_of(folder / "a.glb");
  EXPECT_NE(glb.find("\"baseColorFactor\":[1.0,1.0,1.0,1.0]"), std::string::npos);
  EXPECT_NE(glb.find("COLOR_0"), std::string::npos);
  EXPECT_NE(glb.find(std::string(reinterpret_cast<const char*>(colors.data()), 3 * sizeof(Vec3))),
            std::string::npos);
  add_sample(kTriangle, surface, {{1, 1, 1}, {1, 1, 1}, {1, 1, 1}});
  EXPECT_EQ(surface.triangulations.size(), 3u);
}

// Names are identifiers of USD and differ from each other.
TEST(SurfaceAnimation, UsdNamesAreUniqueIdentifiers) {
  SurfaceAnimation animation = animation_of(1);
  for (const char* name : {"left_lobe", "3rd", "", "Materials"}) animation.surfaces.push_back({.name = name});
  EXPECT_EQ(usd_names(animation),
            (std::vector<std::string>{"left_lobe", "left_lobe_2", "_3rd", "_", "Materials_2"}));
}

// USD has frames as time codes, and numbers that read back the same.
TEST(SurfaceAnimation, UsdTimeCodesAreFrames) {
  const fs::path file = test::fresh_folder() / "a.usda";
  SurfaceAnimation animation = animation_of(4);
  animation.surfaces[0].samples[3].points[1].x = 0.1f;
  ASSERT_TRUE(write_usda(file, animation));
  const std::string text = content_of(file);
  EXPECT_EQ(text.rfind("#usda 1.0\n", 0), 0u);
  for (const char* line :
       {"endTimeCode = 3\n", "timeCodesPerSecond = 50\n", "metersPerUnit = 1\n", "upAxis = \"Z\"",
        "3: [(0, 0, 0), (0.1, 0, 0), (0, 1, 0)],", "displayName = \"left lobe\""})
    EXPECT_NE(text.find(line), text.npos) << line;
}

// The lengths in a .glb agree with the file, and too many samples are refused without a file.
TEST(SurfaceAnimation, GlbHasItsLengthAndLimit) {
  const fs::path folder = test::fresh_folder(), file = folder / "a.glb";
  ASSERT_TRUE(write_glb(file, animation_of(3)));
  const std::string bytes = content_of(file);
  std::uint32_t words[5];
  ASSERT_GT(bytes.size(), sizeof words);
  std::memcpy(words, bytes.data(), sizeof words);
  EXPECT_EQ(bytes.substr(0, 4), "glTF");
  EXPECT_EQ(words[1], 2u);
  EXPECT_EQ(words[2], bytes.size());
  EXPECT_EQ(words[3] % 4, 0u);
  const Status status = write_glb(folder / "b.glb", animation_of(kMostGltfSamples + 1));
  ASSERT_FALSE(status);
  EXPECT_NE(status.error().message.find("expected at most 1000 snapshots"), std::string::npos);
  EXPECT_FALSE(fs::exists(folder / "b.glb"));
}

/// A surface with all kinds of arrays: normals, colors of points, triangles that change, a time without it.
SurfaceAnimation varied_animation() {
  SurfaceAnimation animation = animation_of(5);
  TriMesh square = kTriangle;
  square.vertices.push_back({1, 1, 0});
  square.triangles.push_back({1, 3, 2});
  square.normals.assign(4, {0, 0, 1});
  const std::vector<Vec3> colors(4, Vec3{1, 0, 0});
  AnimatedSurface wound{.name = "wound", .look = {}, .triangulations = {}, .colors = {}, .samples = {}};
  add_sample({}, wound), add_sample(kTriangle, wound);
  add_sample(square, wound, colors), add_sample(square, wound, colors), add_sample(square, wound);
  animation.surfaces.push_back(wound);
  return animation;
}

// The size of the binary chunk is known before it is made.
TEST(SurfaceAnimation, GlbSizeIsKnownBefore) {
  const fs::path folder = test::fresh_folder();
  for (const SurfaceAnimation& animation : {animation_of(1), animation_of(7), varied_animation()}) {
    ASSERT_TRUE(write_glb(folder / "a.glb", animation));
    const std::string bytes = content_of(folder / "a.glb");
    std::uint32_t json_size = 0, chunk_size = 0;
    std::memcpy(&json_size, bytes.data() + 12, 4);
    std::memcpy(&chunk_size, bytes.data() + 20 + json_size, 4);
    EXPECT_EQ(bytes.substr(24 + json_size, 4), std::string("BIN\0", 4));
    EXPECT_EQ(glb_bytes(animation), chunk_size);
  }
}

// A .glb that is larger than its limit is refused without a file, by its samples or by its JSON.
TEST(SurfaceAnimation, GlbOfTooManyBytesIsRefused) {
  const fs::path file = test::fresh_folder() / "a.glb";
  const SurfaceAnimation animation = varied_animation();
  ASSERT_TRUE(write_glb(file, animation));
  const std::uint64_t size = fs::file_size(file);
  EXPECT_TRUE(write_glb(file, animation, size));
  fs::remove(file);
  for (const std::uint64_t most : {size - 1, glb_bytes(animation) - 1}) {
    EXPECT_REFUSED(write_glb(file, animation, most), "a.glb: expected at most ", "GiB in a file of glTF",
                   "USD has no such limit, or raise output.snapshots.every");
    EXPECT_FALSE(fs::exists(file));
  }
}

}  // namespace
}  // namespace turgor
