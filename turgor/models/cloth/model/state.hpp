// Model, state and inputs of a cloth: structs without functions (cloth.hpp has these). A Model never changes
// after build; a State is all that a step changes.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/core/result.hpp"
#include "turgor/geometry/tri_mesh.hpp"
#include "turgor/models/cloth/model/ccd_workspace.hpp"
#include "turgor/models/cloth/model/contacts.hpp"
#include "turgor/models/cloth/model/mesh_tables.hpp"
#include "turgor/models/cloth/model/obstacle_shape.hpp"
#include "turgor/models/cloth/model/params.hpp"
#include "turgor/models/cloth/model/rows.hpp"
#include "turgor/models/cloth/model/two_level_system.hpp"
#include "turgor/models/cloth/model/vectors.hpp"

namespace turgor::cloth {

struct MovingSurface;

/// Immutable data of a cloth. Vertices are renumbered: by component, and such that neighbors are near each
/// other in memory.
struct Model {
  Params params;
  int count = 0;  // vertices; arrays are padded to whole batches
  std::vector<int> original,
      model_vertex;                  // mesh vertex of each model vertex, and model vertex of each mesh vertex
  std::vector<int> component_begin;  // first vertex of each connected component, and the end
  aligned_vector<Real> mass;         // [kg]
  Rows rows;      // springs, or edges of a sheet with upper bounds of the membrane stiffness
  Rows far_rows;  // bending couplings of a sheet between vertices without a common edge
  aligned_vector<Real> extra_diagonal;  // diagonal of a sheet beyond the sums of its rows [N/m]
  Membrane membrane;                    // of a sheet
  std::size_t spring_count = 0;
  std::vector<Int3> triangles;      // in model numbering, sorted by their smallest vertex
  std::vector<int> triangle_begin;  // first triangle of each smallest vertex, and the end
  ChunkTriangles chunk_triangles;   // which of them touch each chunk of vertices
  NeighborLists excluded;           // pairs without contact: adjacent, or closer than the thickness at rest
  Blocks blocks;                    // of the two-level preconditioner; else empty
  LargePrimitives large;            // tested for vertex–triangle and edge–edge contacts
  Vectors x_rest;                   // [m]
  double area = 0, total_mass = 0;  // [m²] [kg]
  double mean_edge = 0, shortest_edge = 0;  // [m]
  std::vector<std::string> notes;           // sentences about unusual properties of the mesh
};

/// Held vertex.
struct Hold {
  int vertex = 0;  // of the model
  Vec3 goal;       // position at the end of the next step [m]
};

/// Linear system of one step, W Δv = h f̃, and the vectors of its solvers.
struct System {
  aligned_vector<Real> along,
      across;          // 16 per slot of the rows: s k (1 − l)/L² and s k l, with l = max(0, 1 − L₀/L)
  Vectors force;       // right-hand side h f̃ [N·s]
  Vectors inverse[2];  // inverse diagonal blocks: xx yy zz, xy xz yz [1/kg]
  Vectors change, previous;  // Δv now and one sweep ago [m/s]
  Vectors search, image,
      residual_vector;  // of conjugate gradients: direction p, product W p, residual r; else empty
  Vectors air[2];  // derivative of the wind impulse by velocity, negated: diagonal, off-diagonal; kept for
                   // the residual and conjugate gradients [kg]
  Real stiffness_factor = 0;  // s = h² + h β, β = Damping::stretch [s²]
  Real mass_factor = 1;       // 1 + h α, α = Damping::motion: factor of the mass in W [1]
  std::vector<double> drag;   // wind drag of each component without held vertices [kg]
  TwoLevelSystem two_level;
  int iterations = 0;   // of conjugate gradients in the latest step
  double residual = 0;  // of the latest solution, relative [1]
};

/// State one step ago, for BDF2.
struct Bdf2History {
  double dt = 0;  // 0 = no history [s]
  Vectors x, v;   // at the beginning of the latest step [m] [m/s]
};

/// All that a step changes.
struct State {
  double time = 0;                 // [s]
  double impulse_time = 0;         // time step that converts the impulses of the latest step to forces [s]
  Bdf2History history;             // empty with backward Euler
  Vectors x, v;                    // positions, velocities [m] [m/s]
  aligned_vector<Real> free_mass;  // mass; 0 = held [kg]
  std::vector<Hold> holds;         // ascending by vertex
  System system;
  Contacts contacts;
  ImplicitContacts implicit_contacts;  // of conjugate gradients
  SpatialHash spatial_hash;
  CcdWorkspace ccd;
  Real largest_speed = 0;  // after the latest step [m/s]
};

/// Obstacle of a cloth (contact/obstacle.hpp). `moving` owns the surface that the view refers to.
struct Obstacle : ObstacleView {
  std::shared_ptr<const MovingSurface> moving;
  std::optional<FreeInertia> free;  // of an obstacle that the cloth moves; used by conjugate gradients only
};

/// Spring between a vertex and a position (forces/vertex_springs.hpp).
struct VertexSpring {
  int vertex = 0;      // of the model
  Vec3 target;         // [m]
  Real stiffness = 0;  // k [N/m]
  Real slack = 0;      // s: distance up to which it has no force [m]
};

/// Force on a vertex, as of a spring between two cloths.
struct VertexLoad {
  int vertex = 0;  // of the model
  Vec3 force;      // [N]
};

/// External inputs of one step.
struct Inputs {
  Vec3d gravity;  // [m/s²]
  Air air;
  std::vector<Obstacle> obstacles;
  std::vector<VertexSpring> springs;  // on the host only
  std::vector<VertexLoad> loads;      // on the host only
  bool measure_residual = false;      // costs about one sweep
};

}  // namespace turgor::cloth
