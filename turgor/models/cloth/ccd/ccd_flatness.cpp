// Flatness of a cloth for CCD. If normals around a vertex stay near one direction, its surroundings unfold
// onto a plane during the whole motion and need no collision tests.
#include "turgor/models/cloth/ccd/ccd_flatness.hpp"

#include <algorithm>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/models/cloth/ccd/ccd.hpp"
#include "turgor/models/cloth/model/state.hpp"

namespace turgor::cloth {

namespace {

/// Normals, longest edges and flatness of a chunk of vertices.
struct MeasureChunk {
  const Model& model;
  CcdMotion motion;
  std::size_t size;  // padded number of vertices

  /// Calls visit(corners, count, triangles) for the triangles of the chunk, sixteen at a time.
  template <class Visit>
  void for_sixteen(std::size_t chunk, const Visit& visit) const {
    const ChunkTriangles& chunks = model.chunk_triangles;
    for (int n = chunks.begin[chunk]; n < chunks.begin[chunk + 1]; n += kLanes) {
      const int count = std::min(kLanes, chunks.begin[chunk + 1] - n);
      // corners; missing triangles repeat the last
      int corners[3][kLanes];
      for (int l = 0; l < kLanes; l++) {
        const int t = chunks.triangle[std::size_t(n + std::min(l, count - 1))];
        for (int k = 0; k < 3; k++) corners[k][l] = model.triangles[std::size_t(t)][k];
      }
      // sides and their changes
      const VectorsView x = motion.start, d = motion.displacement;
      const Lanes3 xa = gather(x, corners[0]), da = gather(d, corners[0]);
      visit(corners, count,
            moving_triangle<Lanes>(gather(x, corners[1]) - xa, gather(x, corners[2]) - xa,
                                   gather(d, corners[1]) - da, gather(d, corners[2]) - da));
    }
  }

  void operator()(std::size_t chunk) const {
    const std::size_t begin = chunk * kChunk, end = std::min(begin + kChunk, size);
    const VectorsView axis = motion.normal;
    for (std::size_t v = begin; v < end; v++) axis.set(v, {}), motion.longest2[v] = 0, motion.flatness[v] = 2;
    const auto is_mine = [&](int v) { return std::size_t(v) >= begin && std::size_t(v) < end; };
    // sums of normals and longest edges
    for_sixteen(chunk, [&](const auto& corners, int count, const MovingTriangle<Lanes>& t) {
      for (int l = 0; l < count; l++)
        for (const auto& corner : corners) {
          const int v = corner[l];
          if (!is_mine(v)) continue;
          axis.add(std::size_t(v), {t.normal[0].x[l], t.normal[0].y[l], t.normal[0].z[l]});
          motion.longest2[v] = std::max(motion.longest2[v], t.longest2[l]);
        }
    });
    // flatness
    for_sixteen(chunk, [&](const auto& corners, int count, const MovingTriangle<Lanes>& t) {
      for (const auto& corner : corners) {
        int mine[kLanes];  // vertices of other chunks are written by these
        for (int l = 0; l < kLanes; l++) mine[l] = is_mine(corner[l]) ? corner[l] : int(begin);
        const Lanes3 u = gather(axis, mine);
        unsigned narrow = 0xffff, wide = 0xffff;
        for (const Lanes3& n : t.normal) {
          narrow &= lanes_below(outside_of(n, u, kNarrow), 0);
          wide &= lanes_below(outside_of(n, u, kWide), 0);
        }
        for (int l = 0; l < count; l++)
          if ((narrow >> l & 1) == 0 && is_mine(corner[l])) {
            Real& flatness = motion.flatness[corner[l]];
            flatness = std::min(flatness, Real(wide >> l & 1));
          }
      }
    });
  }
};

}  // namespace

void measure_triangles(const Exec& exec, const Model& model, State& state, bool changed) {
  TURGOR_CHECK(is_csr(model.chunk_triangles.begin, model.chunk_triangles.triangle.size()),
               "chunks cover their triangles");
  const MeasureChunk measure{model, ccd_motion(view(model, state)), state.x.size()};
  const std::vector<char>& is_changed = state.ccd.is_changed;
  const auto any_changed = [&](std::size_t chunk) {
    const std::size_t begin = std::min(chunk * kChunk, is_changed.size()),
                      end = std::min(begin + kChunk, is_changed.size());
    return std::find(&is_changed[0] + begin, &is_changed[0] + end, 1) != &is_changed[0] + end;
  };
  parallel_for(exec, model.chunk_triangles.begin.size() - 1, [&](std::size_t chunk) {
    if (!changed || any_changed(chunk)) measure(chunk);
  });
}

}  // namespace turgor::cloth
