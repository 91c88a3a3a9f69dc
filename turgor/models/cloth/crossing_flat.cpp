// Most of a cloth is smooth: where normals stay near one direction, a vertex and its neighbours unfold onto a
// plane all the time, and need not be looked at closely.
#include <algorithm>

#include "turgor/models/cloth/cloth.hpp"
#include "turgor/models/cloth/crossing.hpp"

namespace turgor::cloth {

namespace {

constexpr float kNarrow = 0.75f, kWide = 0.5f;  // cos² of 30° and 45°

Lanes3 cross(Lanes3 a, Lanes3 b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// Sixteen triangles on their way.
struct MovingTriangles {
  Lanes3 normal[3];  // of N(s) = Σ Bernstein polynomials of degree 2: all N(s) are in the cone of these
  Lanes longest2;    // edge, of both ends of the way [m²]
};

Lanes longest_of(Lanes3 a, Lanes3 b) {
  const Lanes3 c = b - a;
  return larger(dot(a, a), larger(dot(b, b), dot(c, c)));
}

MovingTriangles moving_triangles(const Vectors& x, const Vectors& d, const int (&corners)[3][kLanes]) {
  const Lanes3 xa = gather(x, corners[0]), da = gather(d, corners[0]);
  const Lanes3 e1 = gather(x, corners[1]) - xa, e2 = gather(x, corners[2]) - xa;
  const Lanes3 f1 = gather(d, corners[1]) - da, f2 = gather(d, corners[2]) - da;
  const Lanes3 n0 = cross(e1, e2), change = cross(e1, f2) + cross(f1, e2);
  return {{n0, n0 + change * all_lanes(0.5f), n0 + change + cross(f1, f2)},
          larger(longest_of(e1, e2), longest_of(e1 + f1, e2 + f2))};
}

struct MeasureChunk {
  const Model& model;
  System& system;

  /// Calls visit(corners, count, triangles) for the chunk's triangles, sixteen at a time.
  template <class Visit>
  void for_sixteen(std::size_t chunk, const Visit& visit) const {
    const ChunkTriangles& chunks = model.chunk_triangles;
    for (int n = chunks.begin[chunk]; n < chunks.begin[chunk + 1]; n += kLanes) {
      const int count = std::min(kLanes, chunks.begin[chunk + 1] - n);
      int corners[3][kLanes];
      for (int l = 0; l < kLanes; l++) {
        const int t = chunks.triangle[std::size_t(n + std::min(l, count - 1))];
        for (int k = 0; k < 3; k++) corners[k][l] = model.triangles[std::size_t(t)][k];
      }
      visit(corners, count, moving_triangles(system.before, system.force, corners));
    }
  }

  void operator()(std::size_t chunk) const {
    const std::size_t begin = chunk * kChunk, end = std::min(begin + kChunk, system.force.size());
    Vectors &up = system.inverse[1], &out = system.inverse[0];
    for (std::size_t v = begin; v < end; v++) up.set(v, {}), out.x[v] = 0, out.y[v] = 2;
    const auto is_mine = [&](int v) { return std::size_t(v) >= begin && std::size_t(v) < end; };
    for_sixteen(chunk, [&](const auto& corners, int count, const MovingTriangles& t) {
      for (int l = 0; l < count; l++)
        for (const auto& corner : corners) {
          const int v = corner[l];
          if (!is_mine(v)) continue;
          up.add(std::size_t(v), {t.normal[0].x[l], t.normal[0].y[l], t.normal[0].z[l]});
          out.x[std::size_t(v)] = std::max(out.x[std::size_t(v)], t.longest2[l]);
        }
    });
    for_sixteen(chunk, [&](const auto& corners, int count, const MovingTriangles& t) {
      for (const auto& corner : corners) {
        int mine[kLanes];  // others write to the other chunks
        for (int l = 0; l < kLanes; l++) mine[l] = is_mine(corner[l]) ? corner[l] : int(begin);
        const Lanes3 u = gather(up, mine);
        unsigned narrow = 0xffff, wide = 0xffff;
        for (const Lanes3& n : t.normal) {
          const Lanes along = larger(dot(n, u), all_lanes(0)), both2 = dot(u, u) * dot(n, n);
          narrow &= lanes_below(both2 * kNarrow - along * along, 0);
          wide &= lanes_below(both2 * kWide - along * along, 0);
        }
        for (int l = 0; l < count; l++)
          if ((narrow >> l & 1) == 0 && is_mine(corner[l])) {
            Real& flatness = out.y[std::size_t(corner[l])];
            flatness = std::min(flatness, Real(wide >> l & 1));
          }
      }
    });
  }
};

}  // namespace

void measure_triangles(const Exec& exec, const Model& model, State& state) {
  parallel_for(exec, model.chunk_triangles.begin.size() - 1, MeasureChunk{model, state.system});
}

}  // namespace turgor::cloth
