#include "turgor/models/lattice/cutting/corner_terms.hpp"

#include <array>

#include "turgor/core/assert.hpp"
#include "turgor/models/lattice/cutting/extrapolate.hpp"
#include "turgor/models/lattice/cutting/fragment_view.hpp"

namespace turgor::lattice {

namespace {

/// Groups of extrapolate_from_neighbors in the order of preference.
enum TermGroup { kAlongAxis, kAlongEdge, kAcrossCell, kNearEdge, kNearCell, kTermGroups };

/// Terms of one group; a node has at most 26 neighbors.
struct GroupTerms {
  std::array<CornerTerm, 26> terms;
  int count = 0;

  void add(const CornerTerm& term) { terms[std::size_t(count++)] = term; }
};

}  // namespace

void add_corner_terms(const Model& model, const Cuts& cuts, int corner, std::vector<CornerTerm>& terms) {
  const Lattice& l = model.anatomy.lattice;
  if (corner >= slot_count(l)) return;
  if (has_displacement(model, cuts, corner)) return terms.push_back({corner, -1, {}});
  // tissue neighbors, and the tissue behind them in the same direction
  const int parity = slot_node(l, corner).x & 1;
  std::array<GroupTerms, kTermGroups> groups;
  for (int n = 0; n < 27; n++) {
    const Int3 offset = box_offset(n);
    const int near = corner + slot_offset(l, offset, parity);
    if (n == 13 || !has_displacement(model, cuts, near)) continue;
    const bool is_edge = is_edge_offset(offset);
    groups[is_edge ? kNearEdge : kNearCell].add({near, -1, {}});
    const int far = near + slot_offset(l, offset, (parity + offset.x) & 1);
    if (!has_displacement(model, cuts, far) || is_separated(cuts.cut.data(), l, near, far, offset)) continue;
    const bool is_axis = offset.x * offset.x + offset.y * offset.y + offset.z * offset.z == 1;
    groups[is_axis   ? kAlongAxis
           : is_edge ? kAlongEdge
                     : kAcrossCell]
        .add({near, far, -hadamard(l.spacing, Vec3(offset))});
  }
  // first nonempty group
  for (const GroupTerms& group : groups) {
    if (group.count == 0) continue;
    terms.insert(terms.end(), group.terms.begin(), group.terms.begin() + group.count);
    return;
  }
}

Vec3 mean_of_terms(std::span<const CornerTerm> terms, const VecField& u) {
  TURGOR_CHECK(!terms.empty(), "a mean has terms");
  MeanVec mean;
  for (const CornerTerm& term : terms) {
    const Vec3 near_u = u[std::size_t(term.near)];
    mean.add(term.far < 0 ? near_u : extrapolate(u[std::size_t(term.far)], near_u, term.offset));
  }
  return mean.mean();
}

}  // namespace turgor::lattice
