// Most of a cloth is smooth: where normals stay near one direction, a vertex and its neighbours unfold onto a
// plane all the time, and need not be looked at closely.
#include "turgor/models/cloth/ccd/ccd_flatness.hpp"

#include <algorithm>

#include "turgor/models/cloth/ccd/ccd.hpp"
#include "turgor/models/cloth/model/cloth.hpp"

namespace turgor::cloth {

namespace {

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
      const Vectors &x = system.before, &d = system.force;
      const Lanes3 xa = gather(x, corners[0]), da = gather(d, corners[0]);
      visit(corners, count,
            moving_triangle<Lanes>(gather(x, corners[1]) - xa, gather(x, corners[2]) - xa,
                                   gather(d, corners[1]) - da, gather(d, corners[2]) - da));
    }
  }

  void operator()(std::size_t chunk) const {
    const std::size_t begin = chunk * kChunk, end = std::min(begin + kChunk, system.force.size());
    Vectors &up = system.inverse[1], &out = system.inverse[0];
    for (std::size_t v = begin; v < end; v++) up.set(v, {}), out.x[v] = 0, out.y[v] = 2;
    const auto is_mine = [&](int v) { return std::size_t(v) >= begin && std::size_t(v) < end; };
    for_sixteen(chunk, [&](const auto& corners, int count, const MovingTriangle<Lanes>& t) {
      for (int l = 0; l < count; l++)
        for (const auto& corner : corners) {
          const int v = corner[l];
          if (!is_mine(v)) continue;
          up.add(std::size_t(v), {t.normal[0].x[l], t.normal[0].y[l], t.normal[0].z[l]});
          out.x[std::size_t(v)] = std::max(out.x[std::size_t(v)], t.longest2[l]);
        }
    });
    for_sixteen(chunk, [&](const auto& corners, int count, const MovingTriangle<Lanes>& t) {
      for (const auto& corner : corners) {
        int mine[kLanes];  // others write to the other chunks
        for (int l = 0; l < kLanes; l++) mine[l] = is_mine(corner[l]) ? corner[l] : int(begin);
        const Lanes3 u = gather(up, mine);
        unsigned narrow = 0xffff, wide = 0xffff;
        for (const Lanes3& n : t.normal) {
          narrow &= lanes_below(outside_of(n, u, kNarrow), 0);
          wide &= lanes_below(outside_of(n, u, kWide), 0);
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
