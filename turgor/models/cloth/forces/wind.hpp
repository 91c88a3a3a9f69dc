// Wind on a sheet: pressure on the normal component of the velocity relative to each triangle, drag on the
// tangential one. Gusts are a sum of divergence-free waves that the mean wind transports (frozen turbulence).
// The same seed gives the same gusts.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/core/vec.hpp"
#include "turgor/models/cloth/model/mesh_tables.hpp"
#include "turgor/models/cloth/model/params.hpp"
#include "turgor/models/cloth/model/vectors.hpp"

namespace turgor::cloth {

/// Waves of a gusting wind at one time.
struct Gusts {
  struct Wave {
    Vec3 number, velocity;  // wave number and amplitude [1/m] [m/s]
    Real phase;
  };
  std::array<Wave, 8> waves;
  Vec3 mean;  // [m/s]
};
Gusts gusts_at(const Air& air, double time);
Vec3 air_velocity(const Gusts& gusts, Vec3 x);

/// Lists for BlowChunk: triangles by chunk of vertices.
ChunkTriangles triangles_by_chunk(std::span<const Int3> triangles, std::size_t padded_count);

/// Wind load on the vertices in dt: impulse [N·s], and minus its derivative by velocity [kg] as diagonal and
/// xy, xz, yz of symmetric matrices.
struct AirLoad {
  Vectors& impulse;
  Vectors& diagonal;
  Vectors& off_diagonal;
};
/// Computes the wind load of all vertices. `scratch` is overwritten by the air velocity relative to the
/// vertices.
void blow(const Exec& exec, const Air& air, double time, double dt, std::span<const Int3> triangles,
          const ChunkTriangles& chunks, const Vectors& x, const Vectors& v, Vectors& scratch, AirLoad out);

}  // namespace turgor::cloth
