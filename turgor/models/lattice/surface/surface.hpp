// The drawn surface: the isosurface of the CT by marching tetrahedra, split along blades, with flat caps at
// the borders of the scan and the walls of wounds. Each vertex is embedded in a fragment (fragments.hpp). So
// a closed cut is invisible, and an open one has clean lips.
#pragma once

#include <memory>

#include "turgor/core/exec.hpp"
#include "turgor/geometry/tri_mesh.hpp"
#include "turgor/geometry/volume.hpp"
#include "turgor/models/lattice/cutting/fragments.hpp"

namespace turgor::lattice {

/// Cell and fragment in which a vertex is embedded; fragment -1 means the whole cell.
struct EmbeddingCell {
  int cell = 0;  // slot
  int fragment = -1;
};

namespace detail {
struct SurfaceCache;  // meshed cells of a body (surface_cache.hpp)
struct SurfacePlan;   // what the deformation needs of a surface (surface_plan.hpp)
}  // namespace detail

/// Pair of vertices that coincided at rest where a blade crossed the skin.
struct Lip {
  int left = 0, right = 0;    // vertices on the blade's left and right side
  std::uint8_t incision = 0;  // index of the scene's incision
  Real along = 0;             // arc length on the blade's path [m]
};

struct BodySurface {
  std::vector<Vec3> rest;                // rest positions of the vertices, lattice frame [m]
  std::vector<EmbeddingCell> embedding;  // by vertex
  std::vector<int> slot;                 // by vertex: nearest node on its side of the cuts
  std::vector<int> twin;                 // by vertex: coincident vertex on the other lip; -1 = none
  std::vector<Lip> lips;
  std::vector<Int3> triangles;  // skin with caps last, then walls
  int skin_triangles = 0;       // with caps
  int cap_triangles = 0;
  std::shared_ptr<const Fragments> fragments;  // in which the vertices are embedded; null: no surface yet
  std::shared_ptr<const detail::SurfacePlan> plan;  // of a whole surface, for deformed_surface; or null
};

/// Scalar shown on the skin.
enum class Shown : std::uint8_t { kNothing, kDisplacement, kStretch };
/// Extent of the surface: all of it, or only cells near cuts.
enum class Extent : std::uint8_t { kAll, kCuts };

/// Builds the rest surface for these cuts and removed nodes; rebuild it when they change. `ct` is the
/// CT that the body was built from. Without it, the surface is that of the nodes' values. `cache` comes from
/// an earlier call with the same model and CT and extent kAll. It saves time and does not change the surface.
/// Surroundings in the CT are air.
BodySurface build_surface(const Model& model, const Cuts& cuts, const CtVolume* ct = nullptr,
                          Extent extent = Extent::kAll, const Exec& exec = Exec(1),
                          detail::SurfaceCache* cache = nullptr);
/// Deformed surface in the patient frame [m]. Normals are smooth; walls, caps and skin have separate ones.
/// The scalar of each vertex is displacement [m], or the skin's area ratio A / A_CT − 1.
TriMesh deformed_surface(const Model& model, const State& state, const BodySurface& surface, Shown shown,
                         const Exec& exec = Exec(1));
/// Nodes whose displacements determine the deformed surface, ascending. They depend only on the cuts.
std::vector<int> support_nodes(const Model& model, const Cuts& cuts,
                               std::span<const VirtualNodeDisplacement> virtual_u,
                               const BodySurface& surface);
/// Displacement of one vertex, lattice frame [m].
Vec3 vertex_displacement(const Model& model, const State& state, const BodySurface& surface, int vertex);
/// Appends the nodes that determine it.
void add_support_nodes(const Model& model, const Cuts& cuts,
                       std::span<const VirtualNodeDisplacement> virtual_u, const BodySurface& surface,
                       int vertex, std::vector<int>& nodes);
/// Rest positions of the vertices, patient frame [m].
std::vector<Vec3d> rest_points(const Model& model, const BodySurface& surface);

}  // namespace turgor::lattice
