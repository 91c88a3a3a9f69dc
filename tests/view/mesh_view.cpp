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

Image draw(const std::vector<RenderItem>& items, const Camera& camera = kFront) {
  const Result<Image> image = draw_meshes(items, camera, kWidth, kHeight);
  EXPECT_TRUE(image);
  return *image;
}

// A sphere covers the expected number of pixels around the center.
TEST_F(MeshView, SphereCoversExpectedPixels) {
  const TriMesh mesh = test::sphere({}, 0.15f);
  const auto found = find(draw({{.mesh = &mesh, .color = kRed}}), is_red);
  const double expected = test::silhouette_area(kFront, 0.15, kHeight);
  EXPECT_NEAR(found.count, expected, 0.03 * expected);
  EXPECT_NEAR(found.x, 0.5 * kWidth, 0.7);
  EXPECT_NEAR(found.y, 0.5 * kHeight, 0.7);
}

// A sphere away from the center is drawn at its projected position.
TEST_F(MeshView, OffCenterSphereIsProjectedCorrectly) {
  const Vec3d center{0.12, 0.3, -0.09};  // to the patient's left, behind, towards the feet
  const TriMesh mesh = test::sphere(Vec3(center), 0.03f);
  const auto found = find(draw({{.mesh = &mesh, .color = kRed}}), is_red);
  const Vec3d expected = test::project(kFront, center, kWidth, kHeight);
  EXPECT_GT(expected.x, kWidth / 2.0);
  EXPECT_GT(expected.y, kHeight / 2.0);
  EXPECT_NEAR(found.x, expected.x, 1);
  EXPECT_NEAR(found.y, expected.y, 1);
}

// The nearer body hides the farther one, in either drawing order.
TEST_F(MeshView, NearerHidesFarther) {
  const TriMesh near = test::sphere({0, -0.2f, 0}, 0.1f), far = test::sphere({0, 0.2f, 0}, 0.1f);
  const RenderItem red{.mesh = &near, .color = kRed}, green{.mesh = &far, .color = kGreen};
  for (const auto& items : {std::vector{red, green}, std::vector{green, red}}) {
    const Image image = draw(items);
    EXPECT_TRUE(is_red(image.at(kWidth / 2, kHeight / 2)));
    EXPECT_EQ(find(image, is_green).count, 0);
  }
}

// An item marked as see-through is visible through what hides it; other shading is unchanged.
TEST_F(MeshView, SeeThroughItemShinesThrough) {
  const TriMesh nodule = test::sphere({0.05f, 0, 0}, 0.05f), body = test::sphere({}, 0.2f);
  const RenderItem outer{.mesh = &body, .color = kRed};
  RenderItem inner{.mesh = &nodule, .color = kGreen};
  const Image hidden = draw({outer, inner}), without = draw({outer});
  inner.see_through = true;
  for (const auto& items : {std::vector{outer, inner}, std::vector{inner, outer}}) {
    const Image image = draw(items);
    const auto greener = test::find_pixels(
        image, [&](int x, int y) { return int(image.at(x, y).g) > int(hidden.at(x, y).g) + 20; });
    const Vec3d projected = test::project(kFront, {0.05, 0, 0}, kWidth, kHeight);
    const double expected = test::silhouette_area(kFront, 0.05, kHeight);
    EXPECT_LT(greener.count, 1.02 * expected);
    EXPECT_GT(greener.count, 0.5 * expected) << "all but the contour, which fades";
    EXPECT_NEAR(greener.x, projected.x, 2);
    EXPECT_NEAR(greener.y, projected.y, 2);
    EXPECT_LE(
        test::difference(image.at(kWidth / 2 - 30, kHeight / 2), without.at(kWidth / 2 - 30, kHeight / 2)),
        2);
  }
  EXPECT_EQ(find(hidden, is_green).count, 0);
}

