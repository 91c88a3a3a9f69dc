#include "turgor/models/lattice/cutting/virtual_node_fit.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <bit>
#include <limits>

#include "turgor/models/lattice/mechanics/cut_elements.hpp"

namespace turgor::lattice {

namespace {

constexpr double kReach = 3;  // of a fit [steps]
constexpr int kRounds = 4;    // of the search, a cell each
constexpr std::size_t kEnough = 4;

/// Which pieces have a corner: pairs in order.
struct FragmentsOfCorner {
  std::vector<std::pair<int, int>> pairs;  // corner, piece

  explicit FragmentsOfCorner(const Fragments& pieces) {
    for (int p = 0; p < int(pieces.pieces.size()); p++)
      for (const int corner : pieces.pieces[std::size_t(p)].corner) pairs.emplace_back(corner, p);
    std::sort(pairs.begin(), pairs.end());
  }
  template <class Visit>
  void operator()(int corner, const Visit& visit) const {
    auto at = std::lower_bound(pairs.begin(), pairs.end(), std::pair(corner, -1));
    for (; at != pairs.end() && at->first == corner; ++at) visit(at->second);
  }
};

/// Nodes of tissue that are joined to a copy, nearest in cells first: two rounds, more where that finds too
/// few.
std::vector<int> joined_nodes(const Model& model, const State& state, const Fragments& pieces,
                              const FragmentsOfCorner& pieces_of, int copy) {
  const int slots = slot_count(pieces.fine.cells);
  std::vector<int> seen{copy}, nodes;
  std::size_t begin = 0;
  for (int round = 0; round < kRounds && (round < 2 || nodes.size() < kEnough); round++) {
    const std::size_t end = seen.size();
    for (; begin < end; begin++)
      pieces_of(seen[begin], [&](int p) {
        for (const int corner : pieces.pieces[std::size_t(p)].corner)
          if (std::find(seen.begin(), seen.end(), corner) == seen.end()) seen.push_back(corner);
      });
    nodes.clear();
    for (const int corner : seen)
      if (corner < slots && is_solid(model, state, corner)) nodes.push_back(corner);
  }
  return nodes;
}

/// The weights that a linear fit gives to the nodes, for its value at `place`. A direction in which there are
/// no nodes has no gradient.
std::vector<double> fit_weights(const std::vector<Vec3d>& nodes, Vec3d place) {
  std::vector<double> weight(nodes.size());
  double total = 0;
  Vec3d center;
  for (std::size_t n = 0; n < nodes.size(); n++) {
    const Vec3d apart = nodes[n] - place;
    const double fade = std::max(0.01, 1 - dot(apart, apart) / (kReach * kReach));
    weight[n] = fade * fade;
    total += weight[n];
    center += nodes[n] * weight[n];
  }
  center = center / total;
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  const auto column = [](Vec3d d) { return Eigen::Vector3d(d.x, d.y, d.z); };
  for (std::size_t n = 0; n < nodes.size(); n++)
    normal += weight[n] * column(nodes[n] - center) * column(nodes[n] - center).transpose();
  normal.diagonal().array() += 1e-3 * normal.trace() + 1e-9;
  const Eigen::Vector3d way = normal.inverse() * column(place - center);
  for (std::size_t n = 0; n < nodes.size(); n++) weight[n] *= 1 / total + way.dot(column(nodes[n] - center));
  return weight;
}

/// The blade beside a copy: a plane through what is cut in and around the first cut cell that has it. Cells
/// are asked once.
struct BladesBeside {
  const State& state;
  const Fragments& pieces;
  const EdgesOfCells& edges;
  std::vector<std::optional<CrackTipPlane>> plane;  // by cell
  std::vector<std::uint8_t> known;

  BladesBeside(const State& s, const Fragments& p, const EdgesOfCells& e)
      : state(s), pieces(p), edges(e), plane(p.cells.size()), known(p.cells.size()) {}

