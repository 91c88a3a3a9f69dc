// Kernels for the device only: sums over the components of a sheet without held vertices, whose initial
// velocity change follows from their total force; residual.
#pragma once

#include "turgor/core/atomic_max.hpp"
#include "turgor/models/cloth/model/state.hpp"
#include "turgor/models/cloth/solver/system_kernels.hpp"

namespace turgor::cloth {

/// Vertices of a component that one thread sums.
struct ComponentChunk {
  int begin, end;
};
/// Chunks of a component, and its mass; 0 = held [kg].
struct ComponentInfo {
  int begin, end;
  double mass;
};
struct ComponentSum {
  Vec3d force;      // h f̃ [N·s]
  double drag = 0;  // of the wind [kg]
};

/// Sum of the wind's diagonal, for System::drag. Must run while `diagonal` has the wind only.
struct SumDrag {
  const ComponentChunk* chunks;
  ConstVectorsView diagonal;
  ComponentSum* sums;

  TURGOR_HD void operator()(std::size_t p) const {
    double sum = 0;
    for (int i = chunks[p].begin; i < chunks[p].end; i++)
      sum += double(diagonal.x[i] + diagonal.y[i] + diagonal.z[i]);
    sums[p].drag = sum;
  }
};
struct SumForce {
  const ComponentChunk* chunks;
  ConstVectorsView force;
  ComponentSum* sums;

  TURGOR_HD void operator()(std::size_t p) const {
    Vec3d sum;
    for (int i = chunks[p].begin; i < chunks[p].end; i++) sum += Vec3d(force[std::size_t(i)]);
    sums[p].force = sum;
  }
};
/// Rigid velocity change of each component from its total force; 0 if held.
struct FindComponentVelocity {
  const ComponentInfo* components;
  const ComponentSum* sums;
  double mass_factor;  // 1 + h α, the factor of the mass in W [1]
  bool has_air;
  Vec3* velocity;

  TURGOR_HD void operator()(std::size_t p) const {
    const ComponentInfo component = components[p];
    velocity[p] = {};
    if (!(component.mass > 0)) return;
    ComponentSum all;
    for (int n = component.begin; n < component.end; n++)
      all.force += sums[n].force, all.drag += sums[n].drag;
    velocity[p] = Vec3(all.force / (component.mass * mass_factor + (has_air ? all.drag : 0)));
  }
};

/// Initial guess of the sweeps.
struct StartChange {
  SheetView sheet;
  const int* component_of;  // -1 = padding
  const Vec3* velocity;     // of components, or null

  TURGOR_HD void operator()(std::size_t v) const {
    const Vec3 all = velocity != nullptr && component_of[v] >= 0 ? velocity[component_of[v]] : Vec3{};
    sheet.change.set(v, all), sheet.previous.set(v, all);
  }
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

/// Bit pattern of the largest |v|² [m²/s²].
struct FindLargestSpeed {
  ConstVectorsView v;
  std::uint32_t* largest;

  TURGOR_HD void operator()(std::size_t i) const { atomic_max(*largest, magnitude_bits(dot(v[i], v[i]))); }
};

/// Squared norms of force and residual over the free vertices [N²·s²].
struct ResidualSquares {
  double force = 0, residual = 0;
};
constexpr std::size_t kSquaresAtOnce = 256;  // vertices that one thread sums
struct SumSquares {
  SheetView sheet;
  Real mass_factor;  // System::mass_factor
  ResidualSquares* sums;

  TURGOR_HD void operator()(std::size_t p) const {
    const std::size_t begin = p * kSquaresAtOnce;
    const std::size_t end = begin + kSquaresAtOnce < sheet.size ? begin + kSquaresAtOnce : sheet.size;
    ResidualSquares sum;
    for (std::size_t i = begin; i < end; i++) {
      const Vec3 force = sheet.force[i] * is_free<Real>(sheet, i);
      const Vec3 r = residual_forces<Real>(sheet, mass_factor, sheet.change, sheet.force[i], i,
                                           [](Vec3 a) { return a; });
      sum.force += double(dot(force, force)), sum.residual += double(dot(r, r));
    }
    sums[p] = sum;
  }
};

}  // namespace turgor::cloth
