#include "turgor/view/mesh_drawing.hpp"

#include "tests/view/drawn_in_texture.hpp"
#include "tests/view/shapes.hpp"

namespace turgor {
namespace {

constexpr Camera kFront{.eye = {0, -1, 0}, .target = {0, 0, 0}};
constexpr Rgb kRed{210, 20, 20}, kGreen{20, 190, 20};

using test::is_green;
using test::is_red;

class MeshDrawingTest : public test::DrawnInTexture {
 protected:
  Image draw(const std::vector<RenderItem>& items, RenderQuality quality,
             MeshStyle style = MeshStyle::kSurface) {
    return DrawnInTexture::draw(items, kFront, quality, style);
  }
  static test::Found find(const Image& image, bool (*wanted)(Rgb)) {
    return test::find_pixels(image, [&](int x, int y) { return wanted(image.at(x, y)); });
  }
};

// A quick picture shows the same bodies at the same positions as a full one.
TEST_F(MeshDrawingTest, QuickMatchesFullQuality) {
  const TriMesh left = test::sphere({-0.1f, 0.05f, 0}, 0.09f), right = test::sphere({0.12f, 0, 0.06f}, 0.07f);
  const std::vector<RenderItem> items = {{.mesh = &left, .color = kRed}, {.mesh = &right, .color = kGreen}};
  const Image full = draw(items, RenderQuality::kFull), quick = draw(items, RenderQuality::kQuick);
  for (const auto is_wanted : {is_red, is_green}) {
    const auto a = find(full, is_wanted), b = find(quick, is_wanted);
    ASSERT_GT(a.count, 1000);
    EXPECT_NEAR(b.count, a.count, 0.04 * a.count);
    EXPECT_NEAR(b.x, a.x, 1);
    EXPECT_NEAR(b.y, a.y, 1);
  }
  for (const auto& [x, y] : {std::pair{2, 2}, {kWidth - 3, 2}, {kWidth / 2, kHeight - 3}})
    EXPECT_LE(test::difference(full.at(x, y), quick.at(x, y)), 6) << "the backdrop at " << x << ", " << y;
}

// A quick picture colors scalars by the color map.
TEST_F(MeshDrawingTest, QuickUsesColorMap) {
  const ColorScale scale{.low = 0, .high = 2, .label = "", .factor = 1};
  TriMesh low = test::sphere({-0.12f, 0, 0}, 0.08f), high = test::sphere({0.12f, 0, 0}, 0.08f);
  low.scalars.assign(low.vertices.size(), 0.0f), high.scalars.assign(high.vertices.size(), 2.0f);
  const Image image =
      draw({{.mesh = &low, .scale = &scale}, {.mesh = &high, .scale = &scale}}, RenderQuality::kQuick);
  const Vec3d at_low = test::project(kFront, {-0.12, 0, 0}, kWidth, kHeight),
              at_high = test::project(kFront, {0.12, 0, 0}, kWidth, kHeight);
  const Rgb a = image.at(int(at_low.x), int(at_low.y)), b = image.at(int(at_high.x), int(at_high.y));
  EXPECT_GT(a.b, a.g) << "indigo";
  EXPECT_GT(b.r + b.g, 3 * b.b) << "yellow";
}

// A wireframe covers less than half of the surface.
TEST_F(MeshDrawingTest, WireframeCoversSmallArea) {
  const TriMesh mesh = test::sphere({}, 0.15f, 12);
  for (const RenderQuality quality : {RenderQuality::kQuick, RenderQuality::kFull}) {
    const int whole = find(draw({{.mesh = &mesh, .color = kRed}}, quality), is_red).count;
    const int wires = find(draw({{.mesh = &mesh, .color = kRed}}, quality, MeshStyle::kWires), is_red).count;
    EXPECT_GT(wires, whole / 50);
    EXPECT_LT(wires, whole / 2);
  }
}

// A picture of another size is drawn into new textures.
TEST_F(MeshDrawingTest, ResizingReallocatesTextures) {
  const TriMesh mesh = test::sphere({}, 0.1f, 8);
  draw({{.mesh = &mesh, .color = kRed}}, RenderQuality::kQuick);
  const Result<GLuint> wide =
      draw_into_texture(drawing_, {{.mesh = &mesh, .color = kRed}}, kFront, 640, 200, RenderQuality::kQuick);
  ASSERT_TRUE(wide);
  const auto found = find(read_pixels(640, 200), is_red);
  EXPECT_NEAR(found.x, 320, 1);
  EXPECT_NEAR(found.y, 100, 1);
}

}  // namespace
}  // namespace turgor