  std::optional<CrackTipPlane> operator()(const FragmentsOfCorner& pieces_of, int copy) {
    int cell = -1;
    pieces_of(copy, [&](int p) {
      const int c = pieces.pieces[std::size_t(p)].cell;
      if (cell < 0 && pieces.cells[std::size_t(c)].is_cut) cell = c;
    });
    if (cell < 0) return {};
    const auto c = std::size_t(cell);
    if (!known[c]) plane[c] = fit_tip(state, pieces, edges, pieces.cells[c]), known[c] = 1;
    return plane[c];
  }
};

/// The place that a copy takes its displacement from: itself, or, across the blade, as far from the blade as
/// the nearest nodes on its own side.
Vec3d place_on_own_side(const CrackTipPlane& blade, const std::vector<Vec3d>& nodes, Vec3d place) {
  double side = 0, least = std::numeric_limits<double>::max();
  for (const Vec3d node : nodes) side += blade.at(node);
  for (const Vec3d node : nodes)
    if (blade.at(node) * side > 0) least = std::min(least, std::abs(blade.at(node)));
  const double own = side > 0 ? least : -least, at = blade.at(place);
  return (at - own) * side < 0 ? place + blade.normal * (own - at) : place;
}

/// Corners of tissue beside a copy of a node of air, in its own pieces: along an edge of the lattice where
/// there are such, else across a face or a cell.
std::vector<int> tissue_beside(const Model& model, const State& state, const Fragments& pieces,
                               const FragmentsOfCorner& pieces_of, int copy) {
  const int slots = slot_count(pieces.fine.cells);
  std::array<std::vector<int>, 3> beside;
  pieces_of(copy, [&](int p) {
    const auto& corners = pieces.pieces[std::size_t(p)].corner;
    const auto at = unsigned(std::find(corners.begin(), corners.end(), copy) - corners.begin());
    for (unsigned c = 0; c < 8; c++) {
      const int corner = corners[c];
      const int slot = corner < slots ? corner : pieces.virtual_nodes[std::size_t(corner - slots)].slot;
      if (c == at || !is_solid(model, state, slot)) continue;
      std::vector<int>& found = beside[std::size_t(std::popcount(c ^ at) - 1)];
      if (std::find(found.begin(), found.end(), corner) == found.end()) found.push_back(corner);
    }
  });
  for (auto& found : beside)
    if (!found.empty()) return found;
  return {};
}

/// Skin goes with its nodes: air beside them has their mean displacement.
void follow_tissue(const std::vector<int>& corners, Fragments& pieces) {
  const int slots = slot_count(pieces.fine.cells);
  const Real share = Real(1) / Real(corners.size());
  for (const int corner : corners) {
    if (corner < slots || pieces.virtual_nodes[std::size_t(corner - slots)].bears) {
      pieces.sources.push_back({corner, share});
      continue;
    }
    const VirtualNode copy = pieces.virtual_nodes[std::size_t(corner - slots)];
    for (int s = copy.first; s < copy.first + copy.source_count; s++) {
      const FitTerm source = pieces.sources[std::size_t(s)];
      pieces.sources.push_back({source.corner, source.weight * share});
    }
  }
}

}  // namespace

void find_sources(const Model& model, const State& state, const EdgesOfCells& edges, Fragments& pieces) {
  const int slots = slot_count(pieces.fine.cells);
  const FragmentsOfCorner pieces_of(pieces);
  BladesBeside blades(state, pieces, edges);
  const auto place_of = [&l = pieces.fine.cells](int slot) { return Vec3d(in_body(l, slot_node(l, slot))); };
  const auto fit = [&](int corner, int slot) {
    const std::vector<int> nodes = joined_nodes(model, state, pieces, pieces_of, corner);
    std::vector<Vec3d> places;
    for (const int node : nodes) places.push_back(place_of(node));
    if (nodes.empty()) return;
    Vec3d place = place_of(slot);
    if (const auto blade = blades(pieces_of, corner)) place = place_on_own_side(*blade, places, place);
    const std::vector<double> weights = fit_weights(places, place);
    for (std::size_t n = 0; n < nodes.size(); n++) pieces.sources.push_back({nodes[n], Real(weights[n])});
  };
  for (const bool tissue : {true, false}) {
    if (!tissue) find_bearing(model, state, pieces);
    for (std::size_t c = 0; c < pieces.virtual_nodes.size(); c++) {
      VirtualNode& copy = pieces.virtual_nodes[c];
      if (is_solid(model, state, copy.slot) != tissue) continue;
      copy.first = int(pieces.sources.size());
      const int corner = slots + int(c);
      const std::vector<int> beside =
          tissue ? std::vector<int>{} : tissue_beside(model, state, pieces, pieces_of, corner);
      if (!beside.empty()) follow_tissue(beside, pieces);
      if (int(pieces.sources.size()) == copy.first) fit(corner, copy.slot);
      copy.source_count = int(pieces.sources.size()) - copy.first;
    }
  }
}

}  // namespace turgor::lattice
