#include <gtest/gtest.h>

#include "tests/models/sfem/bodies.hpp"

namespace turgor::sfem {
namespace {

Body held_block() {
  return block_of(hex_block({0.1, 0.1, 0.1}, {2, 2, 2}), {1e4, 0.3}, [](Vec3d x) { return x.z == 0; });
}

std::string refusal(Body body, const Params& params = {}) {
  const Result<Model> model = build(Exec(1), std::move(body), params);
  return model ? "" : model.error().message;
}

bool contains(const std::string& text, const std::string& piece) {
  return text.find(piece) != std::string::npos;
}

// Free vertices get rows; the stored nodes begin with those of the surface.
TEST(SfemBuild, SurfaceNodesComeFirst) {
  const Model model = build(Exec(1), held_block(), {.touch_depth = 0.1}).value();
  EXPECT_EQ(model.vertex.size(), 18u);
  EXPECT_EQ(model.free_node[0], -1);
  EXPECT_EQ(model.vertex[0], 9);
  EXPECT_EQ(model.green.surface_count, 17u);
  ASSERT_EQ(model.green.nodes.size(), 18u);
  EXPECT_EQ(model.green.nodes.back(), 13);  // the center
  EXPECT_EQ(model.green.slot[13], 17);
  EXPECT_EQ(model.green.slot[0], -1);
}

// Nodes deeper than touch_depth below the surface are not stored.
TEST(SfemBuild, DeepNodesAreNotStored) {
  Body body = block_of(hex_block({1, 1, 1}, {10, 10, 10}), {1e4, 0.3}, [](Vec3d x) { return x.z == 0; });
  const Model shallow = build(Exec(1), body, {.touch_depth = 0}).value();
  const Model deep =
      build(Exec(1), body, {.touch_depth = 0.16}).value();  // centers of the second layer: 0.15
  const Model whole = build(Exec(1), body, {.touch_depth = 0.5}).value();
  EXPECT_EQ(shallow.green.nodes.size(), 11u * 11 * 10 - 7 * 7 * 7);
  EXPECT_EQ(deep.green.nodes.size(), 11u * 11 * 10 - 5 * 5 * 5);
  EXPECT_EQ(whole.green.nodes.size(), 11u * 11 * 10);
}

// Vertices without elements have no row.
TEST(SfemBuild, IsolatedVerticesHaveNoRow) {
  Body body = held_block();
  body.mesh.vertices.push_back({5, 5, 5});
  body.fixed.push_back(0);
  const Model model = build(Exec(1), body, {}).value();
  EXPECT_EQ(model.vertex.size(), 18u);
  EXPECT_EQ(model.free_node.back(), -1);
}

// A body without elements, or with invalid ones, is rejected.
TEST(SfemBuild, RejectsMissingOrInvalidElements) {
  Body body = held_block();
  body.mesh.elements.clear();
  EXPECT_EQ(refusal(body), "the body has no element");
  body = held_block();
  body.mesh.elements[8] = 99;
  EXPECT_EQ(refusal(body), "element 1 has vertex 99, expected 0 to 26");
  body = held_block();
  body.mesh.vertices[13].y = NAN;
  EXPECT_TRUE(contains(refusal(body), "vertex number 13"));
}

// A body that lists an element twice is rejected with both numbers.
TEST(SfemBuild, RejectsRepeatedElements) {
  Body body = held_block();
  const std::vector<int> second(body.mesh.elements.begin() + 8, body.mesh.elements.begin() + 16);
  body.mesh.elements.insert(body.mesh.elements.end(), second.begin(), second.end());
  EXPECT_TRUE(contains(refusal(body), "element 8, which repeats element 1")) << refusal(body);
}

// The error names elements with zero or negative volume.
TEST(SfemBuild, NamesElementsWithoutVolume) {
  Body body = held_block();
  std::swap(body.mesh.elements[24], body.mesh.elements[28]);  // element 3 is inverted
  EXPECT_TRUE(contains(refusal(body), "negative")) << refusal(body);
  EXPECT_TRUE(contains(refusal(body), "element 3")) << refusal(body);
  body = held_block();
  for (std::size_t v = 18; v < 27; v++) body.mesh.vertices[v].z = 0.05;  // the upper layer is flat
  EXPECT_TRUE(contains(refusal(body), "zero in elements 4, 5, 6, 7")) << refusal(body);
  body = held_block();
  body.mesh = tetrahedralize(body.mesh);
  std::swap(body.mesh.elements[4], body.mesh.elements[5]);
  EXPECT_TRUE(contains(refusal(body), "element 1")) << refusal(body);
}

// Invalid materials and empty inclusions are rejected.
TEST(SfemBuild, RejectsInvalidMaterials) {
  Body body = held_block();
  body.materials[0].poisson = 0.5;
  EXPECT_EQ(refusal(body), "material 0: Poisson's ratio must be above -1 and below 0.5, found 0.5");
  body.materials[0] = {-1, 0.3};
  EXPECT_EQ(refusal(body), "material 0: Young's modulus must be above 0 Pa, found -1");
  body.materials[0] = {NAN, 0.3};
  EXPECT_TRUE(contains(refusal(body), "Young's modulus"));
  body = held_block();
  body.material = {0, 0, 0, 0, 0, 2, 0, 0};
  EXPECT_EQ(refusal(body), "materials are 0 to 0, found 2 in element 5");
  body = held_block();
  body.inclusions = {{{0.05, 0.05, 0.05}, 0.01, 0}};
  EXPECT_TRUE(contains(refusal(body), "inclusion 0 holds no element")) << refusal(body);
}

// A body whose fixed vertices do not prevent rigid motion is rejected.
TEST(SfemBuild, RejectsBodyWithoutSupport) {
  Body body = held_block();
  body.fixed.assign(27, 0);
  EXPECT_EQ(refusal(body), "no vertex of the body is fixed: nothing holds it");
  body.fixed.assign(27, 1);
  EXPECT_EQ(refusal(body), "all vertices of the body are fixed: nothing can move");
  body.fixed.assign(27, 0);
  body.fixed[0] = body.fixed[1] = body.fixed[2] = 1;  // a hinge
  EXPECT_TRUE(contains(refusal(body), "on a line")) << refusal(body);
  EXPECT_TRUE(contains(refusal(body), "vertex numbers 0, 1, 2")) << refusal(body);
  body.fixed[4] = 1;
  EXPECT_EQ(refusal(body), "");
}

// A component that is attached by an edge only is rejected; a third vertex supports it.
TEST(SfemBuild, RejectsComponentOnHinge) {
  Body body = block_of(hex_block({2, 2, 1}, {2, 2, 1}), {1e4, 0.3}, [](Vec3d x) { return x.x == 0; });
  std::vector<int> elements;
  for (const std::size_t e : {0u, 3u})
    for (const int v : element(body.mesh, e)) elements.push_back(v);
  body.mesh.elements = elements;
  EXPECT_TRUE(contains(refusal(body), "8 vertices, among them vertex 4; none is fixed")) << refusal(body);
  const int beside = vertex_at(body.mesh, {2, 1, 0});
  body.fixed[std::size_t(beside)] = 1;  // together with the edge, which the other component holds
  EXPECT_EQ(refusal(body), "");
}

// The content hash distinguishes bodies and parameters.
TEST(SfemBuild, HashDistinguishesBodies) {
  const auto hash = [](const Body& body, const Params& params) {
    return content_hash(build(Exec(1), body, params).value());
  };
  const Body body = held_block();
  const std::uint64_t first = hash(body, {});
  EXPECT_EQ(first, hash(body, {}));
  Body other = body;
  other.mesh.vertices[13].x += 1e-9;
  EXPECT_NE(first, hash(other, {}));
  other = body;
  other.materials[0].poisson = 0.31;
  EXPECT_NE(first, hash(other, {}));
  other = body;
  other.fixed[9] = 1;
  EXPECT_NE(first, hash(other, {}));
  other = body;
  other.materials.push_back({2e4, 0.3});
  EXPECT_EQ(first, hash(other, {}));  // no element has this material
  other.inclusions = {{{0, 0, 0}, 0.05, 1}};
  EXPECT_NE(first, hash(other, {}));
  EXPECT_NE(first, hash(body, {.formulation = Formulation::kAveraged}));
  EXPECT_NE(first, hash(body, {.precision = Precision::kDouble}));
}

}  // namespace
}  // namespace turgor::sfem
