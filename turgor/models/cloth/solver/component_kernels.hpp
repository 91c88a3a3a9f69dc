// What a GPU needs beside the loops of the CPU: sums over the parts of a sheet that nothing holds, which
// begin a step with the velocity that their total force gives them, and what holds do.
#pragma once

#include "turgor/core/atomic_max.hpp"
#include "turgor/models/cloth/model/cloth.hpp"
#include "turgor/models/cloth/solver/system_kernels.hpp"

namespace turgor::cloth {

/// Vertices of one part that one thread sums up.
struct PartPiece {
  int begin, end;
};
/// The pieces of a part, and its mass; 0 = it is held [kg].
struct WholePart {
  int begin, end;
  double mass;
};
struct PartSum {
  Vec3d force;      // h f̃ [N·s]
  double drag = 0;  // of the air [kg]
};

/// System::drag, as long as the diagonal of the air alone is there.
struct SumDrag {
  const PartPiece* pieces;
  ConstVectorsView diagonal;
  PartSum* sums;

  TURGOR_HD void operator()(std::size_t p) const {
    double sum = 0;
    for (int i = pieces[p].begin; i < pieces[p].end; i++)
      sum += double(diagonal.x[i] + diagonal.y[i] + diagonal.z[i]);
    sums[p].drag = sum;
  }
};
struct SumForce {
  const PartPiece* pieces;
  ConstVectorsView force;
  PartSum* sums;

  TURGOR_HD void operator()(std::size_t p) const {
    Vec3d sum;
    for (int i = pieces[p].begin; i < pieces[p].end; i++) sum += Vec3d(force[std::size_t(i)]);
    sums[p].force = sum;
  }
};
/// The velocity of each part as a whole; none where it is held.
struct FindPartVelocity {
  const WholePart* parts;
  const PartSum* sums;
  double masses;  // by how much damping of motion makes them larger [1]
  bool has_air;
  Vec3* velocity;

  TURGOR_HD void operator()(std::size_t p) const {
    const WholePart part = parts[p];
    velocity[p] = {};
    if (!(part.mass > 0)) return;
    PartSum all;
    for (int n = part.begin; n < part.end; n++) all.force += sums[n].force, all.drag += sums[n].drag;
    velocity[p] = Vec3(all.force / (part.mass * masses + (has_air ? all.drag : 0)));
  }
};

/// What sweeps begin with.
struct StartChange {
  SheetView sheet;
  const int* part_of;    // -1 = fills the last batch
  const Vec3* velocity;  // of parts, or null

  TURGOR_HD void operator()(std::size_t v) const {
    const Vec3 all = velocity != nullptr && part_of[v] >= 0 ? velocity[part_of[v]] : Vec3{};
    sheet.change.set(v, all), sheet.before.set(v, all);
  }
};
/// Held vertices change their velocities as they are told.
struct AimHolds {
  SheetView sheet;
  const Hold* holds;
  Real dt;

  TURGOR_HD void operator()(std::size_t n) const {
    const auto v = std::size_t(holds[n].vertex);
    sheet.force.set(v, (holds[n].goal - sheet.x[v]) / dt - sheet.v[v]);
  }
};
struct StartHolds {
  SheetView sheet;
  const Hold* holds;

  TURGOR_HD void operator()(std::size_t n) const {
    const auto v = std::size_t(holds[n].vertex);
    sheet.change.set(v, sheet.force[v]), sheet.before.set(v, sheet.force[v]);
  }
};
struct PlaceHolds {
  SheetView sheet;
  const Hold* holds;

  TURGOR_HD void operator()(std::size_t n) const { sheet.x.set(std::size_t(holds[n].vertex), holds[n].goal); }
};

struct CopyVectors {
  ConstVectorsView from;
  VectorsView to;

  TURGOR_HD void operator()(std::size_t v) const { to.set(v, from[v]); }
};
struct ClearVectors {
  VectorsView of;

  TURGOR_HD void operator()(std::size_t v) const { of.set(v, {}); }
};

/// Bits of the largest |v|² [m²/s²].
struct FindLargestSpeed {
  ConstVectorsView v;
  std::uint32_t* largest;

  TURGOR_HD void operator()(std::size_t i) const { atomic_max(*largest, magnitude_bits(dot(v[i], v[i]))); }
};

/// Squares of the force and of what is left of it, over the free vertices [N²·s²].
struct LeftSquares {
  double force = 0, left = 0;
};
constexpr std::size_t kSquaresAtOnce = 256;  // vertices that one thread sums up
struct SumSquares {
  SheetView sheet;
  Real keep;  // System::keep
  LeftSquares* sums;

  TURGOR_HD void operator()(std::size_t p) const {
    const std::size_t begin = p * kSquaresAtOnce;
    const std::size_t end = begin + kSquaresAtOnce < sheet.size ? begin + kSquaresAtOnce : sheet.size;
    LeftSquares sum;
    for (std::size_t i = begin; i < end; i++) {
      const Vec3 force = sheet.force[i] * is_free<Real>(sheet, i);
      const Vec3 left =
          residual_forces<Real>(sheet, keep, sheet.change, sheet.force[i], i, [](Vec3 a) { return a; });
      sum.force += double(dot(force, force)), sum.left += double(dot(left, left));
    }
    sums[p] = sum;
  }
};

}  // namespace turgor::cloth
