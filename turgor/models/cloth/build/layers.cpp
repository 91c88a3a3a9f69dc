#include "turgor/models/cloth/build/layers.hpp"

#include <algorithm>
#include <limits>
#include <queue>
#include <utility>
#include <vector>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"

namespace turgor::cloth {

namespace {

constexpr double kFarAlong =
    3;  // distance along edges, which zigzag, in thicknesses; beyond it is another layer

/// Vertices within a distance along edges of a start vertex (Dijkstra). Reused for many start vertices.
class EdgeDistances {
 public:
  explicit EdgeDistances(const TriMesh& mesh) : mesh_(mesh), edges_(mesh.vertices.size()) {
    for (const Int3 t : mesh.triangles)
      for (int side = 0; side < 3; side++) {
        const int a = t[side], b = t[(side + 1) % 3];
        edges_[std::size_t(a)].push_back(b), edges_[std::size_t(b)].push_back(a);
      }
    distance_.assign(mesh.vertices.size(), kNone);
  }

  void search(int from, double reach) {
    TURGOR_CHECK(is_index(from, edges_.size()), "a search starts at a vertex");
    // distances of the last search
    for (const int v : reached_) distance_[std::size_t(v)] = kNone;
    reached_.assign(1, from), distance_[std::size_t(from)] = 0;
    std::priority_queue<std::pair<double, int>> open;
    // nearest open vertex first
    for (open.emplace(0.0, from); !open.empty();) {
      const auto [minus_distance, v] = open.top();
      open.pop();
      if (-minus_distance > distance_[std::size_t(v)]) continue;
      for (const int next : edges_[std::size_t(v)]) {
        const double distance =
            -minus_distance +
            double(norm(mesh_.vertices[std::size_t(next)] - mesh_.vertices[std::size_t(v)]));
        if (distance > reach || distance >= distance_[std::size_t(next)]) continue;
        if (distance_[std::size_t(next)] == kNone) reached_.push_back(next);
        distance_[std::size_t(next)] = distance;
        open.emplace(-distance, next);
      }
    }
  }
  bool has(int v) const { return distance_[std::size_t(v)] != kNone; }
  /// True for vertices joined by one or two edges.
  bool are_connected(int a, int b) const {
    const std::vector<int>& of_a = edges_[std::size_t(a)];
    return is_one_of(of_a, b) || std::any_of(of_a.begin(), of_a.end(), [&](int between) {
             return is_one_of(edges_[std::size_t(between)], b);
           });
  }

 private:
  static bool is_one_of(const std::vector<int>& list, int v) {
    return std::find(list.begin(), list.end(), v) != list.end();
  }

  static constexpr double kNone = std::numeric_limits<double>::max();
  const TriMesh& mesh_;
  std::vector<std::vector<int>> edges_;
  std::vector<double> distance_;
  std::vector<int> reached_;
};

}  // namespace

int vertices_near_other_layers(const TriMesh& mesh, const NeighborLists& near, double thickness) {
  TURGOR_CHECK(near.begin.size() == mesh.vertices.size() + 1 && is_csr(near.begin, near.item.size()),
               "every vertex has a list of near vertices");
  // vertices with a near partner that is far along edges
  EdgeDistances distances(mesh);
  std::vector<std::uint8_t> is_near(mesh.vertices.size(), 0);
  for (int i = 0; i < int(mesh.vertices.size()); i++) {
    bool searched = false;
    for (int n = near.begin[std::size_t(i)]; n < near.begin[std::size_t(i) + 1]; n++) {
      const int j = near.item[std::size_t(n)];
      if (distances.are_connected(i, j)) continue;
      if (!searched) distances.search(i, kFarAlong * thickness), searched = true;
      if (!distances.has(j)) is_near[std::size_t(i)] = is_near[std::size_t(j)] = 1;
    }
  }
  return int(std::count(is_near.begin(), is_near.end(), 1));
}

}  // namespace turgor::cloth