// Tissue in front absorbs the light of a see-through item, and scatters away its contour.
TEST_F(MeshView, SeeThroughItemFadesWithDepth) {
  const TriMesh body = test::sphere({}, 0.2f);
  const RenderItem outer{.mesh = &body, .color = kRed};
  const Image without = draw({outer});
  const double radius = std::sqrt(test::silhouette_area(kFront, 0.05, kHeight) / 3.14159265);
  const auto gain = [&](float y, double share) {  // of green, at a share of the item's radius
    const TriMesh nodule = test::sphere({0, y, 0}, 0.05f);
    const Image image = draw({outer, {.mesh = &nodule, .color = kGreen, .see_through = true}});
    const int x = kWidth / 2 + int(share * radius);
    return int(image.at(x, kHeight / 2).g) - int(without.at(x, kHeight / 2).g);
  };
  const int near = gain(-0.13f, 0), deep = gain(0.1f, 0);
  EXPECT_GT(near, 30);
  EXPECT_GT(deep, 5) << "still visible";
  EXPECT_GT(near, 1.3 * deep);
  EXPECT_GT(near, 2 * gain(-0.13f, 0.97));
}

// A see-through item does not shine through opaque items, which are drawn as without it. A mark does. In full
// and in quick pictures, in any order of the items, beside a section as well.
TEST_F(MeshView, OpaqueItemHidesSeeThroughItem) {
  const TriMesh body = test::sphere({}, 0.2f), nodule = test::sphere({0.03f, -0.1f, 0}, 0.05f),
                stone = test::sphere({0.04f, -0.3f, 0.01f}, 0.03f),
                far = test::sphere({0.3f, 0.5f, 0.2f}, 0.1f);
  const Cutaway half{1, {{{0.3, 0.5, 0.2}, {0, -1, 0}}}};
  RenderItem inner{.mesh = &nodule, .color = kGreen, .see_through = true};
  const RenderItem outer{.mesh = &body, .color = kRed},
      covering{.mesh = &stone, .color = {90, 90, 90}, .opaque = true, .closed = true},
      section{.mesh = &far, .color = kRed, .cutaway = half, .is_cut_face = true};
  for (const RenderQuality quality : {RenderQuality::kFull, RenderQuality::kQuick}) {
    const auto drawn = [&](const std::vector<RenderItem>& items) {
      const Result<Image> image = draw_meshes(items, kFront, kWidth, kHeight, quality);
      EXPECT_TRUE(image);
      return *image;
    };
    const Image without = drawn({outer, covering, section});
    const Image bare = drawn({outer, section}), uncovered = drawn({outer, inner, section});
    const auto stone_pixel = [&](int x, int y) {
      const Rgb c = without.at(x, y);
      return std::abs(int(c.r) - int(c.g)) < 12 && std::abs(int(c.r) - int(c.b)) < 12 && c.r > 60;
    };
    const auto greener_than = [](const Image& image, const Image& than, int x, int y) {
      return int(image.at(x, y).g) > int(than.at(x, y).g) + 8;
    };
    for (const auto& items :
         {std::vector{outer, inner, covering, section}, {covering, section, inner, outer}}) {
      const Image image = drawn(items);
      int hidden = 0, beside = 0, covered = 0;
      for (int y = 0; y < kHeight; y++)
        for (int x = 0; x < kWidth; x++) {
          const bool is_stone = stone_pixel(x, y);
          hidden += is_stone && greener_than(image, without, x, y);
          beside += !is_stone && greener_than(image, without, x, y);
          covered += is_stone && greener_than(uncovered, bare, x, y);
        }
      EXPECT_EQ(hidden, 0);
      EXPECT_GT(beside, 300) << "the nodule shines through tissue beside the stone";
      EXPECT_GT(covered, 300) << "the stone covers a piece of the nodule";
    }
    RenderItem mark = inner;
    mark.is_mark = true;
    const Image marked = drawn({outer, covering, mark, section});
    EXPECT_GT(
        test::find_pixels(
            marked, [&](int x, int y) { return stone_pixel(x, y) && greener_than(marked, without, x, y); })
            .count,
        300);
  }
}

