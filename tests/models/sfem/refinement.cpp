#include "turgor/models/sfem/refinement.hpp"

#include <map>
#include <set>

#include "tests/models/sfem/dense.hpp"

namespace turgor::sfem {
namespace {

constexpr int kKinds[] = {4, 8, 10};  // corners

Model block_model(int corners) {
  SolidMesh mesh = hex_block({0.2, 0.2, 0.2}, {2, 2, 2});
  distort(mesh, {0.2, 0.2, 0.2}, 0.03);
  mesh = with_corners(mesh, corners);
  return densely_solved(block_of(std::move(mesh), {}, [](Vec3d x) { return x.z < 1e-9; }), {});
}

SolidMesh solid(const FineMesh& fine, int corners) {
  SolidMesh mesh;
  mesh.corners = corners, mesh.elements = fine.corners;
  for (const FineNode& node : fine.nodes) mesh.vertices.push_back(node.x);
  return mesh;
}

std::vector<int> all_elements(const Model& model) {
  std::vector<int> all;
  for (std::size_t e = 0; e < element_count(model.body.mesh); e++) all.push_back(int(e));
  return all;
}

// Subelements fill their elements and have positive orientation.
TEST(SfemRefinement, SubelementsFillElements) {
  for (const int corners : kKinds) {
    const Model model = block_model(corners);
    for (int r = 1; r <= 4; r++) {
      const FineMesh fine = refine(model, all_elements(model), r);
      const SolidMesh mesh = solid(fine, model.body.mesh.corners);
      EXPECT_EQ(element_count(mesh), element_count(model.body.mesh) * std::size_t(r * r * r));
      EXPECT_NEAR(volume(mesh), 0.008, 1e-14);
      for (std::size_t e = 0; e < element_count(mesh); e++) EXPECT_GT(volume(mesh, e), 0) << e;
    }
  }
}

// Neighbors agree on their common face.
TEST(SfemRefinement, NeighborsShareFaces) {
  for (const int corners : kKinds) {
    const Model model = block_model(corners);
    for (int r = 2; r <= 4; r++) {
      const FineMesh fine = refine(model, all_elements(model), r);
      const SolidMesh mesh = solid(fine, model.body.mesh.corners);
      const int nodes = (corners == 10 ? 4 : 2) * r;  // nodes per side, minus one
      EXPECT_EQ(mesh.vertices.size(), std::size_t((nodes + 1) * (nodes + 1) * (nodes + 1)));
      // A hole in the interior would be surface too.
      const std::size_t expected = std::size_t(6 * nodes * nodes * 2);
      EXPECT_EQ(surface(mesh).triangles.size(), expected);
      EXPECT_EQ(fine.outer.size(), expected);
    }
  }
}

// The weights of a fine node give its position.
TEST(SfemRefinement, WeightsGiveNodePositions) {
  for (const int corners : kKinds) {
    Model model = block_model(corners);
    for (int& row : model.free_node) row = 0;  // so that no support is omitted
    for (const FineNode& node : refine(model, std::vector<int>{0, 1, 2}, 3).nodes) {
      Vec3d x;
      for (std::size_t s = 0; s < std::size_t(node.supports); s++)
        x += model.body.mesh.vertices[std::size_t(node.coarse[s])] * node.weight[s];
      EXPECT_LT(norm(x - node.x), 1e-15);
    }
  }
}

// A fine node has the same key in every patch.
TEST(SfemRefinement, NodeKeysAreUnique) {
  for (const int corners : {4, 10}) {
    const Model model = block_model(corners);
    std::map<std::uint64_t, Vec3d> all;
    for (const FineNode& node : refine(model, all_elements(model), 3).nodes) all[node.key] = node.x;
    for (int e = 0; e < int(element_count(model.body.mesh)); e++)
      for (const FineNode& node : refine(model, std::vector<int>{e}, 3).nodes) {
        ASSERT_TRUE(all.count(node.key));
        EXPECT_LT(norm(all[node.key] - node.x), 1e-15);
      }
  }
}

// Border nodes lie where the patch ends inside the body.
TEST(SfemRefinement, BorderIsInsideBody) {
  const Model model = densely_solved(clamped_plate(4, 1), {});
  const FineMesh fine = refine(model, std::vector<int>{5, 6, 9, 10}, 2);
  int border = 0, own = 0, vertices = 0;
  for (const FineNode& node : fine.nodes) {
    const bool on_side = node.x.x < 0.0251 || node.x.x > 0.0749 || node.x.y < 0.0251 || node.x.y > 0.0749;
    EXPECT_EQ(node.on_border, on_side);
    border += node.on_border, vertices += node.at_vertex;
    own += !node.on_border && !node.at_vertex && !node.fixed;
  }
  EXPECT_EQ(fine.nodes.size(), 75u);
  EXPECT_EQ(vertices, 18);
  EXPECT_EQ(own, 25);  // the paper's count
}

// Nodes on fixed outer faces are fixed.
TEST(SfemRefinement, FixedFacesStayFixed) {
  for (const int corners : {4, 10}) {
    const Model model = block_model(corners);
    for (const FineNode& node : refine(model, all_elements(model), 3).nodes)
      EXPECT_EQ(node.fixed, node.x.z < 1e-12) << node.x.z;
  }
}

}  // namespace
}  // namespace turgor::sfem
