// Lips of drawn wounds lie on the blade that made them, and move with the tissue where they lie.
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "tests/models/lattice/ct_body.hpp"
#include "turgor/models/lattice/cutting/blade_sheet.hpp"
#include "turgor/models/lattice/cutting/drawn_curve.hpp"
#include "turgor/models/lattice/cutting/incision.hpp"
#include "turgor/models/lattice/lattice.hpp"
#include "turgor/models/lattice/surface/surface.hpp"

namespace turgor::lattice {
namespace {

constexpr int kVoxels = 48;
constexpr double kRadius = 19;  // [voxels]

/// A ball whose level crosses air_max linearly at its radius.
CtVolume sharp_ball(int voxels, double radius) {
  CtVolume ct = ball_ct(voxels, radius);
  const double middle = 0.5 * (voxels - 1);
  for_voxels(ct.grid, [&](Int3 p) {
    const double outward = norm(Vec3d(p) - Vec3d{middle, middle, middle}) - radius;
    ct.at(p.x, p.y, p.z) = std::int16_t(std::clamp(-449 - 350 * outward, -1000.0, 102.0));
  });
  return ct;
}

struct BallBody {
  CtVolume ct;
  Model model;
  double radius;  // [voxels]

  explicit BallBody(int block, bool is_solid = false, bool has_partial_cells = false, int voxels = kVoxels,
                    double radius_of = kRadius)
      : ct(sharp_ball(voxels, radius_of)), radius(radius_of) {
    Params params;
    params.block = {block, block, block};
    if (is_solid) params.tissue.law = TissueLaw::kSolid;
    params.tissue.partial_cells = has_partial_cells;
    model = build(Exec(1), ct, {}, params).value();
  }
  /// Point on the top of the ball, x and y from its axis [voxels].
  Vec3d on_skin(double x, double y) const {
    const double middle = 0.5 * (ct.grid.size.x - 1);
    return ct.grid.origin +
           Vec3d{middle + x, middle + y, middle + std::sqrt(radius * radius - x * x - y * y)} * kVoxel;
  }
  double fine_edge() const {
    return double(model.anatomy.lattice.spacing.x) / fine_lattice(model).subdivisions.x;
  }
};

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

/// Sheet of a path that goes on beyond its ends: drawn lips may end up to a fine cell beyond the blade.
BladeSheet long_sheet(const Model& model, BladePath path, double tilt, bool both_ends) {
  const double step = smallest_spacing(model.anatomy.lattice);
  for (const bool last : {false, true}) {
    if (!last || both_ends) {
      const Vec3d outward = normalized(path.points[0] - path.points[1]);
      path.points.insert(path.points.begin(), path.points[0] + outward * (3 * step));
      path.inward.insert(path.inward.begin(), Vec3d(path.inward[0]));
      path.depths.insert(path.depths.begin(), double(path.depths[0]));
    }
    std::reverse(path.points.begin(), path.points.end());
    std::reverse(path.inward.begin(), path.inward.end());
    std::reverse(path.depths.begin(), path.depths.end());
  }
  return sweep_blade(path, tilt * std::numbers::pi / 180, 3 * step, 1e-4 * step);
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

/// Cuts of a body at rest, and their sheets.
struct CutBody {
  const BallBody& ball;
  State state = make_state(ball.model);
  std::vector<Incision> drawn;
  std::vector<BladePath> paths;
  std::vector<BladeSheet> sheets;

  void cut(const Incision& incision) {
    std::vector<LaidBlade> laid;
    for (std::size_t n = 0; n < paths.size(); n++) laid.push_back({drawn[n], paths[n]});
    BladePath path = lay_blade(ball.model, state, incision, nullptr, laid).value();
    cut_edges(ball.model, state, path, 0, 1, int(paths.size()));
    sheets.push_back(long_sheet(ball.model, path, incision.tilt, paths.empty()));
    drawn.push_back(incision), paths.push_back(std::move(path));
  }
  BodySurface surface() const { return build_surface(ball.model, state.cuts, &ball.ct); }
};

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

/// Cuts whose direction, position, size and tilt are random.
struct RandomCut {
  std::mt19937 random;
  double direction = number(0, 2 * std::numbers::pi), x = number(-2, 2), y = number(-2, 2),
         half = number(7.5, 9.5), wide = number(0.35, 0.6) * half;  // [voxels]

  explicit RandomCut(unsigned seed) : random(seed) {}
  double number(double low, double high) { return low + (high - low) * double(random()) / 4294967296.0; }
  /// Point at fractions of the half length and of the width.
  Vec3d at(const BallBody& ball, double along, double across) const {
    const double u = along * half, v = across * wide, c = std::cos(direction), s = std::sin(direction);
    return ball.on_skin(x + u * c - v * s, y + u * s + v * c);
  }
  Incision s_shape(const BallBody& ball) {
    return {.path = {at(ball, -1, 0), at(ball, -0.5, 1), at(ball, 0, 0), at(ball, 0.5, -1), at(ball, 1, 0)},
            .depth = 0.008,
            .tilt = number(-50, 50)};
  }
  /// One of the two arcs of an ellipse.
  Incision arc(const BallBody& ball, double side) const {
    return {.path = {at(ball, -1, 0), at(ball, -0.45, 0.75 * side), at(ball, 0.05, side),
                     at(ball, 0.5, 0.7 * side), at(ball, 1, 0)},
            .depth = 0.008};
  }
};

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

/// Nearest position of a blade's lower edge.
struct LowerEdge {
  double along = 0;   // arc length on the path [m]
  double height = 0;  // distance of the position from the edge, negative below it [m]
};
LowerEdge lower_edge_near(const BladePath& path, double tilt, Vec3d position) {
  const auto down = [&](std::size_t n) { return path.inward[n] + across_at(path, n) * std::tan(tilt); };
  const auto edge = [&](std::size_t n) { return path.points[n] + down(n) * path.depths[n]; };
  LowerEdge nearest;
  double least = 1, before = 0;
  for (std::size_t n = 1; n < path.points.size(); n++) {
    const Vec3d side = edge(n) - edge(n - 1), away = position - edge(n - 1);
    const double at = std::clamp(dot(away, side) / dot(side, side), 0.0, 1.0);
    const double length = norm(path.points[n] - path.points[n - 1]);
    const Vec3d offset = away - side * at;
    if (norm(offset) < least) {
      least = norm(offset);
      nearest = {before + at * length, dot(offset, down(n)) < 0 ? least : -least};
    }
    before += length;
  }
  return nearest;
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

/// True if a position lies on the right side of a sheet.
bool is_right_of(const BladeSheet& sheet, Vec3d position) {
  double least = 1e9;
  bool is_right = false;
  for (const SheetTriangle& t : sheet.triangles) {
    const Vec3d away = position - (t.corner + (t.side1 + t.side2) / 3);
    if (norm(away) < least) least = norm(away), is_right = dot(away, t.normal) > 0;
  }
  return is_right;
}

/// Moves the nodes on both sides of a blade apart, also below its lower edge.
void open_cut(CutBody& body, double gape) {
  move(body.ball.model, body.state, [&](Vec3d p) {
    const double sign = is_right_of(body.sheets[0], p) ? 0.5 : -0.5;
    return across_at(body.paths[0], body.paths[0].points.size() / 2) * (sign * gape);
  });
}

/// Lowest and highest bottom of a drawn wound, among windows of a cell along the blade and away from its
/// ends. The bottom is the lowest position on the walls that gapes by a tenth of `gape`, above the blade's
/// lower edge [cells].
struct Bottom {
  double lowest = 1e9, highest = -1e9;
  double floor = 0;  // largest gape of a triangle that joins both walls, relative to `gape`
  int windows = 0;
};
Bottom bottom_of_wound(const CutBody& body, double tilt, double gape) {
  const BodySurface surface = body.surface();
  const TriMesh mesh = deformed_surface(body.ball.model, body.state, surface, Shown::kNothing);
  const double cell = smallest_spacing(body.ball.model.anatomy.lattice);
  // vertices of walls that coincide at rest
  std::set<int> walls;
  for (std::size_t t = std::size_t(surface.skin_triangles); t < surface.triangles.size(); t++)
    for (int c = 0; c < 3; c++) walls.insert(surface.triangles[t][c]);
  std::map<std::array<long, 3>, std::vector<int>> at;
  for (const int v : walls) {
    const Vec3d p = Vec3d(surface.rest[std::size_t(v)]) / (1e-3 * cell);
    at[{std::lround(p.x), std::lround(p.y), std::lround(p.z)}].push_back(v);
  }
  // lowest open ones by window
  std::map<int, double> lowest;
  const double length = path_length(body.paths[0]), margin = 3 * cell;
  for (const auto& [key, vertices] : at) {
    const auto gap = [&](int v) {
      return double(norm(mesh.vertices[std::size_t(v)] - mesh.vertices[std::size_t(vertices[0])]));
    };
    if (std::none_of(vertices.begin(), vertices.end(), [&](int v) { return gap(v) > 0.1 * gape; })) continue;
    const LowerEdge near =
        lower_edge_near(body.paths[0], tilt, Vec3d(surface.rest[std::size_t(vertices[0])]));
    const int window = int(std::floor((near.along - margin) / cell));
    if (window < 0 || (window + 1) * cell > length - 2 * margin) continue;
    double& height = lowest.try_emplace(window, 1e9).first->second;
    height = std::min(height, near.height / cell);
  }
  Bottom bottom{.windows = int(lowest.size())};
  // triangles that join both walls: without an area at rest, away from the lips
  for (std::size_t n = std::size_t(surface.skin_triangles); n < surface.triangles.size(); n++) {
    const Int3 t = surface.triangles[n];
    const auto rest = [&](int v) { return Vec3d(surface.rest[std::size_t(v)]); };
    const LowerEdge near = lower_edge_near(body.paths[0], tilt, rest(t.x));
    if (near.along < margin || near.along > length - margin || near.height > 0.7 * cell) continue;
    for (int c = 0; c < 3; c++) {
      const int a = t[c], b = t[(c + 1) % 3];
      if (norm(rest(a) - rest(b)) > 1e-3 * cell) continue;
      bottom.floor = std::max(
          bottom.floor, double(norm(mesh.vertices[std::size_t(a)] - mesh.vertices[std::size_t(b)])) / gape);
    }
  }
  for (const auto& [window, height] : lowest)
    bottom.lowest = std::min(bottom.lowest, height), bottom.highest = std::max(bottom.highest, height);
  return bottom;
}

// Walls of random cuts end in a line along the lower edge of the blade, whatever cells and fine edges the
// blade ends in.
TEST(Lips, WallsEndInSmoothLine) {
  for (const int block : {2, 3, 4}) {
    const BallBody ball(block, false, false, 96, 42);
    for (unsigned seed = 1; seed <= 6; seed++) {
      CutBody body{ball};
      RandomCut random(seed);
      const Incision incision{.from = random.at(ball, -2.4, 0),
                              .to = random.at(ball, 2.4, 0),
                              .depth = random.number(2, 3) * block * kVoxel,
                              .tilt = random.number(-30, 30)};
      body.cut(incision);
      const double tilt = incision.tilt * std::numbers::pi / 180, gape = block * kVoxel;
      open_cut(body, gape);
      const Bottom bottom = bottom_of_wound(body, tilt, gape);
      const std::string cut = "block " + std::to_string(block) + ", seed " + std::to_string(seed);
      EXPECT_GT(bottom.windows, 2) << cut;
      EXPECT_LT(bottom.floor, 0.01) << cut;
      EXPECT_GT(bottom.lowest, 0.2) << cut;
      EXPECT_LT(bottom.highest, 1.3) << cut;
    }
  }
}

/// A T in a random position and direction: a bent bar, and a stem that ends on it.
CutBody random_t(const BallBody& ball, RandomCut& random) {
  CutBody body{ball};
  const Vec3d end = random.at(ball, random.number(-0.3, 0.3), 0);
  body.cut({.path = {random.at(ball, -1.6, random.number(-0.5, 0.5)), end,
                     random.at(ball, 1.6, random.number(-0.5, 0.5))},
            .depth = 0.008});
  body.cut({.from = random.at(ball, random.number(-0.5, 0.5), -3), .to = end, .depth = 0.008});
  return body;
}

/// Largest distance by which walls of the two flaps of a T lie beyond the stem, within three cells of its end
/// [fine edges].
double beyond_stem(CutBody& body) {
  // each side moves in another direction
  constexpr double kMove = 1e-3;  // [m]
  const Vec3d start = body.paths[1].points.front();
  const bool flaps_right = is_right_of(body.sheets[0], start);
  move(body.ball.model, body.state, [&](Vec3d p) {
    if (is_right_of(body.sheets[0], p) != flaps_right) return Vec3d{0, 0, kMove};
    return is_right_of(body.sheets[1], p) ? Vec3d{kMove, 0, 0} : Vec3d{0, kMove, 0};
  });
  // walls of the flaps
  const BodySurface surface = body.surface();
  const double cell = smallest_spacing(body.ball.model.anatomy.lattice);
  const BladePath& stem = body.paths[1];
  const std::size_t middle = stem.points.size() / 2;
  std::set<int> walls;
  for (std::size_t t = std::size_t(surface.skin_triangles); t < surface.triangles.size(); t++)
    for (int c = 0; c < 3; c++) walls.insert(surface.triangles[t][c]);
  double most = 0;
  for (const int v : walls) {
    const Vec3d p(surface.rest[std::size_t(v)]);
    if (norm(p - stem.points.back()) > 3 * cell) continue;
    const Vec3d u(vertex_displacement(body.ball.model, body.state, surface, v));
    const double right = dot(p - stem.points[middle], across_at(stem, middle));
    if (norm(u - Vec3d{kMove, 0, 0}) < 0.1 * kMove) most = std::max(most, -right);
    if (norm(u - Vec3d{0, kMove, 0}) < 0.1 * kMove) most = std::max(most, right);
  }
  return most / body.ball.fine_edge();
}

// The walls of both flaps of a T end on the stem. A fine edge that crosses the stem and then the bar stores
// the bar alone, and a wall up to there would be a tooth beyond the stem.
TEST(Lips, WallsOfTEndOnStem) {
  for (const int block : {2, 3, 4}) {
    const BallBody ball(block, false, false, 96, 42);
    for (unsigned seed = 1; seed <= 6; seed++) {
      RandomCut random(seed);
      CutBody body = random_t(ball, random);
      EXPECT_LT(beyond_stem(body), 0.2) << "fine edges, block " << block << ", seed " << seed;
    }
  }
}

}  // namespace
}  // namespace turgor::lattice
