// The cloth model: a sheet of springs in the wind that stays out of itself. Backward Euler is solved by
// Jacobi sweeps with 3×3 blocks on the diagonal [Kang 2004], accelerated, or by conjugate gradients on the
// same matrix; contacts are found by hashing. Equations, and what differs from the paper:
// docs/models/cloth.md.
//
//   build        checks the mesh, makes springs or a sheet, masses, renumbers (build.cpp)
//   step         wind, forces and matrix, sweeps, contacts, motion            (step.cpp)
//   hold         vertices that are pinned, or follow something                (hold.cpp)
//   measure      energy, momentum, penetrations                               (measure.cpp)
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/core/result.hpp"
#include "turgor/geometry/tri_mesh.hpp"
#include "turgor/models/cloth/ccd/ccd.hpp"
#include "turgor/models/cloth/contact/contact.hpp"
#include "turgor/models/cloth/contact/obstacle_shape.hpp"
#include "turgor/models/cloth/contact/spatial_hash.hpp"
#include "turgor/models/cloth/forces/membrane.hpp"
#include "turgor/models/cloth/forces/wind.hpp"
#include "turgor/models/cloth/model/rows.hpp"
#include "turgor/models/cloth/model/vectors.hpp"
#include "turgor/models/cloth/solver/implicit_contact.hpp"
#include "turgor/models/cloth/solver/two_level.hpp"

