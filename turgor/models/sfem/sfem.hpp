// The sfem model: a coarse finite-element body with precomputed responses to unit forces (Green's functions),
// a fine mesh superposed at the tools, and contact forces by the capacitance matrix algorithm. Equations and
// names: docs/models/sfem.md. [SFEM] is the superposed haptic plate, [James, Pai 1999] the capacitance matrix
// algorithm.
//
//   build            checks the body, assembles K                       (build.cpp)
//   factorize        K = L Lᵀ, sparse                                    (cholesky.hpp)
//   compute_green    Ξ = K⁻¹ between the nodes that can be touched or seen (green.cpp)
//   build_patch      the fine mesh around a tool and its compliance     (patch.hpp)
//   contact/touch    the force of a tool in a haptic tick
//   step             slow parts: large rotations, columns on demand     (step.cpp)
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/core/progress.hpp"
#include "turgor/core/result.hpp"
#include "turgor/geometry/solid_mesh.hpp"
#include "turgor/models/sfem/cholesky.hpp"

namespace turgor {
struct Gpu;
}

namespace turgor::sfem {

/// Isotropic linear elasticity.
struct Material {
  double young = 3e3;     // [Pa]
  double poisson = 0.45;  // [1], below 0.5
};

/// Discretization of volume changes. Standard elements lock when ν approaches 0.5; averaged ones do not:
/// hexahedra use the mean over the element (B-bar), tetrahedra the mean around each node. Quadratic
/// tetrahedra need no averaging and have one form.
enum class Formulation : std::uint8_t { kStandard, kAveraged };

/// Precision of the stored Green's functions.
enum class Precision : std::uint8_t { kSingle, kDouble };

/// A sphere of another material inside the body.
struct Inclusion {
  Vec3d center;       // [m]
  double radius = 0;  // [m]
  int material = 0;   // index into Body::materials
};

/// Input of a model.
struct Body {
  SolidMesh mesh;
  std::vector<Material> materials;  // at least one
  std::vector<int> material;        // of each element; empty = all have the first
  std::vector<Inclusion> inclusions;
  std::vector<std::uint8_t> fixed;  // 1 for every vertex that cannot move
};

/// Converts to quadratic elements with a node in the middle of every edge, fixed where both ends of the edge
/// are. The vertices of linear tetrahedra keep their numbers.
Body with_middles(Body body);
/// Fixes the mid-edge nodes of a quadratic body whose `fixed` was set for its corners only.
void fix_middles(Body& body);

struct Params {
  Formulation formulation = Formulation::kStandard;
  Precision precision = Precision::kSingle;
  double touch_depth = 0.02;  // below the surface, Green's functions are kept this deep [m]
  double density = 0;         // 0 = fixed vertices hold the body; else its inertia does, and K becomes
                              // K + M/h² (inertia.hpp) [kg/m³]
  double time_step = 0;       // h, with a density [s]
};

/// A symmetric matrix of 3×3 blocks, all of its pattern stored, rows and columns by free node.
struct BlockMatrix {
  std::vector<std::size_t> row_begin;  // rows + 1
  std::vector<int> column;             // ascending in a row
  std::vector<double> value;           // nine a block, row by row
};

/// Some columns of Ξ over all free nodes, by which a stored Ξ is recognized as K's inverse.
struct CheckColumns {
  std::vector<int> vertices;
  std::vector<double> values;  // of each vertex three columns, one behind the other [m/N]
};

/// Ξ = K⁻¹ between the kept nodes. Column-major, 3·count rows and columns; symmetric.
struct Green {
  std::vector<int> nodes;                   // kept vertices, those of the surface first
  std::size_t surface_count = 0;            // how many of `nodes` are on the surface
  std::vector<int> slot;                    // of each vertex in `nodes`; -1 = not kept
  std::vector<float> single_values;         // [m/N], one of the two is empty
  std::vector<double> double_values;        // [m/N]
  std::vector<std::vector<float>> columns;  // on demand, three of each kept node; empty = not fetched
  CheckColumns check;                       // of a dense store
  std::uint64_t checksum = 0;               // of all values of a dense store and its check columns
};

/// Constant data of a body.
struct Model {
  Body body;
  Params params;
  SolidSurface surface;
  std::vector<int> neighbors;  // across each face of each element (face_neighbours)
  std::vector<int> free_node;  // row of each vertex in K; -1 = fixed or unused
  std::vector<int> vertex;     // of each row of K
  BlockMatrix stiffness;       // K [N/m]
  std::vector<double> mass;    // of every vertex [kg]; empty without Params::density
  std::optional<Cholesky> factor;
  Green green;
};

/// Checks the body and assembles K. Error, with the affected ids: no element, an element without volume, ν
/// outside (-1, 0.5), E ≤ 0, no fixed vertex, a connected component without a fixed vertex.
Result<Model> build(const Exec& exec, Body body, const Params& params);

/// Memory and operations, estimated in advance.
struct GreenCost {
  std::size_t factor_bytes = 0;  // of the sparse factor
  std::size_t store_bytes = 0;   // of the dense store
  std::size_t work_bytes = 0;    // temporary memory on one thread
  double factor_flops = 0, solve_flops = 0;
};
GreenCost green_cost(const Model& model);

/// Computes Model::factor if it does not exist.
Status factorize(const Exec& exec, Model& model, const Progress& progress = {});
/// Computes the dense store. With a GPU, the factor is computed on the host and the columns on the device.
/// Error: it would take more than `memory_limit` bytes, with advice, or more than the GPU has.
Status compute_green(const Exec& exec, Model& model, std::size_t memory_limit, const Progress& progress = {},
                     const Gpu* gpu = nullptr);
/// Prepares a store without columns, filled by fetch_columns.
Status prepare_columns(const Exec& exec, Model& model, const Progress& progress = {});
/// Computes the columns of these stored vertices, for a store on demand. Skips columns that exist and fixed
/// vertices. Not for use beside a tick that reads the store: for that, see compute_columns and add_columns
/// (green.hpp).
void fetch_columns(const Exec& exec, Model& model, const std::vector<int>& vertices);

/// Checks that the dense store belongs to this model's K and is bit by bit as computed. Needs no factor.
/// Error: the defect.
Status check_green(const Model& model);

/// Memory of a model while it runs: mesh, K, its factor and the Green's functions.
std::size_t memory_bytes(const Model& model);
/// Hash of mesh, materials, fixed vertices, stored nodes, formulation and precision.
std::uint64_t content_hash(const Model& model);

}  // namespace turgor::sfem
