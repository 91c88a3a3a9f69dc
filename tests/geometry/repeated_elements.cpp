#include "turgor/geometry/repeated_elements.hpp"

#include <gtest/gtest.h>

#include "turgor/geometry/hex_block.hpp"

namespace turgor {
namespace {

// Sound meshes of tetrahedra and hexahedra repeat no element.
TEST(RepeatedElements, SoundMeshesHaveNone) {
  const SolidMesh block = hex_block({1, 1, 1}, {3, 2, 4});
  EXPECT_TRUE(repeated_elements(block).empty());
  EXPECT_TRUE(repeated_elements(tetrahedralize(block)).empty());
}

// A copy is found if its corners are in another order, or are other vertices with the same coordinates.
TEST(RepeatedElements, CopiesAreFoundInAnyOrder) {
  SolidMesh mesh = tetrahedralize(hex_block({1, 1, 1}, {2, 1, 1}));
  const std::size_t count = element_count(mesh);
  const std::vector<int> third(mesh.elements.begin() + 12, mesh.elements.begin() + 16);
  mesh.elements.insert(mesh.elements.end(), {third[2], third[0], third[1], third[3]});
  for (const int v : third) {
    mesh.elements.push_back(int(mesh.vertices.size()));
    mesh.vertices.push_back(mesh.vertices[std::size_t(v)]);
  }
  const std::vector<RepeatedElement> found = repeated_elements(mesh);
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].first, 3u);
  EXPECT_EQ(found[0].again, count);
  EXPECT_EQ(found[1].first, 3u);
  EXPECT_EQ(found[1].again, count + 1);
}

}  // namespace
}  // namespace turgor
