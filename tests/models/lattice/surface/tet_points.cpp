#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "tests/models/lattice/ct_body.hpp"
#include "turgor/models/lattice/surface/surface.hpp"

namespace turgor::lattice {
namespace {

constexpr double kStrip = 0.00015;  // a blade that ends on another one continues beyond it [m]

/// Cuts the fine edges that cross the plane x = `at` from `y_begin` to `y_end`, unless they are cut already.
void cut_up_to(const Model& model, State& state, double at, double y_end, double bottom,
               double y_begin = -1) {
  const FineLattice fine = fine_lattice(model);
  const Fragments before = make_fragments(model, state.cuts);
  for (int k = 0; k < fine.size.z; k++)
    for (int j = 0; j < fine.size.y; j++)
      for (int i = 0; i < fine.size.x; i++)
        for (int f = 0; f < kFamilyCount; f++) {
          const Int3 a{i, j, k}, b = a + kFamilies[std::size_t(f)];
          if (!contains(fine, b) || crossing(before, state.cuts, a, b).edge) continue;
          const Vec3d x = hadamard(lattice_index(fine, a), model.anatomy.grid.spacing);
          const Vec3d y = hadamard(lattice_index(fine, b), model.anatomy.grid.spacing);
          if ((x.x >= at) == (y.x >= at)) continue;
          const double fraction = (at - x.x) / (y.x - x.x);
          const Vec3d hit = x + (y - x) * fraction;
          if (hit.y > y_end || hit.y < y_begin || hit.z < bottom) continue;
          CutEdge edge = cut_edge_at(fine, a, f);
          edge.fraction = Real(fraction), edge.rightward = true, edge.incision = 1;
          state.cuts.edges.push_back(edge);
        }
}

/// Skin that moves with another side of a T-shaped cut than the one on which it lies.
struct MisplacedSkin {
  double area = 0;   // [m²]
  double depth = 0;  // largest distance of a vertex beyond its own side [m]
};
MisplacedSkin misplaced_skin(const Model& model, double across, double upright, double gape) {
  // the cut, and its three sides moved apart
  State state = make_state(model);
  const double bottom = 0.0102;
  cut_across_y(model, state, across, [&](Vec3d p) { return p.z > bottom; });
  cut_up_to(model, state, upright, across + kStrip, bottom);
  const auto side = [&](Vec3d p) {
    if (p.y >= across) return Vec3d{0, gape, 0};
    return Vec3d{p.x >= upright ? gape : -gape, 0, 0};
  };
  move(model, state, side);
  // distance of a point beyond the side with which it moves
  const auto beyond = [&](Vec3d p, Vec3d moved) {
    if (moved.y > std::abs(moved.x)) return across - p.y;
    return std::max(p.y - across, moved.x > 0 ? upright - p.x : p.x - upright);
  };
  // skin near the junction, by the side of its middle
  const BodySurface surface = build_surface(model, state.cuts);
  MisplacedSkin misplaced;
  for (int n = 0; n < surface.skin_triangles; n++) {
    const Int3 t = surface.triangles[std::size_t(n)];
    const auto rest = [&](int corner) { return Vec3d(surface.rest[std::size_t(t[corner])]); };
    const auto moved = [&](int corner) {
      return Vec3d(vertex_displacement(model, state, surface, t[corner]));
    };
    const Vec3d middle = (rest(0) + rest(1) + rest(2)) / 3;
    if (middle.z < 0.019 || norm(Vec3d{middle.x - upright, middle.y - across, 0}) > 0.006) continue;
    if (norm((moved(0) + moved(1) + moved(2)) / 3 - side(middle)) > 0.5 * gape)
      misplaced.area += 0.5 * norm(cross(rest(1) - rest(0), rest(2) - rest(0)));
    for (int corner = 0; corner < 3; corner++)
      misplaced.depth = std::max(misplaced.depth, beyond(rest(corner), moved(corner)));
  }
  return misplaced;
}

// Every lip keeps its own skin where one cut ends on another one: the corners of the flaps are not torn, and
// none has a piece of another or a point beside it. The positions include blades through nodes of the fine
// lattice.
TEST(TetPoints, SkinOfJunctionKeepsItsSide) {
  const Model model = body_of(make_ct({44, 44, 28}, [](Vec3d p) { return p.z < 22; }), {4, 4, 4});
  const double fine_cell = 1e-6;  // [m²]
  double sum = 0, most = 0;
  int count = 0;
  for (const double across : {0.02200001, 0.02203, 0.02251, 0.02296})
    for (const double upright : {0.02000001, 0.02004, 0.0203, 0.02049, 0.02097}) {
      const MisplacedSkin skin = misplaced_skin(model, across, upright, 0.002);
      sum += skin.area / fine_cell, most = std::max(most, skin.area / fine_cell), count++;
      EXPECT_LT(skin.depth, 2e-5) << "m, blades at " << across << " and " << upright << " m";
    }
  EXPECT_LT(sum / count, 0.08);
  EXPECT_LT(most, 0.3);
}

// Skin stays at its height at both ends of a blade: it does not sink to crossings below it.
TEST(TetPoints, SkinDoesNotSinkAtEndOfBlade) {
  const Model model = body_of(make_ct({44, 44, 28}, [](Vec3d p) { return p.z < 22; }), {4, 4, 4});
  for (const double at : {0.02004, 0.0203, 0.02049, 0.02097})
    for (const double end : {0.02003, 0.02051, 0.02096, 0.0214}) {
      State state = make_state(model);
      cut_up_to(model, state, at, end + 0.005, 0.0102, end);
      const BodySurface surface = build_surface(model, state.cuts);
      Real low = 1, high = 0;
      for (int n = 0; n < surface.skin_triangles; n++)
        for (int corner = 0; corner < 3; corner++) {
          const Vec3d x(surface.rest[std::size_t(surface.triangles[std::size_t(n)][corner])]);
          if (x.z > 0.01 && norm(Vec3d{x.x - at, x.y - end - 0.0025, 0}) < 0.006)
            low = std::min(low, Real(x.z)), high = std::max(high, Real(x.z));
        }
      EXPECT_LT(high - low, 2e-5) << "m, blade at " << at << " m, end at " << end << " m";
    }
}

}  // namespace
}  // namespace turgor::lattice
