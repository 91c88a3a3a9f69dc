#include "turgor/models/sfem/inner_green.hpp"

#include <gtest/gtest.h>

#include "turgor/geometry/hex_block.hpp"

namespace turgor::sfem {
namespace {

Model small_block(int corners) {
  Body body;
  body.mesh = hex_block({0.03, 0.03, 0.03}, {3, 3, 3});
  if (corners != 8) body.mesh = tetrahedralize(body.mesh);
  for (const Vec3d x : body.mesh.vertices) body.fixed.push_back(x.z < 1e-9);
  body.materials = {{3e3, 0.4}};
  if (corners == 10) body = with_middles(std::move(body));
  Model model = *build(Exec(2), std::move(body), {});
  EXPECT_TRUE(factorize(Exec(2), model));
  return model;
}

// The displacement of an inner point under a force on another one is that of a solution of the whole body.
TEST(InnerGreen, MatchesSolutionOfWholeBody) {
  for (const int corners : {4, 8, 10}) {
    const Model model = small_block(corners);
    const SolidMesh& mesh = model.body.mesh;
    std::vector<int> elements;
    for (int e = 0; e < int(element_count(mesh)); e++)
      if (centroid(mesh, std::size_t(e)).x < 0.02) elements.push_back(e);
    const InnerGreen inner = make_inner_green(Exec(2), model, elements);
    const Vec3d p{0.004, 0.013, 0.018}, q{0.012, 0.022, 0.009}, force{0.3, -0.2, 0.5};
    double outside = 1;
    const InnerPoint at_p = inner_point(inner, p, -1, outside), at_q = inner_point(inner, q, 0, outside);
    EXPECT_EQ(outside, 0);
    // weights reproduce the position
    EXPECT_LT(norm(at_point(inner, at_p, inner.x) - p), 1e-12);
    // solution with the force on the vertices
    std::vector<Vec3d> on_vertices(inner.vertices.size());
    add_force(inner, at_q, force, on_vertices);
    std::vector<double> u(3 * model.vertex.size());
    for (std::size_t i = 0; i < inner.vertices.size(); i++)
      if (const int row = model.free_node[std::size_t(inner.vertices[i])]; row >= 0)
        for (std::size_t axis = 0; axis < 3; axis++)
          u[3 * std::size_t(row) + axis] = on_vertices[i][int(axis)];
    solve(*model.factor, u);
    std::vector<Vec3d> displacement(inner.vertices.size());
    for (std::size_t i = 0; i < inner.vertices.size(); i++)
      if (const int row = model.free_node[std::size_t(inner.vertices[i])]; row >= 0)
        displacement[i] = {u[3 * std::size_t(row)], u[3 * std::size_t(row) + 1], u[3 * std::size_t(row) + 2]};
    const Vec3d expected = at_point(inner, at_p, displacement);
    // the same from the block
    const ComplianceBlock c = compliance_between(inner, at_p, at_q);
    const Vec3d found{c[0] * force.x + c[3] * force.y + c[6] * force.z,
                      c[1] * force.x + c[4] * force.y + c[7] * force.z,
                      c[2] * force.x + c[5] * force.y + c[8] * force.z};
    EXPECT_LT(norm(found - expected), 1e-5 * norm(expected));
  }
}

// A position outside is extrapolated, and the distance is reported.
TEST(InnerGreen, PositionOutsideIsReported) {
  const Model model = small_block(4);
  const InnerGreen inner = make_inner_green(Exec(1), model, {0, 1, 2, 3, 4, 5});
  double outside = 0;
  const InnerPoint point = inner_point(inner, {0.001, 0.002, -0.002}, -1, outside);
  EXPECT_GT(outside, 0.05);
  EXPECT_LT(norm(at_point(inner, point, inner.x) - Vec3d{0.001, 0.002, -0.002}), 1e-12);
}

}  // namespace
}  // namespace turgor::sfem
