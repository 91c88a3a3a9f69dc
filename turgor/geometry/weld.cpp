#include "turgor/geometry/weld.hpp"

#include <algorithm>
#include <numeric>
#include <tuple>

namespace turgor {

template <class T>
std::vector<int> first_coincident(const std::vector<Vec<T>>& x) {
  const auto key = [&](int v) {
    const Vec<T> p = x[std::size_t(v)];
    return std::tuple{p.x, p.y, p.z};
  };
  std::vector<int> order(x.size()), first(x.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return key(a) < key(b); });
  for (std::size_t i = 0; i < order.size(); i++) {
    const bool same = i > 0 && key(order[i]) == key(order[i - 1]);
    first[std::size_t(order[i])] = same ? first[std::size_t(order[i - 1])] : order[i];
  }
  return first;
}
template std::vector<int> first_coincident(const std::vector<Vec<float>>&);
template std::vector<int> first_coincident(const std::vector<Vec<double>>&);

TriMesh welded(const TriMesh& surface) {
  const std::vector<int> first = first_coincident(surface.vertices);
  TriMesh result{.vertices = surface.vertices};
  for (const Int3 t : surface.triangles) {
    const Int3 w{first[std::size_t(t.x)], first[std::size_t(t.y)], first[std::size_t(t.z)]};
    if (w.x != w.y && w.y != w.z && w.z != w.x) result.triangles.push_back(w);
  }
  return result;
}

}  // namespace turgor
