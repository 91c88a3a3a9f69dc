// The sfem model: a coarse finite-element body whose answers to unit forces (Green's functions) are known
// beforehand, a fine mesh superposed where a tool touches, and contact forces by the capacitance matrix
// algorithm. Equations and names: docs/models/sfem.md. [SFEM] is the superposed haptic plate, [James, Pai
// 1999] the capacitance matrix algorithm.
//
//   build            checks the body, assembles K                       (build.cpp)
//   factorize        K = L Lᵀ, sparse                                    (cholesky.hpp)
//   compute_green    Ξ = K⁻¹ between the nodes that can be touched or seen (green.cpp)
//   build_patch      the fine mesh around a tool, and how its surface answers (patch.hpp)
//   contact/touch    the force of a tool in a haptic tick
//   step             what is slow: large rotations, columns to be fetched (step.cpp)
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

/// How volume changes are measured. Standard elements lock when ν approaches 0.5; averaged ones do not:
/// hexahedra take the mean over the element (B-bar), tetrahedra the mean around each node. Quadratic
/// tetrahedra need none of this and have one form.
enum class Formulation : std::uint8_t { kStandard, kAveraged };

/// Of the stored Green's functions.
enum class Precision : std::uint8_t { kSingle, kDouble };

/// A sphere of another material inside the body.
struct Inclusion {
  Vec3d center;       // [m]
  double radius = 0;  // [m]
  int material = 0;   // index into Body::materials
};

/// What a model is built from.
struct Body {
  SolidMesh mesh;
  std::vector<Material> materials;  // at least one
  std::vector<int> material;        // of each element; empty = all have the first
  std::vector<Inclusion> inclusions;
  std::vector<std::uint8_t> fixed;  // 1 for every vertex that cannot move
};

/// For quadratic elements: a node in the middle of every edge, fixed where both ends of the edge are. The
/// vertices of linear tetrahedra keep their numbers.
Body with_middles(Body body);
/// Fixes those of a quadratic body that has `fixed` for its corners alone.
void fix_middles(Body& body);

struct Params {
  Formulation formulation = Formulation::kStandard;
  Precision precision = Precision::kSingle;
  double touch_depth = 0.02;  // below the surface, Green's functions are kept this deep [m]
};

/// A symmetric matrix of 3×3 blocks, all of its pattern stored, rows and columns by free node.
struct BlockMatrix {
  std::vector<std::size_t> row_begin;  // rows + 1
  std::vector<int> column;             // ascending in a row
  std::vector<double> value;           // nine a block, row by row
};

/// Some columns of Ξ over all free nodes, by which a stored Ξ is recognised as K's inverse.
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

/// What does not change while the body is touched.
struct Model {
  Body body;
  Params params;
  SolidSurface surface;
  std::vector<int> neighbors;  // across each face of each element (face_neighbours)
  std::vector<int> free_node;  // row of each vertex in K; -1 = fixed or unused
  std::vector<int> vertex;     // of each row of K
  BlockMatrix stiffness;       // K [N/m]
  std::optional<Cholesky> factor;
  Green green;
};

/// Checks the body and assembles K. Error: no element, an element without volume, ν outside (-1, 0.5), E ≤ 0,
/// no fixed vertex, a connected part that none of the fixed vertices holds: with the ids of what is wrong.
Result<Model> build(const Exec& exec, Body body, const Params& params);

/// Numbers of bytes and operations before anything is spent.
struct GreenCost {
  std::size_t factor_bytes = 0;  // of the sparse factor
  std::size_t store_bytes = 0;   // of the dense store
  std::size_t work_bytes = 0;    // held besides while computing, on one thread
  double factor_flops = 0, solve_flops = 0;
};
GreenCost green_cost(const Model& model);

/// Makes Model::factor unless it is there.
Status factorize(const Exec& exec, Model& model, const Progress& progress = {});
/// Makes the dense store; with a GPU the factor is made here and the columns there. Error: it would take more
/// than `memory_limit` bytes, with advice, or more than the GPU has.
Status compute_green(const Exec& exec, Model& model, std::size_t memory_limit, const Progress& progress = {},
                     const Gpu* gpu = nullptr);
/// Prepares a store without columns, filled by fetch_columns.
Status prepare_columns(const Exec& exec, Model& model, const Progress& progress = {});
/// Columns of these kept vertices, for a store on demand; does nothing for those that are there or fixed. Not
/// beside a tick that reads them: for that, see compute_columns and add_columns (green.hpp).
void fetch_columns(const Exec& exec, Model& model, const std::vector<int>& vertices);

/// Is the dense store that of this model's K, bit by bit as it was computed? Needs no factor. Error: what is
/// wrong with it.
Status check_green(const Model& model);

/// Memory of a model while it runs: mesh, K, its factor and the Green's functions.
std::size_t memory_bytes(const Model& model);
/// Equal for equal mesh, materials, fixed vertices, kept nodes, formulation and precision.
std::uint64_t content_hash(const Model& model);

}  // namespace turgor::sfem