// Several layers of a see-through item do not accumulate.
TEST_F(MeshView, SeeThroughLayersDoNotAccumulate) {
  const TriMesh front = test::sphere({0, -0.05f, 0}, 0.05f), behind = test::sphere({0, -0.03f, 0}, 0.02f),
                body = test::sphere({}, 0.2f);
  TriMesh both = front;
  for (const Int3 t : behind.triangles)
    both.triangles.push_back(t + Int3{1, 1, 1} * int(front.vertices.size()));
  both.vertices.insert(both.vertices.end(), behind.vertices.begin(), behind.vertices.end());
  const RenderItem outer{.mesh = &body, .color = kRed};
  const auto middle = [&](const TriMesh& mesh) {
    return draw({outer, {.mesh = &mesh, .color = kGreen, .see_through = true}}).at(kWidth / 2, kHeight / 2);
  };
  EXPECT_GT(int(middle(front).g), 60);
  EXPECT_LE(test::difference(middle(both), middle(front)), 2);
}

// Culling back faces of a closed body does not change the picture.
TEST_F(MeshView, BackFaceCullingKeepsPicture) {
  const TriMesh ball = test::sphere({0, 0, 0.05f}, 0.12f), floor = test::sphere({0, 0, -2}, 1.95f, 200);
  RenderItem red{.mesh = &ball, .color = kRed};
  const Image open = draw({red, {.mesh = &floor}});
  red.closed = true;
  const Image closed = draw({red, {.mesh = &floor, .closed = true}});
  const auto other = test::find_pixels(
      open, [&](int x, int y) { return test::difference(open.at(x, y), closed.at(x, y)) > 8; });
  EXPECT_LE(other.count, 0.0005 * kWidth * kHeight) << "also the shadow on the floor and the outline";
  TriMesh plate{{{-0.2f, 0, -0.2f}, {0.2f, 0, -0.2f}, {0.2f, 0, 0.2f}}, {{0, 1, 2}}, {}, {}};
  const int fronts = find(draw({{.mesh = &plate, .color = kRed, .closed = true}}), is_red).count;
  std::swap(plate.triangles[0].y, plate.triangles[0].z);
  const int backs = find(draw({{.mesh = &plate, .color = kRed, .closed = true}}), is_red).count;
  EXPECT_GT(fronts, 1000);
  EXPECT_EQ(backs, 0);
}

// Pixels at a silhouette are mixtures of the two surfaces.
TEST_F(MeshView, SilhouettesAreAntialiased) {
  const TriMesh ball = test::sphere({0, -0.3f, 0}, 0.1f), wall = test::sphere({0, 3, 0}, 2.7f, 200);
  const Image image = draw({{.mesh = &ball, .color = kRed}, {.mesh = &wall, .color = kGreen}});
  int mixed = 0, outlines = 0;
  for (int y = kHeight / 2 - 20; y < kHeight / 2 + 20; y++)
    for (int x = 2; x + 2 < kWidth; x++) {
      const Rgb left = image.at(x - 2, y), right = image.at(x + 2, y), pixel = image.at(x, y);
      if (!(is_red(left) && is_green(right)) && !(is_green(left) && is_red(right))) continue;
      outlines++;
      const auto between = [](int a, int v, int b) {
        return v >= std::min(a, b) - 12 && v <= std::max(a, b) + 12;
      };
      EXPECT_TRUE(between(left.r, pixel.r, right.r) && between(left.g, pixel.g, right.g))
          << x << " " << y << ": neither a dark nor a bright seam";
      mixed += !is_red(pixel) && !is_green(pixel);
    }
  EXPECT_GT(outlines, 100);
  EXPECT_GT(mixed, outlines / 8);
}

