// Own test of two bodies of finite elements for triangles that cross, beside the solver of contacts.
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "turgor/sim/world.hpp"

namespace turgor::test {

using Corners = std::array<Vec3d, 3>;

/// True if the segment from p to q meets a triangle.
inline bool crosses(Vec3d p, Vec3d q, const Corners& t) {
  const auto side = [&](Vec3d x) { return dot(cross(t[1] - t[0], t[2] - t[0]), x - t[0]); };
  if (side(p) * side(q) > 0) return false;
  double sign = 0;
  for (std::size_t corner = 0; corner < 3; corner++) {
    const Vec3d a = t[corner] - p, b = t[(corner + 1) % 3] - p;
    const double volume = dot(cross(a, b), q - p);
    if (volume * sign < 0) return false;
    if (volume != 0) sign = volume;
  }
  return true;
}

/// Present triangles of a body.
inline std::vector<Corners> triangles_of(const SfemBody& body) {
  const auto at = [&](int v) {
    const auto n = std::size_t(v);
    const Vec3d u = body.flight ? body.flight->u[n] : body.coupling->displacement[n];
    return body.model.body.mesh.vertices[n] + u;
  };
  std::vector<Corners> all;
  for (const Int3 t : body.model.surface.triangles) all.push_back({at(t.x), at(t.y), at(t.z)});
  return all;
}

/// True if the boxes around two triangles are apart.
inline bool are_apart(const Corners& s, const Corners& t) {
  for (int axis = 0; axis < 3; axis++) {
    const auto [s_low, s_high] = std::minmax({s[0][axis], s[1][axis], s[2][axis]});
    const auto [t_low, t_high] = std::minmax({t[0][axis], t[1][axis], t[2][axis]});
    if (s_low > t_high || t_low > s_high) return true;
  }
  return false;
}

/// Pairs of triangles of two bodies that cross.
inline int crossing_count(const SfemBody& a, const SfemBody& b) {
  int count = 0;
  const std::vector<Corners> of_b = triangles_of(b);
  for (const Corners& s : triangles_of(a))
    for (const Corners& t : of_b) {
      if (are_apart(s, t)) continue;
      bool found = false;
      for (std::size_t n = 0; n < 3 && !found; n++)
        found = crosses(s[n], s[(n + 1) % 3], t) || crosses(t[n], t[(n + 1) % 3], s);
      count += found;
    }
  return count;
}

}  // namespace turgor::test
