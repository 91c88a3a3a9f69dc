#include "turgor/models/sfem/separator.hpp"

#include <algorithm>
#include <queue>
#include <tuple>

namespace turgor::sfem {

namespace {

constexpr double kLargestShare = 0.6;  // of a part, that one side may have

/// A node between the sides that might go to one of them; its gain is by how much fewer are between then.
struct Candidate {
  int gain, node, to;

  bool operator<(const Candidate& o) const {
    return std::tie(gain, o.node, to) < std::tie(o.gain, node, o.to);
  }
};

struct Refinement {
  const BlockMatrix& k;
  const Sides& sides;
  std::vector<int>& side;
  std::size_t low = 0, high = 0, between = 0;  // nodes
  std::priority_queue<Candidate> candidates;
  std::vector<std::pair<int, int>> moved;  // nodes and the sides they had, to take moves back
  std::vector<int> settled;                // nodes that have left once in this pass

  std::size_t& count(int s) { return s == sides.low ? low : s == sides.high ? high : between; }
  int other(int s) const { return s == sides.low ? sides.high : sides.low; }
};

int gain_of(const Refinement& r, int node, int to) {
  int gain = 1;
  for (const int n : neighbours(r.k, node)) gain -= r.side[std::size_t(n)] == r.other(to);
  return gain;
}

void propose(Refinement& r, int node) {
  for (const int to : {r.sides.low, r.sides.high}) r.candidates.push({gain_of(r, node, to), node, to});
}

void set_side(Refinement& r, int node, int to) {
  r.moved.emplace_back(node, r.side[std::size_t(node)]);
  r.count(r.side[std::size_t(node)])--;
  r.count(to)++;
  r.side[std::size_t(node)] = to;
}

/// Moves a node from between to a side; its neighbours on the other side come between.
void move_out(Refinement& r, int node, int to) {
  set_side(r, node, to);
  for (const int n : neighbours(r.k, node)) {
    if (r.side[std::size_t(n)] != r.other(to)) continue;
    set_side(r, n, r.sides.between);
    for (const int w : neighbours(r.k, n))
      if (r.side[std::size_t(w)] == r.sides.between) propose(r, w);
  }
}

/// Moves single nodes, the most useful first and also some that do harm; what did not pay in the end is taken
/// back. True if fewer are between than before.
bool refine_once(Refinement& r, std::span<const int> part, std::vector<std::uint8_t>& is_settled) {
  const std::size_t before = r.between, patience = 20 + r.between / 2;
  const auto largest = std::size_t(kLargestShare * double(part.size()));
  r.moved.clear();
  r.candidates = {};
  for (const int node : part)
    if (r.side[std::size_t(node)] == r.sides.between) propose(r, node);
  std::size_t best = r.between, best_length = 0, idle = 0;
  while (!r.candidates.empty() && idle < patience) {
    const auto [gain, node, to] = r.candidates.top();
    r.candidates.pop();
    if (r.side[std::size_t(node)] != r.sides.between || is_settled[std::size_t(node)]) continue;
    if (const int now = gain_of(r, node, to); now != gain) {
      r.candidates.push({now, node, to});
      continue;
    }
    if (r.count(to) + 1 > std::max(largest, r.count(r.other(to)))) continue;
    is_settled[std::size_t(node)] = 1;
    r.settled.push_back(node);
    move_out(r, node, to);
    idle++;
    if (r.between < best) best = r.between, best_length = r.moved.size(), idle = 0;
  }
  for (; r.moved.size() > best_length; r.moved.pop_back()) {
    const auto [node, from] = r.moved.back();
    r.count(r.side[std::size_t(node)])--;
    r.count(from)++;
    r.side[std::size_t(node)] = from;
  }
  for (const int node : r.settled) is_settled[std::size_t(node)] = 0;
  r.settled.clear();
  return r.between < before;
}

}  // namespace

std::size_t refine_separator(const BlockMatrix& k, std::span<const int> part, const Sides& sides,
                             std::vector<int>& side, std::vector<std::uint8_t>& is_settled) {
  constexpr int kMostPasses = 8;
  Refinement r{.k = k, .sides = sides, .side = side, .candidates = {}, .moved = {}, .settled = {}};
  for (const int node : part) r.count(side[std::size_t(node)])++;
  for (int pass = 0; pass < kMostPasses && refine_once(r, part, is_settled); pass++) {
  }
  return r.between;
}

}  // namespace turgor::sfem
