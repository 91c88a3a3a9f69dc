#include "turgor/models/cloth/build/layers.hpp"

#include <algorithm>
#include <limits>
#include <queue>
#include <utility>
#include <vector>

namespace turgor::cloth {

namespace {

constexpr double kFarAlong =
    3;  // thicknesses along edges, which go zigzag, from which on it is another layer

/// Vertices within a way along edges, found again and again from other vertices.
class Surroundings {
 public:
  explicit Surroundings(const TriMesh& mesh) : mesh_(mesh), edges_(mesh.vertices.size()) {
    for (const Int3 t : mesh.triangles)
      for (int side = 0; side < 3; side++) {
        const int a = t[side], b = t[(side + 1) % 3];
        edges_[std::size_t(a)].push_back(b), edges_[std::size_t(b)].push_back(a);
      }
    way_.assign(mesh.vertices.size(), kNone);
  }

  void search(int from, double reach) {
    for (const int v : reached_) way_[std::size_t(v)] = kNone;
    reached_.assign(1, from), way_[std::size_t(from)] = 0;
    std::priority_queue<std::pair<double, int>> open;
    for (open.emplace(0.0, from); !open.empty();) {
      const auto [minus_way, v] = open.top();
      open.pop();
      if (-minus_way > way_[std::size_t(v)]) continue;
      for (const int next : edges_[std::size_t(v)]) {
        const double way =
            -minus_way + double(norm(mesh_.vertices[std::size_t(next)] - mesh_.vertices[std::size_t(v)]));
        if (way > reach || way >= way_[std::size_t(next)]) continue;
        if (way_[std::size_t(next)] == kNone) reached_.push_back(next);
        way_[std::size_t(next)] = way;
        open.emplace(-way, next);
      }
    }
  }
  bool has(int v) const { return way_[std::size_t(v)] != kNone; }
  /// By an edge, or by two, however long.
  bool are_joined(int a, int b) const {
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
  std::vector<double> way_;
  std::vector<int> reached_;
};

}  // namespace

int vertices_near_other_layers(const TriMesh& mesh, const NeighborLists& near, double thickness) {
  Surroundings around(mesh);
  std::vector<std::uint8_t> is_near(mesh.vertices.size(), 0);
  for (int i = 0; i < int(mesh.vertices.size()); i++) {
    bool searched = false;
    for (int n = near.begin[std::size_t(i)]; n < near.begin[std::size_t(i) + 1]; n++) {
      const int j = near.item[std::size_t(n)];
      if (around.are_joined(i, j)) continue;
      if (!searched) around.search(i, kFarAlong * thickness), searched = true;
      if (!around.has(j)) is_near[std::size_t(i)] = is_near[std::size_t(j)] = 1;
    }
  }
  return int(std::count(is_near.begin(), is_near.end(), 1));
}

}  // namespace turgor::cloth
