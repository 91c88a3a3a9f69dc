// Items of a picture: the walls of a wound have the vertices that they use, and no others.
#include "turgor/pictures/picture_items.hpp"

#include <gtest/gtest.h>

namespace turgor {
namespace {

// Every wall triangle has its corners and normals, and the skin keeps its own.
TEST(PictureItems, WallsHaveOwnVertices) {
  BodySnapshot body;
  body.look = Look::kSkin;
  for (int n = 0; n < 12; n++) {
    body.x.push_back({float(n), float(n * n), 1});
    body.normals.push_back({0, float(n), 1});
  }
  body.triangles = {{0, 1, 2}, {2, 1, 3}, {0, 3, 4}, {7, 6, 9}, {9, 6, 8}};
  body.wall_begin = 3;
  PictureItems items;
  add_body(body, SkinColor::kNone, nullptr, items, {});
  ASSERT_EQ(items.items.size(), 2u);
  const TriMesh &walls = *items.items[0].mesh, &skin = *items.items[1].mesh;
  ASSERT_EQ(walls.triangles.size(), 2u);
  EXPECT_EQ(walls.vertices.size(), 4u);
  for (std::size_t t = 0; t < 2; t++)
    for (int c = 0; c < 3; c++) {
      const auto whole = std::size_t(body.triangles[3 + t][c]), own = std::size_t(walls.triangles[t][c]);
      EXPECT_EQ(walls.vertices[own], body.x[whole]);
      EXPECT_EQ(walls.normals[own], body.normals[whole]);
    }
  EXPECT_EQ(skin.triangles, (std::vector<Int3>{{0, 1, 2}, {2, 1, 3}, {0, 3, 4}}));
  EXPECT_EQ(skin.vertices, body.x);
}

// The caps of a body, where its CT ends, have the color of its sections and not that of skin.
TEST(PictureItems, CapsHaveColorOfSections) {
  BodySnapshot body;
  body.look = Look::kSkin;
  for (int n = 0; n < 12; n++) {
    body.x.push_back({float(n), float(n * n), 1});
    body.normals.push_back({0, float(n), 1});
  }
  body.triangles = {{0, 1, 2}, {2, 1, 3}, {5, 4, 6}, {7, 6, 9}, {9, 6, 8}};
  body.wall_begin = 4, body.cap_count = 2;
  EXPECT_EQ(outer_triangles(body).size(), 2u);
  PictureItems items;
  add_body(body, SkinColor::kNone, nullptr, items, {});
  ASSERT_EQ(items.items.size(), 3u);
  EXPECT_TRUE(items.items[0].color == kWallColor);
  EXPECT_TRUE(items.items[1].color == section_color(body));
  EXPECT_TRUE(items.items[2].color == natural_color(body));
  EXPECT_FALSE(items.items[2].color == section_color(body));
  EXPECT_EQ(items.items[1].mesh->triangles.size(), 2u);
  EXPECT_EQ(items.items[2].mesh->triangles, (std::vector<Int3>{{0, 1, 2}, {2, 1, 3}}));
}

}  // namespace
}  // namespace turgor
