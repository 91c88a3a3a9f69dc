// Walls of drawn wounds end where the blade did.
#include <array>
#include <map>
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "tests/models/lattice/surface/cut_ball.hpp"
#include "turgor/models/lattice/cutting/drawn_curve.hpp"

namespace turgor::lattice {
namespace {

using test::BallBody;
using test::CutBody;
using test::RandomCut;

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
TEST(Walls, EndInSmoothLine) {
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
TEST(Walls, OfTEndOnStem) {
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
