// Air that blows at a sheet: pressure on the normal part of its velocity relative to each triangle, drag on
// the tangential part, and gusts that travel with it. The gusts are a sum of waves without divergence that
// the mean wind carries along (frozen turbulence), the same for the same seed.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/core/vec.hpp"
#include "turgor/models/cloth/model/vectors.hpp"

namespace turgor::cloth {

struct Air {
  double density = 1.2;      // 0 = no air [kg/m³]
  Vec3d velocity;            // of the mean wind [m/s]
  double pressure = 1.2;     // coefficient of the normal part, of a flat plate [1]
  double drag = 0.05;        // coefficient of the tangential part [1]
  double gusts = 0;          // standard deviation of each component, in multiples of the mean wind [1]
  double gust_length = 1.5;  // of the largest gusts; the smallest are an eighth of it [m]
  std::uint64_t seed = 1;

  bool operator==(const Air&) const = default;
};

/// The waves of a gusting wind at one time.
struct Gusts {
  struct Wave {
    Vec3 number, velocity;  // [1/m] [m/s]
    Real phase;
  };
  std::array<Wave, 8> waves;
  Vec3 mean;  // [m/s]
};
Gusts gusts_at(const Air& air, double time);
Vec3 air_velocity(const Gusts& gusts, Vec3 x);

constexpr std::size_t kChunk = 256;  // vertices that are done at once: whole batches

/// The triangles that touch each chunk of vertices, ascending.
struct ChunkTriangles {
  std::vector<int> begin;     // chunks + 1
  std::vector<int> triangle;  // those of chunk c are begin[c] … begin[c + 1]
};
ChunkTriangles triangles_by_chunk(std::span<const Int3> triangles, std::size_t padded_count);

/// What the air does to the vertices in a time dt: impulse [N·s], and how fast it falls with velocity [kg],
/// as the diagonal and xy, xz, yz of a symmetric matrix. `scratch` is overwritten.
struct AirLoad {
  Vectors& impulse;
  Vectors& diagonal;
  Vectors& off_diagonal;
};
void blow(const Exec& exec, const Air& air, double time, double dt, std::span<const Int3> triangles,
          const ChunkTriangles& chunks, const Vectors& x, const Vectors& v, Vectors& scratch, AirLoad out);

}  // namespace turgor::cloth
