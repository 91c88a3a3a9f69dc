#include "turgor/models/lattice/cutting/virtual_node_fit.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <bit>
#include <limits>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/core/sort_unique.hpp"
#include "turgor/models/lattice/cutting/element_fragments.hpp"

namespace turgor::lattice {

namespace {

constexpr double kFitRadius = 3;  // radius of a fit [cells]
constexpr int kMaxRounds = 4;     // of the search; each reaches one cell farther
constexpr std::size_t kMinNodes = 4;

/// Incidence of corners and fragments.
struct FragmentsOfCorner {
  std::vector<std::pair<int, int>> pairs;  // corner, fragment; sorted

  explicit FragmentsOfCorner(const Fragments& fragments) {
    for (int p = 0; p < int(fragments.all.size()); p++)
      for (const int corner : fragments.all[std::size_t(p)].corner) pairs.emplace_back(corner, p);
    std::sort(pairs.begin(), pairs.end());
  }
  template <class Visit>
  void operator()(int corner, const Visit& visit) const {
    auto at = std::lower_bound(pairs.begin(), pairs.end(), std::pair(corner, -1));
    for (; at != pairs.end() && at->first == corner; ++at) visit(at->second);
  }
};

/// Tissue nodes that are connected to a virtual node through fragments, in the order of rounds. At least two
/// rounds are searched, and more if they find too few nodes.
std::vector<int> connected_nodes(const Model& model, const Cuts& cuts, const Fragments& fragments,
                                 const FragmentsOfCorner& fragments_of, int virtual_node) {
  const int slots = slot_count(fragments.fine.cells);
  std::vector<int> seen{virtual_node}, nodes;
  std::size_t begin = 0;
  for (int round = 0; round < kMaxRounds && (round < 2 || nodes.size() < kMinNodes); round++) {
    const std::size_t end = seen.size();
    // corners of all fragments that contain a corner of the last round
    for (; begin < end; begin++)
      fragments_of(seen[begin], [&](int p) {
        for (const int corner : fragments.all[std::size_t(p)].corner)
          if (std::find(seen.begin(), seen.end(), corner) == seen.end()) seen.push_back(corner);
      });
    nodes.clear();
    for (const int corner : seen)
      if (corner < slots && has_displacement(model, cuts, corner)) nodes.push_back(corner);
  }
  return nodes;
}

/// Weights of the nodes in a linear moving-least-squares fit, evaluated at `position`.
///
///   w_n (1/W + gᵀ (x_n − c)),  g = A⁻¹ (x − c),  A = Σ w_n (x_n − c)(x_n − c)ᵀ,  W = Σ w_n
///
/// c is the weighted center. A is regularized, so a direction without nodes has zero gradient. [Lancaster and
/// Salkauskas 1981]
std::vector<double> fit_weights(const std::vector<Vec3d>& nodes, Vec3d position) {
  std::vector<double> weight(nodes.size());
  double total = 0;
  Vec3d center;
  // distance weights w and center c
  for (std::size_t n = 0; n < nodes.size(); n++) {
    const Vec3d offset = nodes[n] - position;
    const double fade = std::max(0.01, 1 - dot(offset, offset) / (kFitRadius * kFitRadius));
    weight[n] = fade * fade;
    total += weight[n];
    center += nodes[n] * weight[n];
  }
  center = center / total;
  // moment matrix A
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  const auto column = [](Vec3d d) { return Eigen::Vector3d(d.x, d.y, d.z); };
  for (std::size_t n = 0; n < nodes.size(); n++)
    normal += weight[n] * column(nodes[n] - center) * column(nodes[n] - center).transpose();
  normal.diagonal().array() += 1e-3 * normal.trace() + 1e-9;
  // weights of the linear fit at `position`
  const Eigen::Vector3d gradient = normal.inverse() * column(position - center);
  for (std::size_t n = 0; n < nodes.size(); n++)
    weight[n] *= 1 / total + gradient.dot(column(nodes[n] - center));
  TURGOR_CHECK(sums_to_one(weight, 1e-5), "the weights of a fit sum to one");
  return weight;
}

/// Blade plane next to a virtual node, fitted in and around its first cut cell. It is computed once per
/// cell, and kept for later cuts.
struct AdjacentBlades {
  const Cuts& cuts;
  const CutEdgesByCell& edges;
  Fragments& fragments;

