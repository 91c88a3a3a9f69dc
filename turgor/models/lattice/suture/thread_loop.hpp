// Loop of thread of one stitch at the present positions: directions and lengths of its strands.
#pragma once

#include <vector>

#include "turgor/models/lattice/suture/closure.hpp"

namespace turgor::lattice {

/// Strands from each point to the next. An open stitch has none after its last point.
struct Loop {
  std::vector<Vec3d> direction;  // unit vectors; zero for the strand that an open stitch lacks
  std::vector<double> length;    // of bites that keep their length: that of the CT [m]
  std::vector<char> is_bite;     // by strand: a bite that keeps its length

  std::size_t before(std::size_t p) const { return (p + length.size() - 1) % length.size(); }
  double total() const {
    double sum = 0;
    for (const double l : length) sum += l;
    return sum;
  }
  /// Force of the thread on a point per tension.
  Vec3d pull(std::size_t p) const { return direction[p] - direction[before(p)]; }
  /// The same without bites, in which tissue bears the thread: −∂L/∂x.
  Vec3d pull_across(std::size_t p) const {
    return (is_bite[p] ? Vec3d{} : direction[p]) - (is_bite[before(p)] ? Vec3d{} : direction[before(p)]);
  }
};

/// Positions of the points of a stitch, lattice frame [m].
std::vector<Vec3d> points_now(const Stitch& stitch, const Motion& motion);
Loop loop_of(const Stitch& stitch, const Motion& motion);
/// The same with the points in the CT.
Loop rest_loop_of(const Stitch& stitch);
/// Penalty stiffness of a stitch, at most that of the thread and about that of the tissue around it [N/m].
double penalty_of(const Model& model, const Thread& thread, const Stitch& stitch);

}  // namespace turgor::lattice
