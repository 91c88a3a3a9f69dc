// The surface that is drawn: the isosurface of the CT, split along the blades, flat caps where the scan ends,
// and the walls of wounds. A vertex is a point of a piece of the body (fragments.hpp) and goes with it, so
// that a closed cut is invisible and an open one is clean.
#pragma once

#include "turgor/geometry/tri_mesh.hpp"
#include "turgor/geometry/volume.hpp"
#include "turgor/models/lattice/cutting/fragments.hpp"

namespace turgor::lattice {

/// What carries a vertex: a piece of a cell, or (-1) the whole cell.
struct Carrier {
  int cell = 0;  // slot
  int piece = -1;
};

/// Two vertices that lay on each other where a blade crossed the skin.
struct Lip {
  int left = 0, right = 0;    // of the blade's way, vertices
  std::uint8_t incision = 0;  // of the scene
  Real along = 0;             // on the blade's path [m]
};

struct BodySurface {
  std::vector<Vec3> rest;        // vertices as in the CT, lattice frame [m]
  std::vector<Carrier> carrier;  // of each
  std::vector<int> slot;         // the node that each is nearest to on its own side
  std::vector<int> twin;         // the vertex on the other lip of a cut where they met; -1 = none
  std::vector<Lip> lips;
  std::vector<Int3> triangles;  // skin first (caps last among it), then walls
  int skin_triangles = 0;
  Fragments pieces;  // that carry them
};

/// What colours the skin.
enum class Shown : std::uint8_t { kNothing, kDisplacement, kStretch };
/// All of it, or only what is near cuts.
enum class Extent : std::uint8_t { kAll, kCuts };

/// surface_assembly.hpp: what was found in the slabs of a body's cells.
namespace detail {
struct KnownSlabs;
}

/// The surface of the body in the CT, with the state's cuts and removed nodes; to be made again when those
/// change. `ct`: what the body was built from; without it, the surface is that of the nodes' values. `known`:
/// from the last time with the same model and CT, for a surface that is made again and again of all of it;
/// the surface is the same without.
BodySurface build_surface(const Model& model, const State& state, const CtVolume* ct = nullptr,
                          Extent extent = Extent::kAll, const Exec& exec = Exec(1),
                          detail::KnownSlabs* known = nullptr);
/// The surface where the body is now, in the patient frame [m], with smooth normals (walls, caps and skin
/// apart) and a scalar a vertex: displacement [m], or the skin's area ratio A / A_CT − 1.
TriMesh deformed_surface(const Model& model, const State& state, const BodySurface& surface, Shown shown);
/// The nodes whose displacements it looks at, ascending: they follow from the cuts.
std::vector<int> nodes_behind(const Model& model, const State& state, const BodySurface& surface);
/// Displacement of one vertex, lattice frame [m].
Vec3 vertex_displacement(const Model& model, const State& state, const BodySurface& surface, int vertex);
/// The nodes that it is found from, added to a list.
void add_nodes_behind(const Model& model, const State& state, const BodySurface& surface, int vertex,
                      std::vector<int>& nodes);
/// Where the CT shows what each vertex is made of, patient frame [m].
std::vector<Vec3d> rest_points(const Model& model, const BodySurface& surface);

}  // namespace turgor::lattice
