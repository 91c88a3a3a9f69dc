#include "turgor/models/lattice/surface/surface_plan.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/models/lattice/ct_body.hpp"
#include "turgor/models/lattice/lattice.hpp"

namespace turgor::lattice {
namespace {

/// A ball with an open cut and a displacement that is linear in no direction.
struct CutBall {
  Model model = body_of(ball_ct(40, 15), {3, 3, 3});
  State state = make_state(model);
  BodySurface surface;

  CutBall() {
    cut_across_y(model, state, 0.0193, [](Vec3d p) { return p.z > 0.02; });
    move(model, state, [](Vec3d p) {
      return Vec3d{0.002 * std::sin(90 * p.y), p.y >= 0.0193 ? 0.003 : 0.001 * std::cos(70 * p.z),
                   3 * p.x * p.z};
    });
    surface = build_surface(model, state.cuts);
  }
};

// The terms of a corner give the displacement of the corner, bit by bit; air next to tissue has terms.
TEST(SurfacePlan, TermsMatchCornerDisplacements) {
  const CutBall ball;
  const detail::SurfacePlan& plan = *ball.surface.plan;
  int with_terms = 0, extrapolated = 0;
  for (std::size_t c = 0; c < plan.corners.size(); c++) {
    const auto begin = std::size_t(plan.term_begin[c]), end = std::size_t(plan.term_begin[c + 1]);
    if (begin == end) continue;
    const Vec3 mean = mean_of_terms(std::span(plan.terms).subspan(begin, end - begin), ball.state.motion.u);
    const Vec3 expected =
        corner_displacement(ball.model, ball.state, *ball.surface.fragments, plan.corners[c]);
    ASSERT_EQ(mean, expected) << "corner " << plan.corners[c];
    with_terms++, extrapolated += plan.terms[begin].far >= 0;
  }
  EXPECT_GT(with_terms, 300);
  EXPECT_GT(extrapolated, 30);
}

// Vertices of the deformed surface have the displacements that are found vertex by vertex.
TEST(SurfacePlan, VerticesMatchVertexDisplacement) {
  const CutBall ball;
  const TriMesh mesh = deformed_surface(ball.model, ball.state, ball.surface, Shown::kDisplacement);
  ASSERT_EQ(mesh.scalars.size(), ball.surface.rest.size());
  for (std::size_t v = 0; v < mesh.scalars.size(); v++)
    ASSERT_NEAR(mesh.scalars[v], norm(vertex_displacement(ball.model, ball.state, ball.surface, int(v))),
                1e-9);
}

// A surface without its plan, and any number of threads, give the same bits.
TEST(SurfacePlan, SurfaceWithoutPlanHasSameBits) {
  CutBall ball;
  const TriMesh with = deformed_surface(ball.model, ball.state, ball.surface, Shown::kStretch, Exec(2));
  ball.surface.plan = nullptr;
  const TriMesh without = deformed_surface(ball.model, ball.state, ball.surface, Shown::kStretch);
  EXPECT_EQ(with.vertices, without.vertices);
  EXPECT_EQ(with.normals, without.normals);
  EXPECT_EQ(with.scalars, without.scalars);
}

// Every vertex lists the triangles around it, ascending.
TEST(SurfacePlan, TrianglesAroundVertices) {
  const CutBall ball;
  const detail::SurfacePlan& plan = *ball.surface.plan;
  std::size_t count = 0;
  for (std::size_t v = 0; v < ball.surface.rest.size(); v++) {
    int last = -1;
    for (const int at : plan.triangles_of(v)) {
      ASSERT_GT(at, last);
      ASSERT_EQ(ball.surface.triangles[std::size_t(at / 3)][at % 3], int(v));
      last = at, count++;
    }
  }
  EXPECT_EQ(count, 3 * ball.surface.triangles.size());
}

}  // namespace
}  // namespace turgor::lattice
