#include "turgor/models/lattice/cutting/fragment_shares.hpp"

#include <algorithm>
#include <utility>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/geometry/kuhn_raster.hpp"
#include "turgor/models/lattice/cutting/crack_tips.hpp"
#include "turgor/models/lattice/cutting/cut_fraction.hpp"
#include "turgor/models/lattice/mechanics/cells.hpp"

namespace turgor::lattice {

namespace {

/// Total length of each fragment of a cell along one axis, and the number of crossings between fragments. The
/// unit is a fine edge.
struct Lengths {
  std::vector<double> of;
  double crossings = 0;
};
Lengths lengths_along(const Fragments& fragments, const Cuts& cuts, const CutCell& cell, int axis) {
  // fine edges along the axis; lines on a face of the cell count half, lines on its edges a quarter
  const FineLattice& f = fragments.fine;
  const Int3 first = first_of_cell(f, slot_node(f.cells, cell.slot)),
             direction = kFamilies[std::size_t(axis)];
  Lengths found{.of = std::vector<double>(std::size_t(cell.fragment_count))};
  const auto label = [&](Int3 p) {
    return fragments.label[cell.first_sub_index + std::size_t(sub_index(f, p))];
  };
  for_sub_nodes(f, [&](Int3 p) {
    if (!in_cell(f, p + direction)) return;
    double weight = 1;
    for (int side = 0; side < 3; side++)
      if (side != axis && (p[side] == 0 || p[side] == f.subdivisions[side])) weight *= 0.5;
    // each fine edge: divided at its cut
    const int a = label(p), b = label(p + direction);
    double fraction = 0.5;
    if (a != b) {
      found.crossings += weight;
      if (const Crossing cut = crossing(fragments, cuts, first + p, first + p + direction); cut.edge)
        fraction = double(cut.fraction);
    }
    TURGOR_CHECK(a < cell.fragment_count && b < cell.fragment_count,
                 "labels of fragments lie below their count");
    if (a >= 0) found.of[std::size_t(a)] += weight * fraction;
    if (b >= 0) found.of[std::size_t(b)] += weight * (1 - fraction);
  });
  return found;
}

/// Fraction of tissue that still bridges a crack tip, (1 − q)/(1 + 2 q), from the cut fraction q. It is less
/// than the uncut fraction 1 − q, since tissue is bent and stretched most at the end of a blade. The constant
/// was chosen for gapes closest to those of finite elements (docs/models/cutting.md).
double bridge(double cut_samples) {
  TURGOR_CHECK(cut_samples >= 0 && cut_samples <= 1, "a cut fraction is from 0 to 1");
  return (1 - cut_samples) / (1 + 2 * cut_samples);
}

}  // namespace

Shares shares_of(const Fragments& fragments, const Cuts& cuts, const CutCell& cell) {
  // axis with most crossings
  Lengths best = lengths_along(fragments, cuts, cell, 0);
  for (int axis = 1; axis < 3; axis++)
    if (Lengths found = lengths_along(fragments, cuts, cell, axis); found.crossings > best.crossings)
      best = std::move(found);
  // fractions of the fragments
  constexpr double kLeast = 1e-3;
  double sum = 0;
  for (double& length : best.of) length = std::max(length, kLeast), sum += length;
  Shares shares;
  for (const double length : best.of) shares.of.push_back(Real(length / sum));
  // bridges at crack tips
  shares.parted.assign(best.of.size(), 1);
  for (int t = cell.first_tip; t < cell.first_tip + cell.tip_count; t++) {
    const CrackTip& tip = fragments.tips[std::size_t(t)];
    const double cut_samples = cut_fraction(cuts, fragments, cell, tip);
    shares.bridges.push_back(Real(std::min(1 - kLeast, bridge(cut_samples))));
    for (const int fragment : {tip.left, tip.right})
      shares.parted[std::size_t(fragment)] = 1 - shares.bridges.back();
  }
  TURGOR_CHECK(sums_to_one(shares.of, 1e-4), "the shares of a cell sum to one");
  return shares;
}

std::vector<Real> patch_shares(const Model& model, const Cuts& cuts, const Fragments& fragments,
                               const CutCell& cell, const SkinPatch& patch) {
  constexpr int kSamples = 12;  // on each side of the center, along both axes
  const Vec3 h = model.anatomy.lattice.spacing, center = (patch.point + Vec3{1, 1, 1}) * Real(0.5);
  const Real step = std::max({h.x, h.y, h.z}) * Real(1.75) / kSamples;
  std::vector<int> count(std::size_t(cell.fragment_count));
  int all = 0;
  const auto add = [&](Vec3 at) {
    if (at.x < 0 || at.y < 0 || at.z < 0 || at.x > 1 || at.y > 1 || at.z > 1) return;
    const int fragment = fragment_at(fragments, cuts, cell, at);
    if (fragment < 0) return;
    count[fragment < cell.fragment_count ? std::size_t(fragment) : 0]++, all++;  // ghosts: the first fragment
  };
  for (int i = -kSamples; i <= kSamples; i++)
    for (int j = -kSamples; j <= kSamples; j++) {
      const Vec3 d = (patch.along * Real(i) + patch.across * Real(j)) * step;
      add(center + Vec3{d.x / h.x, d.y / h.y, d.z / h.z});
    }
  std::vector<Real> shares;
  for (const int n : count) shares.push_back(all > 0 ? Real(n) / Real(all) : 1 / Real(count.size()));
  return shares;
}

std::vector<int> count_points(const Fragments& fragments, const Cuts& cuts, const CutCell& cell,
                              const Vec3 (&corner)[3], int subdivisions) {
  std::vector<int> count(std::size_t(cell.fragment_count));
  const auto add = [&](Real a, Real b) {
    const Vec3 at = corner[0] + (corner[1] - corner[0]) * a + (corner[2] - corner[0]) * b;
    const int fragment = fragment_at(fragments, cuts, cell, at);
    if (fragment >= 0)
      count[fragment < cell.fragment_count ? std::size_t(fragment)
                                           : 0]++;  // sample points in ghosts count for the first fragment
  };
  const Real size = Real(1) / Real(subdivisions);
  for (int i = 0; i < subdivisions; i++)
    for (int j = 0; i + j < subdivisions; j++) {
      add((Real(i) + Real(1) / 3) * size, (Real(j) + Real(1) / 3) * size);
      if (i + j + 1 < subdivisions) add((Real(i) + Real(2) / 3) * size, (Real(j) + Real(2) / 3) * size);
    }
  return count;
}

}  // namespace turgor::lattice