  AdjacentBlades(const Cuts& c, const CutEdgesByCell& e, const EarlierFragments& earlier, Fragments& f)
      : cuts(c), edges(e), fragments(f) {
    FragmentStages& stages = fragments.stages;
    stages.plane.assign(fragments.cells.size(), {}), stages.is_plane_known.assign(fragments.cells.size(), 0);
    for (std::size_t n = 0; n < fragments.cells.size(); n++)
      if (const int index = earlier.index(int(n)); index >= 0) {
        stages.plane[n] = earlier.fragments->stages.plane[std::size_t(index)];
        stages.is_plane_known[n] = earlier.fragments->stages.is_plane_known[std::size_t(index)];
      }
  }

  std::optional<CrackTipPlane> operator()(const FragmentsOfCorner& fragments_of, int virtual_node) {
    // first cut cell of its fragments
    int cell = -1;
    fragments_of(virtual_node, [&](int p) {
      const int c = fragments.all[std::size_t(p)].cell;
      if (cell < 0 && fragments.cells[std::size_t(c)].is_cut) cell = c;
    });
    if (cell < 0) return {};
    const auto c = std::size_t(cell);
    FragmentStages& stages = fragments.stages;
    if (!stages.is_plane_known[c]) {
      stages.plane[c] = fit_crack_tip_plane(cuts, fragments, edges, fragments.cells[c]);
      stages.is_plane_known[c] = 1;
    }
    return stages.plane[c];
  }
};

/// Position at which the fit is evaluated. If the blade lies between the nodes and the position, the position
/// is projected back along the normal, to the distance of the nearest nodes.
Vec3d project_to_own_side(const CrackTipPlane& blade, const std::vector<Vec3d>& nodes, Vec3d position) {
  // side of the nodes, and their smallest distance to the blade
  double side = 0, least = std::numeric_limits<double>::max();
  for (const Vec3d node : nodes) side += blade.signed_distance(node);
  for (const Vec3d node : nodes)
    if (blade.signed_distance(node) * side > 0)
      least = std::min(least, std::abs(blade.signed_distance(node)));
  const double own = side > 0 ? least : -least, at = blade.signed_distance(position);
  return (at - own) * side < 0 ? position + blade.normal * (own - at) : position;
}

/// Tissue corners next to a virtual node of air, in its own fragments: those that differ along one axis, else
/// along two, else along three.
std::vector<int> adjacent_tissue(const Model& model, const Cuts& cuts, const Fragments& fragments,
                                 const FragmentsOfCorner& fragments_of, int virtual_node) {
  const int slots = slot_count(fragments.fine.cells);
  std::array<std::vector<int>, 3> adjacent;
  // corners by the number of axes along which they differ
  fragments_of(virtual_node, [&](int p) {
    const auto& corners = fragments.all[std::size_t(p)].corner;
    const auto at = unsigned(std::find(corners.begin(), corners.end(), virtual_node) - corners.begin());
    TURGOR_CHECK(at < 8, "a virtual node is a corner of the fragments around it");
    for (unsigned c = 0; c < 8; c++) {
      const int corner = corners[c];
      const int slot = corner < slots ? corner : fragments.virtual_nodes[std::size_t(corner - slots)].slot;
      if (c == at || !(corner < slots ? is_solid : was_solid)(model, cuts, slot)) continue;
      std::vector<int>& found = adjacent[std::size_t(std::popcount(c ^ at) - 1)];
      if (std::find(found.begin(), found.end(), corner) == found.end()) found.push_back(corner);
    }
  });
  for (auto& found : adjacent)
    if (!found.empty()) return found;
  return {};
}

/// Appends a corner with a weight to the terms of a virtual node; a fitted virtual node by its own terms.
void add_terms(int corner, Real weight, Fragments& fragments) {
  const int slots = slot_count(fragments.fine.cells);
  if (corner < slots || fragments.virtual_nodes[std::size_t(corner - slots)].has_unknowns) {
    fragments.fit_terms.push_back({corner, weight});
    return;
  }
  const VirtualNode virtual_node = fragments.virtual_nodes[std::size_t(corner - slots)];
  for (int s = virtual_node.first_term; s < virtual_node.first_term + virtual_node.term_count; s++) {
    const FitTerm term = fragments.fit_terms[std::size_t(s)];
    fragments.fit_terms.push_back({term.corner, term.weight * weight});
  }
}

/// Gives a virtual node of air the mean displacement of adjacent corners, so that the skin moves with its
/// nodes.
void copy_mean_of_corners(const std::vector<int>& corners, Fragments& fragments) {
  TURGOR_ASSERT(!corners.empty(), "a mean is over at least one corner");
  for (const int corner : corners) add_terms(corner, Real(1) / Real(corners.size()), fragments);
}

/// Gives a virtual node of air the mean of the linear extrapolations along axes from two corners that bear,
/// 2 near − far, in fragments on its side of the blades. Does nothing without such corners.
void extrapolate_along_axes(const Model& model, const Cuts& cuts, const FragmentsOfCorner& fragments_of,
                            int virtual_node, Fragments& fragments) {
  const int slots = slot_count(fragments.fine.cells);
  const auto bears = [&](int corner) {
    return corner < slots ? has_displacement(model, cuts, corner)
                          : fragments.virtual_nodes[std::size_t(corner - slots)].has_unknowns;
  };
  std::vector<std::pair<int, int>> lines;  // near and far corners
  fragments_of(virtual_node, [&](int p) {
    const auto& corners = fragments.all[std::size_t(p)].corner;
    const auto at = std::size_t(std::find(corners.begin(), corners.end(), virtual_node) - corners.begin());
    for (std::size_t axis = 0; axis < 3; axis++) {
      const std::size_t inward = at ^ std::size_t(1) << axis;
      const int near = corners[inward];
      if (!bears(near)) continue;
      // the next cell along the axis
      fragments_of(near, [&](int q) {
        const auto& next = fragments.all[std::size_t(q)].corner;
        if (q != p && next[at] == near && bears(next[inward])) lines.emplace_back(near, next[inward]);
      });
    }
  });
  sort_unique(lines);
  for (const auto& [near, far] : lines) {
    const Real share = Real(1) / Real(lines.size());
    add_terms(near, 2 * share, fragments), add_terms(far, -share, fragments);
  }
}

}  // namespace

void fit_virtual_nodes(const Model& model, const Cuts& cuts, const CutEdgesByCell& edges,
                       const EarlierFragments& earlier, Fragments& fragments) {
  const int slots = slot_count(fragments.fine.cells);
  const FragmentsOfCorner fragments_of(fragments);
  AdjacentBlades blades(cuts, edges, earlier, fragments);
  const auto position_of = [&l = fragments.fine.cells](int slot) {
    return Vec3d(in_body(l, slot_node(l, slot)));
  };
  // fit to the connected nodes
  const auto fit = [&](int corner, int slot) {
    const std::vector<int> nodes = connected_nodes(model, cuts, fragments, fragments_of, corner);
    std::vector<Vec3d> positions;
    for (const int node : nodes) positions.push_back(position_of(node));
    if (nodes.empty()) return;
    Vec3d position = position_of(slot);
    if (const auto blade = blades(fragments_of, corner))
      position = project_to_own_side(*blade, positions, position);
    const std::vector<double> weights = fit_weights(positions, position);
    for (std::size_t n = 0; n < nodes.size(); n++)
      fragments.fit_terms.push_back({nodes[n], Real(weights[n])});
  };
  // with partial cells, skin beyond the outermost nodes moves as the skin that bears in them
  const bool extrapolates = !model.anatomy.cell_center.empty();
  // tissue and rim first, because virtual nodes of air refer to those of tissue
  for (const bool tissue : {true, false}) {
    if (!tissue) mark_virtual_nodes_with_unknowns(model, cuts, fragments);
    for (std::size_t c = 0; c < fragments.virtual_nodes.size(); c++) {
      VirtualNode& virtual_node = fragments.virtual_nodes[c];
      if ((was_solid(model, cuts, virtual_node.slot) || is_rim(model, virtual_node.slot)) != tissue) continue;
      virtual_node.first_term = int(fragments.fit_terms.size());
      const int corner = slots + int(c);
      const std::vector<int> adjacent = tissue || extrapolates
                                            ? std::vector<int>{}
                                            : adjacent_tissue(model, cuts, fragments, fragments_of, corner);
      if (!adjacent.empty()) copy_mean_of_corners(adjacent, fragments);
      if (!tissue && extrapolates) extrapolate_along_axes(model, cuts, fragments_of, corner, fragments);
      if (int(fragments.fit_terms.size()) == virtual_node.first_term) fit(corner, virtual_node.slot);
      virtual_node.term_count = int(fragments.fit_terms.size()) - virtual_node.first_term;
    }
  }
}

}  // namespace turgor::lattice
