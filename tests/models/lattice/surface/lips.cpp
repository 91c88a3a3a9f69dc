// Lips of drawn wounds lie on the blade that made them, and move with the tissue where they lie.
#include <map>
#include <set>

#include <gtest/gtest.h>

#include "tests/models/lattice/surface/cut_ball.hpp"

namespace turgor::lattice {
namespace {

using test::BallBody;
using test::CutBody;
using test::kRadius;
using test::kVoxels;
using test::RandomCut;

/// Distance to the nearest point of a sheet [m].
double distance_to(const BladeSheet& sheet, Vec3d position) {
  double least = 1;
  for (const SheetTriangle& t : sheet.triangles) {
    const Vec3d away = position - t.corner;
    const double a = dot(t.side1, t.side1), b = dot(t.side1, t.side2), c = dot(t.side2, t.side2),
                 det = a * c - b * b, p = dot(t.side1, away), q = dot(t.side2, away);
    const double s = (c * p - b * q) / det, u = (a * q - b * p) / det;
    if (s >= 0 && u >= 0 && s + u <= 1) least = std::min(least, norm(away - t.side1 * s - t.side2 * u));
    for (const auto& [from, along] :
         {std::pair{Vec3d{}, t.side1}, {Vec3d{}, t.side2}, {t.side1, t.side2 - t.side1}}) {
      const double at = std::clamp(dot(away - from, along) / dot(along, along), 0.0, 1.0);
      least = std::min(least, norm(away - from - along * at));
    }
  }
  return least;
}

/// Edges on the border of the skin, without caps.
std::vector<std::pair<int, int>> border_of_skin(const BodySurface& surface) {
  std::set<std::pair<int, int>> edges;
  for (int n = 0; n < surface.skin_triangles - surface.cap_triangles; n++) {
    const Int3 t = surface.triangles[std::size_t(n)];
    for (int c = 0; c < 3; c++) edges.insert({t[c], t[(c + 1) % 3]});
  }
  std::vector<std::pair<int, int>> border;
  for (const auto& [a, b] : edges)
    if (!edges.contains({b, a})) border.push_back({a, b});
  return border;
}

/// Vertices on the border of the skin.
std::set<int> lip_vertices(const BodySurface& surface) {
  std::set<int> vertices;
  for (const auto& [a, b] : border_of_skin(surface)) vertices.insert({a, b});
  return vertices;
}

/// Largest distance of the lips from their own blade, in fine edges, away from its ends.
double distance_of_lips(const CutBody& body) {
  const BodySurface surface = body.surface();
  const double margin = 3 * body.ball.fine_edge();
  double most = 0;
  for (const Lip& lip : surface.lips) {
    const double length = path_length(body.paths[lip.incision]);
    if (double(lip.along) < margin || double(lip.along) > length - margin) continue;
    most = std::max(most, distance_to(body.sheets[lip.incision], Vec3d(surface.rest[std::size_t(lip.left)])));
  }
  return most / body.ball.fine_edge();
}

/// T: a slightly curved bar, and a stem that ends on it.
CutBody t_cut(const BallBody& ball, double slope, double shift) {
  CutBody body{ball};
  const Vec3d end = ball.on_skin(0.3 + shift, 3.2 + shift);
  body.cut(
      {.path = {ball.on_skin(-10, 3 - 10 * slope + shift), end, ball.on_skin(10, 3 + 10 * slope + shift)},
       .depth = 0.008});
  body.cut({.from = ball.on_skin(-0.6 - 2 * slope, -9), .to = end, .depth = 0.008});
  return body;
}

// The lips of a straight, an oblique, an S-shaped and a tilted cut lie on the blade.
TEST(Lips, LieOnBlade) {
  const BallBody ball(3);
  for (const double shift : {0.0, 0.47, 0.71}) {
    const auto expect_on_blade = [&](const Incision& incision, double most, const char* shape) {
      CutBody body{ball};
      body.cut(incision);
      EXPECT_LT(distance_of_lips(body), most) << shape << ", shifted by " << shift;
    };
    const auto at = [&](double x, double y) { return ball.on_skin(x, y); };
    expect_on_blade({.from = at(-9.3 + shift, 1.1 + shift), .to = at(10.2, -2.3 - shift), .depth = 0.008},
                    0.02, "straight");
    expect_on_blade({.from = at(-7 + shift, -7.2 + shift), .to = at(7.1, 7), .depth = 0.008}, 0.02,
                    "oblique");
    expect_on_blade(
        {.path = {at(shift, 11), at(5 + shift, 6), at(shift, 0), at(-5 + shift, -6), at(shift, -11)},
         .depth = 0.008},
        0.15, "S");
    expect_on_blade(
        {.path = {at(-10, 2 + shift), at(0, -4 + shift), at(10, 2 + shift)}, .depth = 0.008, .tilt = -50},
        0.15, "tilted");
  }
}

// All three lips of a T lie on its blades: the lip of the bar has no notch where the stem ends on it.
TEST(Lips, LieOnBothBladesOfT) {
  const BallBody ball(1);
  EXPECT_LT(distance_of_lips(t_cut(ball, 0.12, 0)), 0.1) << "fine edges";
}

// Lips move with the cells in which they lie: a skin point that is moved onto a tilted blade may lie in
// another cell than the fine node of its side, and would be a tooth if that cell's motion were extrapolated
// to it.
TEST(Lips, LieInTheirCells) {
  const BallBody ball(3);
  CutBody body{ball};
  body.cut({.path = {ball.on_skin(-10, 2), ball.on_skin(0, -4), ball.on_skin(10, 2)},
            .depth = 0.008,
            .tilt = -50});
  const BodySurface surface = body.surface();
  double most = 0;
  for (const int v : lip_vertices(surface)) {
    const Vec3d cell(slot_node(ball.model.anatomy.lattice, surface.embedding[std::size_t(v)].cell));
    const Vec3 h = ball.model.anatomy.lattice.spacing, x = surface.rest[std::size_t(v)];
    const Vec3d at = Vec3d{x.x / h.x, x.y / h.y, x.z / h.z} - cell;
    most = std::max({most, -at.x, -at.y, -at.z, at.x - 1, at.y - 1, at.z - 1});
  }
  EXPECT_LT(most, 0.1) << "cells";
}

/// Largest distance of the lips from the skin of the ball [fine edges].
double height_of_lips(const BallBody& ball, const BodySurface& surface) {
  const double middle = 0.5 * (kVoxels - 1);
  const Vec3d center = ball.ct.grid.origin + Vec3d{middle, middle, middle} * kVoxel;
  const std::vector<Vec3d> rest = rest_points(ball.model, surface);
  double most = 0;
  for (const int v : lip_vertices(surface))
    most = std::max(most, std::abs(norm(rest[std::size_t(v)] - center) - kRadius * kVoxel));
  return most / ball.fine_edge();
}

// Lips that are moved onto a blade stay on the skin.
TEST(Lips, LieOnSkin) {
  for (const int block : {2, 3, 5}) {
    const BallBody ball(block);
    for (unsigned seed = 1; seed <= 8; seed++) {
      CutBody body{ball};
      body.cut(RandomCut(seed).s_shape(ball));
      EXPECT_LT(height_of_lips(ball, body.surface()), 0.1)
          << "fine edges, block " << block << ", seed " << seed;
    }
  }
}

/// Vertices of the largest connected component of the skin.
std::set<int> largest_skin(const BodySurface& surface) {
  std::vector<int> label(surface.rest.size());
  for (std::size_t v = 0; v < label.size(); v++) label[v] = int(v);
  for (bool has_changed = true; has_changed;) {
    has_changed = false;
    for (int n = 0; n < surface.skin_triangles - surface.cap_triangles; n++) {
      const Int3 t = surface.triangles[std::size_t(n)];
      const int least = std::min({label[std::size_t(t.x)], label[std::size_t(t.y)], label[std::size_t(t.z)]});
      for (const int v : {t.x, t.y, t.z})
        if (label[std::size_t(v)] != least) label[std::size_t(v)] = least, has_changed = true;
    }
  }
  std::map<int, std::set<int>> components;
  for (int n = 0; n < surface.skin_triangles - surface.cap_triangles; n++)
    for (int c = 0; c < 3; c++) {
      const int v = surface.triangles[std::size_t(n)][c];
      components[label[std::size_t(v)]].insert(v);
    }
  std::set<int> largest;
  for (const auto& [first, vertices] : components)
    if (vertices.size() > largest.size()) largest = vertices;
  return largest;
}

/// Width of the tissue around two cuts at the corners where they meet: the largest distance of its displaced
/// lips that coincide there at rest [fine edges].
double width_of_corners(const CutBody& body, const BodySurface& surface) {
  const TriMesh mesh = deformed_surface(body.ball.model, body.state, surface, Shown::kNothing);
  const double fine = body.ball.fine_edge();
  const std::set<int> around = largest_skin(surface);
  std::vector<int> lips;
  for (const int v : lip_vertices(surface))
    if (around.contains(v)) lips.push_back(v);
  const auto rest = [&](int v) { return Vec3d(surface.rest[std::size_t(v)]); };
  double most = 0;
  for (const double sign : {-1.0, 1.0}) {
    // the corner lies farthest beyond the end
    const auto& points = body.paths[0].points;
    const Vec3d outward = (points.back() - points.front()) * sign;
    const int corner = *std::max_element(lips.begin(), lips.end(), [&](int a, int b) {
      return dot(rest(a), outward) < dot(rest(b), outward);
    });
    for (const int a : lips)
      for (const int b : lips)
        if (std::max(norm(rest(a) - rest(corner)), norm(rest(b) - rest(corner))) < 0.05 * fine)
          most = std::max(most, double(norm(mesh.vertices[std::size_t(a)] - mesh.vertices[std::size_t(b)])));
  }
  return most / fine;
}

// The tissue around two cuts whose ends meet ends in a point, also while the wound gapes.
TEST(Lips, EndsOfTwoCutsMeetInPoint) {
  for (const bool has_partial_cells : {false, true})
    for (const int block : {2, 3}) {
      const BallBody ball(block, true, has_partial_cells);
      for (unsigned seed = 1; seed <= 5; seed++) {
        CutBody body{ball};
        const RandomCut random(seed);
        body.cut(random.arc(ball, 1)), body.cut(random.arc(ball, -1));
        for (int frame = 0; frame < 12; frame++) step(Exec(1), ball.model, body.state, {}, 1.0 / 60);
        EXPECT_LT(width_of_corners(body, body.surface()), 0.15)
            << "fine edges, block " << block << ", seed " << seed << ", partial cells " << has_partial_cells;
      }
    }
}

/// Steps in the skin around the ends of a cut: the largest difference of displacements along an edge, away
/// from the lips. As drawn, and of the cells that contain the vertices [m].
struct SkinSteps {
  double drawn = 0, of_cells = 0;
};
SkinSteps skin_steps(const CutBody& body, const BodySurface& surface) {
  const Model& model = body.ball.model;
  const TriMesh mesh = deformed_surface(model, body.state, surface, Shown::kNothing);
  const std::vector<Vec3d> rest = rest_points(model, surface);
  const double spacing = double(model.anatomy.lattice.spacing.x);
  const std::set<int> lips = lip_vertices(surface);
  const auto counts = [&](int v) {
    const Vec3d at(surface.rest[std::size_t(v)]);
    const auto& points = body.paths[0].points;
    if (std::min(norm(at - points.front()), norm(at - points.back())) > 1.2 * spacing) return false;
    return std::none_of(lips.begin(), lips.end(), [&](int lip) {
      return norm(Vec3d(surface.rest[std::size_t(lip)]) - at) < 0.3 * spacing;
    });
  };
  const auto drawn = [&](int v) { return Vec3d(mesh.vertices[std::size_t(v)]) - rest[std::size_t(v)]; };
  SkinSteps steps;
  for (int n = 0; n < surface.skin_triangles - surface.cap_triangles; n++)
    for (int c = 0; c < 3; c++) {
      const int a = surface.triangles[std::size_t(n)][c], b = surface.triangles[std::size_t(n)][(c + 1) % 3];
      if (a > b || !counts(a) || !counts(b)) continue;
      steps.drawn = std::max(steps.drawn, norm(drawn(a) - drawn(b)));
      steps.of_cells =
          std::max(steps.of_cells, double(norm(vertex_displacement(model, body.state, surface, a) -
                                               vertex_displacement(model, body.state, surface, b))));
    }
  return steps;
}

// Cells around the end of a cut differ at their borders. The drawn skin has a third of their steps in the
// mean.
TEST(Lips, SkinAroundEndsIsSmooth) {
  for (const int block : {3, 4}) {
    const BallBody ball(block, true, true, 64, 27);
    double drawn = 0, of_cells = 0;
    for (unsigned seed = 1; seed <= 5; seed++) {
      CutBody body{ball};
      RandomCut random(seed);
      body.cut({.from = random.at(ball, -1.2, 0), .to = random.at(ball, 1.2, 0), .depth = 0.008});
      for (int frame = 0; frame < 20; frame++) step(Exec(1), ball.model, body.state, {}, 1.0 / 60);
      const SkinSteps steps = skin_steps(body, body.surface());
      drawn += steps.drawn, of_cells += steps.of_cells;
    }
    EXPECT_LT(drawn, 0.35 * of_cells) << "block " << block;
  }
}

}  // namespace
}  // namespace turgor::lattice
