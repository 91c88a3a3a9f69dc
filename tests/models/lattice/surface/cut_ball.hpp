// Balls in air, and cuts of them whose blades are known: for tests of drawn wounds.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include "tests/models/lattice/ct_body.hpp"
#include "turgor/models/lattice/cutting/blade_sheet.hpp"
#include "turgor/models/lattice/cutting/drawn_curve.hpp"
#include "turgor/models/lattice/cutting/incision.hpp"
#include "turgor/models/lattice/lattice.hpp"
#include "turgor/models/lattice/surface/surface.hpp"

namespace turgor::lattice::test {

constexpr int kVoxels = 48;
constexpr double kRadius = 19;  // [voxels]

/// A ball whose level crosses air_max linearly at its radius.
inline CtVolume sharp_ball(int voxels, double radius) {
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

/// Sheet of a path that goes on beyond its ends: drawn lips may end up to a fine cell beyond the blade.
inline BladeSheet long_sheet(const Model& model, BladePath path, double tilt, bool both_ends) {
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

}  // namespace turgor::lattice::test
