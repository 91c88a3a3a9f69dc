#include "turgor/view/mesh_view.hpp"

#include <cstdlib>
#include <thread>

#include <gtest/gtest.h>

#include "tests/view/shapes.hpp"

namespace turgor {
namespace {

constexpr int kWidth = 400, kHeight = 300;
constexpr Camera kFront{.eye = {0, -1, 0}, .target = {0, 0, 0}};
constexpr Rgb kRed{210, 20, 20}, kGreen{20, 190, 20};

class MeshView : public testing::Test {
 protected:
  void SetUp() override {
    const TriMesh mesh = test::sphere({}, 0.1f, 4);
    if (const Result<Image> image = draw_meshes({{.mesh = &mesh}}, kFront, 8, 8); !image)
      GTEST_SKIP() << image.error().message;
  }
};

bool is_red(Rgb c) { return c.r > 2 * c.g && c.r > 2 * c.b && c.r > 40; }
bool is_green(Rgb c) { return c.g > 2 * c.r && c.g > 2 * c.b && c.g > 40; }

test::Found find(const Image& image, bool (*wanted)(Rgb)) {
  return test::find_pixels(image, [&](int x, int y) { return wanted(image.at(x, y)); });
}

Image draw(const std::vector<MeshPart>& parts, const Camera& camera = kFront) {
  const Result<Image> image = draw_meshes(parts, camera, kWidth, kHeight);
  EXPECT_TRUE(image);
  return *image;
}

TEST_F(MeshView, RedSphereFillsTheExpectedPixelsAtTheExpectedPlace) {
  const TriMesh mesh = test::sphere({}, 0.15f);
  const auto found = find(draw({{.mesh = &mesh, .color = kRed}}), is_red);
  const double expected = test::silhouette_area(kFront, 0.15, kHeight);
  EXPECT_NEAR(found.count, expected, 0.03 * expected);
  EXPECT_NEAR(found.x, 0.5 * kWidth, 0.7);
  EXPECT_NEAR(found.y, 0.5 * kHeight, 0.7);
}

TEST_F(MeshView, SphereBesideTheMiddleIsSeenWhereItIs) {
  const Vec3d center{0.12, 0.3, -0.09};  // to the patient's left, behind, towards the feet
  const TriMesh mesh = test::sphere(Vec3(center), 0.03f);
  const auto found = find(draw({{.mesh = &mesh, .color = kRed}}), is_red);
  const Vec3d expected = test::project(kFront, center, kWidth, kHeight);
  EXPECT_GT(expected.x, kWidth / 2.0);
  EXPECT_GT(expected.y, kHeight / 2.0);
  EXPECT_NEAR(found.x, expected.x, 1);
  EXPECT_NEAR(found.y, expected.y, 1);
}

TEST_F(MeshView, NearerHidesFartherInEitherOrder) {
  const TriMesh near = test::sphere({0, -0.2f, 0}, 0.1f), far = test::sphere({0, 0.2f, 0}, 0.1f);
  const MeshPart red{.mesh = &near, .color = kRed}, green{.mesh = &far, .color = kGreen};
  for (const auto& parts : {std::vector{red, green}, std::vector{green, red}}) {
    const Image image = draw(parts);
    EXPECT_TRUE(is_red(image.at(kWidth / 2, kHeight / 2)));
    EXPECT_EQ(find(image, is_green).count, 0);
  }
}

TEST_F(MeshView, APartMarkedSoIsSeenThroughWhatHidesItAndShadowsOfOthersStay) {
  const TriMesh nodule = test::sphere({0.05f, 0, 0}, 0.05f), body = test::sphere({}, 0.2f);
  const MeshPart outer{.mesh = &body, .color = kRed};
  MeshPart inner{.mesh = &nodule, .color = kGreen};
  const Image hidden = draw({outer, inner}), without = draw({outer});
  inner.through = true;
  for (const auto& parts : {std::vector{outer, inner}, std::vector{inner, outer}}) {
    const Image seen = draw(parts);
    const auto greener = test::find_pixels(
        seen, [&](int x, int y) { return int(seen.at(x, y).g) > int(hidden.at(x, y).g) + 20; });
    const Vec3d place = test::project(kFront, {0.05, 0, 0}, kWidth, kHeight);
    const double expected = test::silhouette_area(kFront, 0.05, kHeight);
    EXPECT_NEAR(greener.count, expected, 0.08 * expected);
    EXPECT_NEAR(greener.x, place.x, 2);
    EXPECT_NEAR(greener.y, place.y, 2);
    EXPECT_LE(
        test::difference(seen.at(kWidth / 2 - 30, kHeight / 2), without.at(kWidth / 2 - 30, kHeight / 2)), 2);
  }
  EXPECT_EQ(find(hidden, is_green).count, 0);
}

TEST_F(MeshView, LayersOfAPartThatIsSeenThroughDoNotAddUp) {
  const TriMesh front = test::sphere({0, -0.05f, 0}, 0.05f), behind = test::sphere({0, 0.05f, 0}, 0.05f),
                body = test::sphere({}, 0.2f);
  TriMesh both = front;
  for (const Int3 t : behind.triangles)
    both.triangles.push_back(t + Int3{1, 1, 1} * int(front.vertices.size()));
  both.vertices.insert(both.vertices.end(), behind.vertices.begin(), behind.vertices.end());
  const MeshPart outer{.mesh = &body, .color = kRed};
  const auto middle = [&](const TriMesh& mesh) {
    return draw({outer, {.mesh = &mesh, .color = kGreen, .through = true}}).at(kWidth / 2, kHeight / 2);
  };
  EXPECT_GT(int(middle(front).g), 60);
  EXPECT_LE(test::difference(middle(both), middle(front)), 2);
}

TEST_F(MeshView, AClosedBodyLooksTheSameWithoutItsBacks) {
  const TriMesh ball = test::sphere({0, 0, 0.05f}, 0.12f), floor = test::sphere({0, 0, -2}, 1.95f, 200);
  MeshPart red{.mesh = &ball, .color = kRed};
  const Image open = draw({red, {.mesh = &floor}});
  red.closed = true;
  const Image closed = draw({red, {.mesh = &floor, .closed = true}});
  const auto other = test::find_pixels(
      open, [&](int x, int y) { return test::difference(open.at(x, y), closed.at(x, y)) > 8; });
  EXPECT_LE(other.count, 0.0005 * kWidth * kHeight) << "its shadow on the floor and its outline too";
  TriMesh plate{{{-0.2f, 0, -0.2f}, {0.2f, 0, -0.2f}, {0.2f, 0, 0.2f}}, {{0, 1, 2}}, {}, {}};
  const int fronts = find(draw({{.mesh = &plate, .color = kRed, .closed = true}}), is_red).count;
  std::swap(plate.triangles[0].y, plate.triangles[0].z);
  const int backs = find(draw({{.mesh = &plate, .color = kRed, .closed = true}}), is_red).count;
  EXPECT_GT(fronts, 1000);
  EXPECT_EQ(backs, 0);
}

TEST_F(MeshView, OutlinesBeforeAnotherSurfaceAreMixturesOfTheTwo) {
  const TriMesh ball = test::sphere({0, -0.3f, 0}, 0.1f), wall = test::sphere({0, 3, 0}, 2.7f, 200);
  const Image image = draw({{.mesh = &ball, .color = kRed}, {.mesh = &wall, .color = kGreen}});
  int mixed = 0, outlines = 0;
  for (int y = kHeight / 2 - 20; y < kHeight / 2 + 20; y++)
    for (int x = 2; x + 2 < kWidth; x++) {
      const Rgb left = image.at(x - 2, y), right = image.at(x + 2, y), here = image.at(x, y);
      if (!(is_red(left) && is_green(right)) && !(is_green(left) && is_red(right))) continue;
      outlines++;
      const auto between = [](int a, int v, int b) {
        return v >= std::min(a, b) - 12 && v <= std::max(a, b) + 12;
      };
      EXPECT_TRUE(between(left.r, here.r, right.r) && between(left.g, here.g, right.g))
          << x << " " << y << ": neither a dark nor a bright seam";
      mixed += !is_red(here) && !is_green(here);
    }
  EXPECT_GT(outlines, 100);
  EXPECT_GT(mixed, outlines / 8);
}

TEST_F(MeshView, BothSidesOfATriangleAreLit) {
  TriMesh plate{{{-0.2f, 0, -0.2f}, {0.2f, 0, -0.2f}, {0.2f, 0, 0.2f}, {-0.2f, 0, 0.2f}},
                {{0, 1, 2}, {0, 2, 3}},
                {},
                {}};
  const Rgb front = draw({{.mesh = &plate, .color = kRed}}).at(kWidth / 2, kHeight / 2);
  for (Int3& triangle : plate.triangles) std::swap(triangle.y, triangle.z);
  const Rgb back = draw({{.mesh = &plate, .color = kRed}}).at(kWidth / 2, kHeight / 2);
  EXPECT_GT(front.r, 100);
  EXPECT_LE(test::difference(front, back), 6);
}

TEST_F(MeshView, ScalarsAreColoredByTheMapAndOthersByThePart) {
  TriMesh mesh = test::sphere({}, 0.15f);
  const ColorScale scale{.low = 0, .high = 2, .label = "strain", .factor = 1};
  mesh.scalars.assign(mesh.vertices.size(), 2);
  const Rgb high = draw({{.mesh = &mesh, .scale = &scale}}).at(kWidth / 2, kHeight / 2);
  EXPECT_GT(high.r, 150);  // the map's upper end is yellow
  EXPECT_GT(high.g, 150);
  EXPECT_LT(high.b, 140);
  mesh.scalars.assign(mesh.vertices.size(), 0);
  const Rgb low = draw({{.mesh = &mesh, .scale = &scale}}).at(kWidth / 2, kHeight / 2);
  EXPECT_GT(low.b, low.g + 20);  // and the lower one indigo
  mesh.scalars.assign(mesh.vertices.size(), std::numeric_limits<float>::quiet_NaN());
  EXPECT_TRUE(is_red(draw({{.mesh = &mesh, .color = kRed, .scale = &scale}}).at(kWidth / 2, kHeight / 2)));
}

TEST_F(MeshView, EachScaleHasOneLegend) {
  TriMesh mesh = test::sphere({}, 0.15f);
  mesh.scalars.assign(mesh.vertices.size(), 1);
  const ColorScale scale{.low = 0, .high = 2, .label = "strain", .factor = 1};
  Image expected = draw({{.mesh = &mesh, .scale = &scale}});
  const Image twice = draw({{.mesh = &mesh, .scale = &scale}, {.mesh = &mesh, .scale = &scale}});
  EXPECT_EQ(expected.pixels, twice.pixels);
  const PixelBox bar = draw_legend(expected, scale);
  EXPECT_EQ(twice.at(bar.left, bar.top), map_color(1));
  EXPECT_EQ(twice.at(bar.left, bar.bottom - 1), map_color(0));
}

TEST_F(MeshView, VerticesMayHaveTheirOwnColors) {
  const TriMesh mesh = test::sphere({}, 0.15f);
  std::vector<Rgb> colors;
  for (const Vec3 x : mesh.vertices) colors.push_back(x.x < 0 ? kRed : kGreen);
  const Image image = draw({{.mesh = &mesh, .colors = &colors}});
  EXPECT_LT(find(image, is_red).x,
            kWidth / 2.0);  // the patient's right is on the left when seen from the front
  EXPECT_GT(find(image, is_green).x, kWidth / 2.0);
}

// A plate at z = 0 with its middle at the origin.
TriMesh floor_plate() {
  return {{{-0.3f, -0.3f, 0}, {0.3f, -0.3f, 0}, {0.3f, 0.3f, 0}, {-0.3f, 0.3f, 0}},
          {{0, 1, 2}, {0, 2, 3}},
          {},
          {}};
}
constexpr Camera kAbove{.eye = {0, -0.001, 0.5}, .target = {}, .up = {0, 1, 0}};

int brightness(const Image& image, Vec3d point) {
  const Vec3d seen = test::project(kAbove, point, kWidth, kHeight);
  return image.at(int(seen.x), int(seen.y)).g;
}

TEST_F(MeshView, BallCastsAShadowAwayFromTheKeyLight) {
  const TriMesh floor = floor_plate(), ball = test::sphere({0, 0, 0.03f}, 0.02f);
  const Image image = draw({{.mesh = &floor}, {.mesh = &ball, .color = kRed}}, kAbove);
  const int shadow = brightness(image, {0.033, -0.035, 0});  // the light comes from the left and from above
  for (const Vec3d lit : {Vec3d{-0.033, 0.035, 0}, {-0.033, -0.035, 0}, {0.033, 0.035, 0}})
    EXPECT_LT(shadow + 40, brightness(image, lit));
}

TEST_F(MeshView, FootOfAWallIsDarkerThanTheOpenFloorWithoutBeingInItsShadow) {
  const TriMesh floor = floor_plate();
  const TriMesh wall{{{0.05f, -0.3f, 0}, {0.05f, 0.3f, 0}, {0.05f, 0.3f, 0.06f}, {0.05f, -0.3f, 0.06f}},
                     {{0, 1, 2}, {0, 2, 3}},
                     {},
                     {}};  // on the side away from the light
  const Image with = draw({{.mesh = &floor}, {.mesh = &wall}}, kAbove),
              without = draw({{.mesh = &floor}}, kAbove);
  EXPECT_LT(brightness(with, {0.047, 0, 0}) + 12, brightness(without, {0.047, 0, 0}));
  EXPECT_NEAR(brightness(with, {-0.05, 0, 0}), brightness(without, {-0.05, 0, 0}), 2);
}

TEST_F(MeshView, NothingToSeeIsTheBackdrop) {
  const TriMesh behind = test::sphere({0, -3, 0}, 0.1f);  // behind the eye
  const Image image = draw({{.mesh = &behind, .color = kRed}});
  EXPECT_EQ(find(image, is_red).count, 0);
  EXPECT_EQ(image.pixels, draw({}).pixels);
  EXPECT_LE(test::difference(image.at(50, 60), screen_color(backdrop(50.5f / kWidth, 60.5f / kHeight))), 3);
}

TEST_F(MeshView, SamePictureTwiceAndFromTwoThreadsAtOnce) {
  const TriMesh mesh = test::sphere({}, 0.15f);
  const Image expected = draw({{.mesh = &mesh, .color = kRed}});
  Image images[2];
  std::thread threads[2];
  for (int i = 0; i < 2; i++)
    threads[i] = std::thread([&, i] { images[i] = draw({{.mesh = &mesh, .color = kRed}}); });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(images[0].pixels, expected.pixels);
  EXPECT_EQ(images[1].pixels, expected.pixels);
}

TEST_F(MeshView, PictureTooLargeForOpenGlIsAnError) {
  const Result<Image> image = draw_meshes({}, kFront, 1 << 20, 8);
  ASSERT_FALSE(image);
  EXPECT_NE(image.error().message.find("1048576 x 8"), std::string::npos);
  EXPECT_FALSE(draw_meshes({}, kFront, 0, 8));
}

// In a process of its own, that looks for drivers where there are none.
void draw_without_driver() {
  setenv("__EGL_VENDOR_LIBRARY_FILENAMES", "/no/such/driver.json", 1);
  const Result<Image> image = draw_meshes({}, kFront, 8, 8);
  if (!image) std::fprintf(stderr, "%s\n", image.error().message.c_str());
  std::_Exit(image ? 1 : 0);
}

TEST(MeshViewDeathTest, WithoutADriverThereIsAnErrorAndNoCrash) {
  testing::FLAGS_gtest_death_test_style = "threadsafe";
  EXPECT_EXIT(draw_without_driver(), testing::ExitedWithCode(0), "cannot draw: .*EGL");
}

}  // namespace
}  // namespace turgor
