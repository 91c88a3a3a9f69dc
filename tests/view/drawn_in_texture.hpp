// Pictures of meshes, drawn in a current OpenGL context as the window draws them.
#pragma once

#include <vector>

#include <gtest/gtest.h>

#include "turgor/view/gl_context.hpp"
#include "turgor/view/mesh_drawing.hpp"

namespace turgor::test {

inline bool is_red(Rgb c) { return c.r > 2 * c.g && c.r > 2 * c.b && c.r > 40; }
inline bool is_green(Rgb c) { return c.g > 2 * c.r && c.g > 2 * c.b && c.g > 40; }

/// Draws repeatedly into the same textures. Skips its tests without OpenGL.
class DrawnInTexture : public testing::Test {
 protected:
  static constexpr int kWidth = 400, kHeight = 300;  // of the pictures [pixels]

  void SetUp() override {
    if (!gl_) GTEST_SKIP() << gl_.error().message;
    const Result<MeshPrograms> programs = link_mesh_programs();
    ASSERT_TRUE(programs) << programs.error().message;
    drawing_.programs = *programs;
  }
  Image draw(const std::vector<RenderItem>& items, const Camera& camera, RenderQuality quality,
             MeshStyle style = MeshStyle::kSurface) {
    const Result<GLuint> drawn = draw_into_texture(drawing_, items, camera, kWidth, kHeight, quality, style);
    EXPECT_TRUE(drawn) << drawn.error().message;
    return read_pixels(kWidth, kHeight);
  }

  Result<CurrentGl> gl_ = hold_gl();
  MeshDrawing drawing_;
};

}  // namespace turgor::test