namespace turgor::cloth {

struct MovingSurface;

/// What the forces of a fabric follow: a sheet that is the same on any mesh, or the springs of the paper.
enum class Law : std::uint8_t { kSheet, kSprings };

/// Stiffness is force per width at a strain of 1, as of a membrane.
struct Fabric {
  Law law = Law::kSprings;
  double density = 0.2;         // [kg/m²]
  double warp = 1000;           // along the warp [N/m]
  double weft = 1000;           // across it [N/m]
  double shear = 200;           // of a sheet, per radian of shear; of springs, on the bias [N/m]
  double poisson = 0;           // of a sheet: how much it narrows across a warp that is pulled [1]
  double rigidity_warp = 1e-5;  // of a sheet: moment per width by the curvature of its warp [N·m]
  double rigidity_weft = 1e-5;  // and of its weft [N·m]
  double bend = 20;             // of the springs across edges, which resist folding [N/m]
  Vec3d direction{1, 0, 0};     // of the warp, where the mesh lies; need not lie in it
};

struct Damping {
  double motion = 0.2;     // velocities lose exp(-motion·t) [1/s]
  double stretch = 0.001;  // Rayleigh: force by the rate of stretch, in multiples of stiffness [s]
};

/// How (M − h²J) Δv = h f̃ is solved.
enum class Method : std::uint8_t { kJacobi, kChebyshev, kConjugateGradients, kBlocks };

/// Conjugate gradients, alone or with blocks of vertices that are solved at once (two_level.hpp).
inline bool uses_gradients(Method method) {
  return method == Method::kConjugateGradients || method == Method::kBlocks;
}

/// Backward Euler damps what swings; the two-step formula (BDF2) hardly does.
enum class Integrator : std::uint8_t { kEuler, kBdf2 };

struct Solver {
  Integrator integrator = Integrator::kEuler;
  Method method = Method::kChebyshev;
  int sweeps = 16;          // or iterations of conjugate gradients, at most; at least 1
  double tolerance = 0.01;  // residual at which conjugate gradients stop; 0 = they do all iterations [1]
  double strain_limit =
      0;  // no spring is pulled longer than 1 + this times its rest length; 0 = no limit [1]
};

struct Collision {
  bool self = true;
  double thickness = 0.005;  // θ_c, smallest distance of two layers [m]
  double friction = 0.3;     // Coulomb's coefficient between layers [1]
  int iterations = 12;       // at most, of velocities and of places
};

struct Params {
  Fabric fabric;
  Damping damping;
  Solver solver;
  Collision collision;
  double weld = 0;  // vertices closer than this are one: closes the seams of a garment [m]
};

/// What does not change. Vertices are numbered anew: by part, and so that neighbours are near each other in
/// memory.
struct Model {
  Params params;
  int count = 0;                     // vertices; arrays are padded to whole batches
  std::vector<int> original, place;  // vertex of the mesh by vertex of the model, and back
  std::vector<int> part_begin;       // first vertex of each connected part, and the end
  aligned_vector<Real> mass;         // [kg]
  Rows rows;                         // springs, or a sheet's edges: bounds of the membrane's stiffness
  Rows far_rows;                     // a sheet's bending between vertices that no edge joins
  aligned_vector<Real> spare;        // what a sheet's diagonal has beyond the sums of its rows [N/m]
  Membrane membrane;                 // of a sheet
  std::size_t spring_count = 0;
  std::vector<Int3> triangles;      // of the model's vertices, by their smallest vertex
  std::vector<int> triangle_begin;  // of each smallest vertex, and the end
  ChunkTriangles chunk_triangles;   // which of them touch each chunk of vertices
  NeighborLists near;               // adjacent, or closer than the thickness at rest: never in contact
  Blocks blocks;                    // of the solver of that name
  LargePrimitives coarse;           // edges and triangles between whose vertices a vertex could slip
  Vectors x_rest;                   // [m]
  double area = 0, total_mass = 0;  // [m²] [kg]
  double mean_edge = 0, shortest_edge = 0;  // [m]
  std::vector<std::string> notes;           // sentences about what is unusual in the mesh
};

/// A vertex that goes where it is told.
struct Hold {
  int vertex = 0;  // of the model
  Vec3 goal;       // where it is at the end of the next step [m]
};

/// The linear system of one step and what its solvers need.
struct System {
  aligned_vector<Real> along, across;  // 16 a slot of the rows: s k (1 − l)/L² and s k l, s = h² + h·damping
  Vectors force;                       // right-hand side h f̃ [N·s]
  Vectors inverse[2];                  // of the diagonal blocks: xx yy zz, xy xz yz [1/kg]
  Vectors change, before;              // Δv now and a sweep ago [m/s]
  Vectors search, image, left;         // of conjugate gradients: direction, W times it, residual; else empty
  Vectors air[2];  // how fast the air's impulse falls with velocity, for the residual and conjugate gradients
                   // [kg]
  Real square = 0;           // s = h² + h·damping [s²]
  Real keep = 1;             // by how much damping of motion makes masses larger [1]
  std::vector<double> drag;  // of the air on each part that nothing holds [kg]
  TwoLevelSystem blocks;
  int iterations = 0;   // of conjugate gradients in the latest step
  double residual = 0;  // that they left [1]
};

/// Of the step before, for the two-step formula.
struct Bdf2History {
  double dt = 0;  // 0 = there is none [s]
  Vectors x, v;   // where it began [m] [m/s]
};

/// What changes.
struct State {
  double time = 0;                 // [s]
  double impulse_time = 0;         // in which forces make the impulses of the latest step [s]
  Bdf2History last;                // empty with backward Euler
  Vectors x, v;                    // [m] [m/s]
  aligned_vector<Real> free_mass;  // [kg]; 0 = held
  std::vector<Hold> holds;         // ascending by vertex
  System system;
  Contacts contacts;
  ImplicitContacts implicit_contacts;  // of conjugate gradients
  SpatialHash spatial_hash;
  CcdWorkspace ccd;
  Real largest_speed = 0;  // after the latest step [m/s]
};

/// Something that the cloth must stay out of (obstacle.hpp), with what it points to where that is its own.
struct Obstacle : ObstacleView {
  std::shared_ptr<const MovingSurface> moving;
};

struct Inputs {
  Vec3d gravity;  // [m/s²]
  Air air;
  std::vector<Obstacle> obstacles;
  bool measure_residual = false;  // costs about one sweep
};

/// How far the step is from the solution of its linear system, relative to its right-hand side: |b − W
/// Δv|/|b|.
struct StepReport {
  bool finite = true;      // false: the step was undone, and the cloth is at rest
  Real largest_speed = 0;  // [m/s]
  double residual = -1;    // -1 = not known: sweeps, and nobody asked [1]
  int contacts = 0;        // pairs that were looked at closely
  int contact_iterations = 0;
  int iterations = 0;  // of conjugate gradients
  int in_impact_zone =
      0;  // vertices that moved as one with others, since they would have passed through them
};

/// Error, with the ids of what is wrong: no triangle, a vertex that is no finite place, in no triangle (it
/// would have no mass), a triangle without area, numbers of the fabric that are not positive, a thickness
/// that is larger than half of the mesh's edges.
Result<Model> build(const Exec& exec, const TriMesh& mesh, const Params& params);
State make_state(const Model& model);
StepReport step(const Exec& exec, const Model& model, State& state, const Inputs& inputs, double frame);

/// Holds a vertex of the mesh where it is; from then on it goes to its goal in each step. Error: no such
/// vertex.
Status hold(const Model& model, State& state, int mesh_vertex);
/// Where a held vertex shall be at the end of the next step [m]. Error: the vertex is not held.
Status move_hold(const Model& model, State& state, int mesh_vertex, Vec3 goal);
/// Lets it go, with the velocity it has.
Status release(const Model& model, State& state, int mesh_vertex);

/// The mesh that was given as it lies now: its triangles, with its numbers.
TriMesh surface(const Model& model, const State& state, std::vector<Int3> mesh_triangles);
/// How far each vertex of the mesh is from where it was given [m].
std::vector<Vec3> displacements(const Model& model, const State& state);
/// The sheet as it lies now, in the numbering and with the triangles of the model; without normals.
TriMesh model_surface(const Model& model, const State& state);

/// Memory of a model and its state while it runs.
std::size_t memory_bytes(const Model& model, const State& state);
/// Equal for equal places and velocities, whatever the number of threads.
std::uint64_t state_hash(const Model& model, const State& state);

}  // namespace turgor::cloth
