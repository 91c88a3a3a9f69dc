#include "turgor/models/cloth/forces/wind.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/models/cloth/forces/wind_kernels.hpp"
#include "turgor/models/cloth/model/mesh_tables.hpp"

namespace turgor::cloth {

namespace {

constexpr double kPi = 3.14159265358979323846;

/// Random number in [0, 1), the same on every machine.
double next_fraction(std::mt19937_64& random) { return double(random() >> 11) * 0x1p-53; }

Vec3d next_direction(std::mt19937_64& random) {
  const double z = 2 * next_fraction(random) - 1, angle = 2 * kPi * next_fraction(random);
  const double r = std::sqrt(1 - z * z);
  return {r * std::cos(angle), r * std::sin(angle), z};
}

/// Wind load of a chunk of vertices; each triangle is evaluated once for all its corners in the chunk,
/// sixteen triangles at a time. Loads are added in the order of the triangles.
struct BlowChunk {
  static constexpr int kNumbers = 9;  // impulse, diagonal, off-diagonal

  WindTriangles wind_triangles;
  const ChunkTriangles& chunks;
  std::size_t size;

  /// Numbers of `count` triangles, a row each; missing triangles repeat the last.
  void evaluate(const int* triangle, int count, Int3 (&corners)[kLanes],
                float (&rows)[kLanes][kLanes]) const {
    alignas(64) int index[3][kLanes];
    for (int l = 0; l < kLanes; l++) {
      corners[l] = wind_triangles.triangles[triangle[std::min(l, count - 1)]];
      for (int k = 0; k < 3; k++) index[k][l] = corners[l][k];
    }
    const auto load = wind_triangles.load<Lanes, const int*>(index[0], index[1], index[2]);
    const Lanes3 diagonal = load.diagonal(), off = load.off_diagonal();
    const Lanes numbers[kNumbers] = {load.impulse.x, load.impulse.y, load.impulse.z, diagonal.x, diagonal.y,
                                     diagonal.z,     off.x,          off.y,          off.z};
    for (int f = 0; f < kNumbers; f++)
      for (int l = 0; l < kLanes; l++) rows[l][f] = numbers[f][l];
  }

  void operator()(std::size_t chunk) const {
    alignas(64) float sums[kChunk][kLanes] = {}, rows[kLanes][kLanes] = {};
    const std::size_t begin = chunk * kChunk, end = std::min(begin + kChunk, size);
    // sums of the vertices
    for (int n = chunks.begin[chunk]; n < chunks.begin[chunk + 1]; n += kLanes) {
      const int count = std::min(kLanes, chunks.begin[chunk + 1] - n);
      Int3 corners[kLanes];
      evaluate(&chunks.triangle[std::size_t(n)], count, corners, rows);
      for (int l = 0; l < count; l++) {
        const Lanes row = load_lanes(rows[l]);
        for (int k = 0; k < 3; k++)
          if (const auto corner = std::size_t(corners[l][k]); corner >= begin && corner < end) {
            float* sum = sums[corner - begin];
            store_lanes(sum, load_lanes(sum) + row);
          }
      }
    }
    // results
    for (std::size_t i = begin; i < end; i++) {
      const float* sum = sums[i - begin];
      wind_triangles.impulse.set(i, {sum[0], sum[1], sum[2]});
      wind_triangles.diagonal.set(i, {sum[3], sum[4], sum[5]});
      wind_triangles.off_diagonal.set(i, {sum[6], sum[7], sum[8]});
    }
  }
};

}  // namespace

Gusts gusts_at(const Air& air, double time) {
  // amplitude of the waves
  Gusts gusts{.waves = {}, .mean = Vec3(air.velocity)};
  std::mt19937_64 random(air.seed);
  const std::size_t count = gusts.waves.size();
  const double sigma = air.gusts * norm(air.velocity) * std::sqrt(3.0 / double(count));
  // random directions, wavelengths from gust_length to an eighth of it
  for (std::size_t w = 0; w < count; w++) {
    const double length = air.gust_length * std::pow(0.125, double(w) / double(count - 1));
    const Vec3d number = next_direction(random) / length;
    const Vec3d sideways = cross(number, next_direction(random));
    const double start = next_fraction(random), turns = start - dot(number, air.velocity) * time;
    // The sum of the mean squares |velocity|²/2 over the waves is three times the variance of a component.
    gusts.waves[w] = {Vec3(number), Vec3(normalized(sideways) * (sigma * std::sqrt(2.0))),
                      Real(turns - std::floor(turns))};
  }
  return gusts;
}

Vec3 air_velocity(const Gusts& gusts, Vec3 x) {
  return AirAt<Real>{.x = {}, .v = {}, .relative_air = {}, .gusts = gusts, .is_steady = false}(x);
}

ChunkTriangles triangles_by_chunk(std::span<const Int3> triangles, std::size_t padded_count) {
  // triangles of each chunk
  std::vector<std::vector<int>> lists((padded_count + kChunk - 1) / kChunk);
  for (std::size_t t = 0; t < triangles.size(); t++)
    for (int corner = 0; corner < 3; corner++) {
      std::vector<int>& list = lists[std::size_t(triangles[t][corner]) / kChunk];
      if (list.empty() || list.back() != int(t)) list.push_back(int(t));
    }
  // concatenated lists
  ChunkTriangles chunks;
  chunks.begin.push_back(0);
  for (const auto& list : lists) {
    chunks.triangle.insert(chunks.triangle.end(), list.begin(), list.end());
    chunks.begin.push_back(int(chunks.triangle.size()));
  }
  chunks.triangle.shrink_to_fit();
  return chunks;
}

void blow(const Exec& exec, const Air& air, double time, double dt, std::span<const Int3> triangles,
          const ChunkTriangles& chunks, const Vectors& x, const Vectors& v, Vectors& scratch, AirLoad out) {
  TURGOR_CHECK(v.size() == x.size() && scratch.size() == x.size(), "every vertex has a velocity");
  TURGOR_CHECK(is_step_length(dt), "a step has a positive length");
  // air velocity relative to the vertices
  parallel_for(exec, x.size() / std::size_t(kLanes),
               AirAt<Lanes>{view(x), view(v), view(scratch), gusts_at(air, time), is_steady(air)}, 64);
  // loads of the triangles
  const WindTriangles all = wind_triangles(air, dt, triangles.data(), view(x), view(scratch),
                                           view(out.impulse), view(out.diagonal), view(out.off_diagonal));
  parallel_for(exec, chunks.begin.size() - 1, BlowChunk{all, chunks, x.size()});
}

}  // namespace turgor::cloth
