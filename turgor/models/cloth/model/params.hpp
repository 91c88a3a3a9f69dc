// Parameters of a cloth: fabric, damping, solver, collision, wind. Units are SI.
#pragma once

#include <cstdint>

#include "turgor/core/vec.hpp"

namespace turgor::cloth {

/// Force law: a sheet (membrane and bending, independent of the mesh), or the mass-spring system of [Kang
/// 2004].
enum class Law : std::uint8_t { kSheet, kSprings };

/// Material of a fabric. Stiffness is force per width at strain 1, as of a membrane.
struct Fabric {
  Law law = Law::kSprings;
  double density = 0.2;  // [kg/m²]
  double warp = 1000;    // along the warp [N/m]
  double weft = 1000;    // along the weft [N/m]
  double shear = 200;    // of a sheet: per radian of shear; of springs: at 45° to the warp [N/m]
  double poisson = 0;    // of a sheet: contraction along the weft relative to stretch along the warp [1]
  double rigidity_warp = 1e-5;  // of a sheet: moment per width and curvature along the warp [N·m]
  double rigidity_weft = 1e-5;  // the same along the weft [N·m]
  double bend = 20;             // of the springs across edges, which resist folding [N/m]
  Vec3d direction{1, 0, 0};     // of the warp, in the coordinates of the mesh; need not lie in its plane

  friend bool operator==(const Fabric&, const Fabric&) = default;
};

struct Damping {
  double motion = 0.2;     // velocities decay as exp(-motion·t) [1/s]
  double stretch = 0.001;  // Rayleigh damping: damping matrix relative to stiffness matrix [s]
};

/// Solver of the linear system (M − h²J) Δv = h f̃.
enum class Method : std::uint8_t { kJacobi, kChebyshev, kConjugateGradients, kTwoLevel };

/// True for conjugate gradients with either preconditioner.
inline bool uses_conjugate_gradients(Method method) {
  return method == Method::kConjugateGradients || method == Method::kTwoLevel;
}

/// Time integrator. Backward Euler damps oscillations; BDF2 hardly does.
enum class Integrator : std::uint8_t { kEuler, kBdf2 };

struct Solver {
  Integrator integrator = Integrator::kEuler;
  Method method = Method::kChebyshev;
  int sweeps = 16;  // or iterations of conjugate gradients; at most, at least 1
  double tolerance =
      0.01;  // relative residual at which conjugate gradients stop; 0 = never before `sweeps` [1]
  double strain_limit = 0;  // largest strain of a spring; 0 = no limit [1]
};

struct Collision {
  bool self = true;
  double thickness = 0.005;  // θ_c, smallest distance between layers [m]
  double friction = 0.3;     // Coulomb's coefficient between layers [1]
  int iterations = 12;       // at most, for velocities and for positions each
};

struct Params {
  Fabric fabric;
  Damping damping;
  Solver solver;
  Collision collision;
  double weld = 0;  // vertices closer than this are merged, which closes the seams of a garment [m]
};

/// Wind and its coefficients (forces/wind.hpp).
struct Air {
  double density = 1.2;      // 0 = no air [kg/m³]
  Vec3d velocity;            // mean wind [m/s]
  double pressure = 1.2;     // coefficient of the normal component, for a flat plate [1]
  double drag = 0.05;        // coefficient of the tangential component [1]
  double gusts = 0;          // standard deviation of each component relative to the mean wind [1]
  double gust_length = 1.5;  // wavelength of the largest gusts; the smallest are an eighth of it [m]
  std::uint64_t seed = 1;

  bool operator==(const Air&) const = default;
};

}  // namespace turgor::cloth
