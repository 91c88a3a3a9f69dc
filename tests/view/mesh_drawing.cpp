#include "turgor/view/mesh_drawing.hpp"

#include <gtest/gtest.h>

#include "tests/view/shapes.hpp"
#include "turgor/view/gl_context.hpp"

namespace turgor {
namespace {

constexpr int kWidth = 400, kHeight = 300;
constexpr Camera kFront{.eye = {0, -1, 0}, .target = {0, 0, 0}};
constexpr Rgb kRed{210, 20, 20}, kGreen{20, 190, 20};

bool is_red(Rgb c) { return c.r > 2 * c.g && c.r > 2 * c.b && c.r > 40; }
bool is_green(Rgb c) { return c.g > 2 * c.r && c.g > 2 * c.b && c.g > 40; }

/// Draws as a window does: in a context that is held already, again and again into the same textures.
class MeshDrawingTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!gl_) GTEST_SKIP() << gl_.error().message;
    const Result<MeshPrograms> programs = link_mesh_programs();
    ASSERT_TRUE(programs) << programs.error().message;
    drawing_.programs = *programs;
  }
  Image draw(const std::vector<MeshPart>& parts, MeshCare care, MeshStyle style = MeshStyle::kSurface) {
    const Result<GLuint> drawn = draw_into_texture(drawing_, parts, kFront, kWidth, kHeight, care, style);
    EXPECT_TRUE(drawn) << drawn.error().message;
    return read_pixels(kWidth, kHeight);
  }
  static test::Found find(const Image& image, bool (*wanted)(Rgb)) {
    return test::find_pixels(image, [&](int x, int y) { return wanted(image.at(x, y)); });
  }

  Result<CurrentGl> gl_ = hold_gl();
  MeshDrawing drawing_;
};

TEST_F(MeshDrawingTest, a_quick_picture_shows_the_bodies_of_a_full_one_where_that_shows_them) {
  const TriMesh left = test::sphere({-0.1f, 0.05f, 0}, 0.09f), right = test::sphere({0.12f, 0, 0.06f}, 0.07f);
  const std::vector<MeshPart> parts = {{.mesh = &left, .color = kRed}, {.mesh = &right, .color = kGreen}};
  const Image full = draw(parts, MeshCare::kFull), quick = draw(parts, MeshCare::kQuick);
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

TEST_F(MeshDrawingTest, colors_of_a_quantity_are_those_of_the_map_in_a_quick_picture_too) {
  const ColorScale scale{.low = 0, .high = 2, .label = "", .factor = 1};
  TriMesh low = test::sphere({-0.12f, 0, 0}, 0.08f), high = test::sphere({0.12f, 0, 0}, 0.08f);
  low.scalars.assign(low.vertices.size(), 0.0f), high.scalars.assign(high.vertices.size(), 2.0f);
  const Image image =
      draw({{.mesh = &low, .scale = &scale}, {.mesh = &high, .scale = &scale}}, MeshCare::kQuick);
  const Vec3d at_low = test::project(kFront, {-0.12, 0, 0}, kWidth, kHeight),
              at_high = test::project(kFront, {0.12, 0, 0}, kWidth, kHeight);
  const Rgb a = image.at(int(at_low.x), int(at_low.y)), b = image.at(int(at_high.x), int(at_high.y));
  EXPECT_GT(a.b, a.g) << "indigo";
  EXPECT_GT(b.r + b.g, 3 * b.b) << "yellow";
}

TEST_F(MeshDrawingTest, wires_leave_most_of_a_surface_open) {
  const TriMesh mesh = test::sphere({}, 0.15f, 12);
  for (const MeshCare care : {MeshCare::kQuick, MeshCare::kFull}) {
    const int whole = find(draw({{.mesh = &mesh, .color = kRed}}, care), is_red).count;
    const int wires = find(draw({{.mesh = &mesh, .color = kRed}}, care, MeshStyle::kWires), is_red).count;
    EXPECT_GT(wires, whole / 50);
    EXPECT_LT(wires, whole / 2);
  }
}

TEST_F(MeshDrawingTest, another_size_is_drawn_into_other_textures) {
  const TriMesh mesh = test::sphere({}, 0.1f, 8);
  draw({{.mesh = &mesh, .color = kRed}}, MeshCare::kQuick);
  const Result<GLuint> wide =
      draw_into_texture(drawing_, {{.mesh = &mesh, .color = kRed}}, kFront, 640, 200, MeshCare::kQuick);
  ASSERT_TRUE(wide);
  const auto found = find(read_pixels(640, 200), is_red);
  EXPECT_NEAR(found.x, 320, 1);
  EXPECT_NEAR(found.y, 100, 1);
}

}  // namespace
}  // namespace turgor
