// The superposed patch: every coarse element near a tool, subdivided `refinement` times along each edge. Fine
// functions are added to the coarse ones, u = u_G + u_L, where u_L is zero at the coarse nodes and on the
// patch's border inside the body. The coupled system is condensed to the surface of the patch with one dense
// factor, S = K_L − K_LG Ξ K_GL. [SFEM; docs/models/sfem.md]
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <variant>
#include <vector>

#include "turgor/models/sfem/patch_levels.hpp"
#include "turgor/models/sfem/sfem.hpp"

namespace turgor::sfem {

struct PatchParams {
  double radius = 0.02;  // elements whose centroid is nearer to a touch than this are in the patch [m]
  int refinement = 2;    // subdivisions of an edge: 1 = coarse only, 2 … 4
};

/// A point of the patch's surface, interpolated from coarse vertices, with its own fine function if it has
/// one: u = Σ weight · u_G(coarse) + u_L(local).
struct PatchPoint {
  Vec3d x;                         // at rest [m]
  std::uint64_t key = 0;           // equal for the same point of another patch
  std::array<int, 6> coarse{};     // indices into Patch::coarse; the first `supports` count
  std::array<double, 6> weight{};  // of each
  int supports = 0;
  int local = -1;  // index of its own function; -1 = none
};

/// The coupled system after elimination. Column-major.
template <class T>
struct CondensedSystem {
  std::vector<T> factor;    // lower triangle of S = L Lᵀ, 3·local square
  std::vector<T> coupling;  // K_LG, 3·local × 3·coarse
  std::vector<T> green;     // Ξ between the coarse vertices, with the patch's own material, 3·coarse square
  std::vector<T> change;    // of the coarse stiffness by the patch, 3·coarse square; empty = none
};

/// The system of a nonlinear patch, linearized at its last solution: the coarse vertices have the
/// displacement motion + response · forces, and forces stiffness · displacement on the linear body displace
/// them so. Column-major.
struct LinearizedSystem {
  std::vector<double> motion;     // of the coarse vertices at zero forces, 3·coarse [m]
  std::vector<double> response;   // 3·coarse × 3·points [m/N]
  std::vector<double> stiffness;  // Ξ⁻¹ between the coarse vertices, 3·coarse square [N/m]
};

/// The surface near the tools and its compliance.
struct Patch {
  std::vector<int> elements;  // coarse ones that are subdivided, ascending
  std::vector<int> coarse;    // vertices that support the patch's points, ascending
  std::vector<PatchPoint> points;
  std::vector<Int3> triangles;     // of points, counter-clockwise seen from outside
  std::vector<double> compliance;  // 3·points square, symmetric: displacement of all for a unit force [m/N]
  std::vector<PatchLevel> levels;  // coarser and coarser pressures on the points (patch_levels.hpp)
  int local_nodes = 0;             // fine nodes with a function of their own
  int surface_nodes = 0;           // those whose functions are in `system`; others are eliminated before
  std::variant<CondensedSystem<float>, CondensedSystem<double>, LinearizedSystem> system;
  std::vector<Vec3d> shift;  // displacement of each point without forces, by a nonlinear law
                             // (nonlinear_patch.hpp); empty = none [m]
};

/// Coarse elements near the touches: those around the surface vertex nearest to each touch, and all that are
/// connected to them by faces with a centroid within the radius. Only elements with stored Green's functions.
/// Ascending.
std::vector<int> patch_elements(const Model& model, std::span<const Vec3d> touches, double radius);

/// Cost of a patch, estimated from the fine mesh only.
struct PatchCost {
  std::size_t local_nodes = 0, points = 0;
  double bytes = 0;  // at most, while it is built
  double flops = 0;
};
PatchCost patch_cost(const Model& model, std::span<const int> elements, int refinement,
                     std::span<const Vec3d> touches = {});

/// Builds the patch over these elements. Its points are the connected parts of its outer surface nearest to
/// the touches, or all of it without touches. Calculates in the precision of Model::green, or in double where
/// single is not sufficient. Requires the columns of all vertices of the elements; without refinement, of
/// those on the surface. Error: it would take more than `most_bytes`, with advice; or the body is so nearly
/// incompressible that double precision is not sufficient. [Theory: S, Ξ_L, Ξ_LG, Ξ_GG of
/// docs/models/sfem.md]
Result<Patch> build_patch(const Model& model, std::span<const int> elements, int refinement,
                          std::span<const Vec3d> touches = {}, std::size_t most_bytes = std::size_t(-1));

/// Forces on the vertices Patch::coarse that are equivalent for the rest of the body to `forces` on the
/// points (three a point) [N].
std::vector<double> coarse_forces(const Patch& patch, std::span<const double> forces);

/// Displacements of the surface's free vertices, Green::nodes[0 … surface_count), under forces on kept
/// vertices: u = Σ Ξ_p f_p. Three numbers each; forces on fixed vertices move nothing. [m], [N]
void surface_displacements(const Exec& exec, const Model& model, std::span<const int> vertices,
                           std::span<const double> forces, std::span<float> out);

}  // namespace turgor::sfem