// Both sides of a triangle are lit equally.
TEST_F(MeshView, BothTriangleSidesAreLit) {
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

// Scalars are colored by the map; NaN values have the color of the item.
TEST_F(MeshView, ScalarsUseColorMap) {
  TriMesh mesh = test::sphere({}, 0.15f);
  const ColorScale scale{.low = 0, .high = 2, .label = "strain", .factor = 1};
  mesh.scalars.assign(mesh.vertices.size(), 2);
  const Rgb high = draw({{.mesh = &mesh, .scale = &scale}}).at(kWidth / 2, kHeight / 2);
  EXPECT_GT(high.r, 150);  // the upper end of the map is yellow
  EXPECT_GT(high.g, 150);
  EXPECT_LT(high.b, 140);
  mesh.scalars.assign(mesh.vertices.size(), 0);
  const Rgb low = draw({{.mesh = &mesh, .scale = &scale}}).at(kWidth / 2, kHeight / 2);
  EXPECT_GT(low.b, low.g + 20);  // the lower end is indigo
  mesh.scalars.assign(mesh.vertices.size(), std::numeric_limits<float>::quiet_NaN());
  EXPECT_TRUE(is_red(draw({{.mesh = &mesh, .color = kRed, .scale = &scale}}).at(kWidth / 2, kHeight / 2)));
}

// Items that share a scale have one legend.
TEST_F(MeshView, SharedScaleHasOneLegend) {
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

// Vertices may have their own colors.
TEST_F(MeshView, VerticesHaveOwnColors) {
  const TriMesh mesh = test::sphere({}, 0.15f);
  std::vector<Rgb> colors;
  for (const Vec3 x : mesh.vertices) colors.push_back(x.x < 0 ? kRed : kGreen);
  const Image image = draw({{.mesh = &mesh, .colors = &colors}});
  EXPECT_LT(find(image, is_red).x,
            kWidth / 2.0);  // the patient's right is on the left in a front view
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
  const Vec3d pixel = test::project(kAbove, point, kWidth, kHeight);
  return image.at(int(pixel.x), int(pixel.y)).g;
}

// A ball casts a shadow away from the key light.
TEST_F(MeshView, BallCastsShadow) {
  const TriMesh floor = floor_plate(), ball = test::sphere({0, 0, 0.03f}, 0.02f);
  const Image image = draw({{.mesh = &floor}, {.mesh = &ball, .color = kRed}}, kAbove);
  const int shadow = brightness(image, {0.033, -0.035, 0});  // the light comes from the left and from above
  for (const Vec3d lit : {Vec3d{-0.033, 0.035, 0}, {-0.033, -0.035, 0}, {0.033, 0.035, 0}})
    EXPECT_LT(shadow + 40, brightness(image, lit));
}

// Ambient occlusion darkens the floor beside a wall, outside of its shadow.
TEST_F(MeshView, AmbientOcclusionDarkensCorners) {
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

// A scene without visible items shows the backdrop.
TEST_F(MeshView, EmptySceneIsBackdrop) {
  const TriMesh behind = test::sphere({0, -3, 0}, 0.1f);  // behind the eye
  const Image image = draw({{.mesh = &behind, .color = kRed}});
  EXPECT_EQ(find(image, is_red).count, 0);
  EXPECT_EQ(image.pixels, draw({}).pixels);
  EXPECT_LE(test::difference(image.at(50, 60), screen_color(backdrop(50.5f / kWidth, 60.5f / kHeight))), 3);
}

// Two threads that draw at once give the same picture as one.
TEST_F(MeshView, DrawingIsDeterministic) {
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

// A picture that is too large for OpenGL, or empty, is an error.
TEST_F(MeshView, RejectsInvalidSize) {
  const Result<Image> image = draw_meshes({}, kFront, 1 << 20, 8);
  ASSERT_FALSE(image);
  EXPECT_NE(image.error().message.find("1048576 x 8"), std::string::npos);
  EXPECT_FALSE(draw_meshes({}, kFront, 0, 8));
}

// Runs in its own process, which finds no OpenGL drivers.
void draw_without_driver() {
  setenv("__EGL_VENDOR_LIBRARY_FILENAMES", "/no/such/driver.json", 1);
  const Result<Image> image = draw_meshes({}, kFront, 8, 8);
  if (!image) std::fprintf(stderr, "%s\n", image.error().message.c_str());
  std::_Exit(image ? 1 : 0);
}

// Without an OpenGL driver drawing fails with a message and does not crash.
TEST(MeshViewDeathTest, MissingDriverIsError) {
  testing::FLAGS_gtest_death_test_style = "threadsafe";
  EXPECT_EXIT(draw_without_driver(), testing::ExitedWithCode(0), "cannot draw: .*EGL");
}

}  // namespace
}  // namespace turgor
