// Sites between two deformed surfaces: vertices of one that are near the other, and the reverse. A vertex
// meets the nearest point of the other surface. Where vertices of both surfaces meet, one site is made. Sharp
// edges that cross meet (edge_sites.cpp). Balls and capsules touch exactly, by
// their segment and radius (round_sites.cpp).
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "turgor/contact/coupling.hpp"
#include "turgor/geometry/pose.hpp"
#include "turgor/geometry/triangle_tree.hpp"

namespace turgor::contact {

/// A ball or a capsule in its present pose.
struct RoundSurface {
  double radius = 0;          // [m]
  std::array<Vec3d, 2> ends;  // of its segment [m]
  Pose pose;                  // takes positions at rest to the present ones
};

/// A plane that does not move, with the bodies on the side of its normal.
struct GroundPlane {
  Vec3d through;          // [m]
  Vec3d normal{0, 0, 1};  // unit
};

/// One of the two surfaces.
struct PairSurface {
  int body = 0;                            // see SurfacePoint
  std::span<const Vec3d> rest, x;          // of every vertex of the mesh: at rest, and now [m]
  std::span<const Int3> triangles;         // counter-clockwise seen from outside
  std::span<const double> rest_height;     // of every vertex above the other surface at rest [m]; empty =
                                           // unknown
  std::optional<RoundSurface> round = {};  // exact shape of a mesh that is a picture of it
  bool by_vertices = false;  // true: round surfaces touch vertices alone, where a whole triangle is near
};

struct PairParams {
  double gap = 0;       // distance that is kept between the surfaces, where they were apart at rest [m]
  double reach = 0;     // distance within which sites are made [m]
  double deepest = 0;   // depth below which a vertex is taken to belong to another side [m]
  double friction = 0;  // Coulomb's μ [1]
  int capacity = 96;    // most sites; the nearest are kept
};

struct PairSites {
  std::vector<PairSite> sites;
  int dropped = 0;     // touching vertices beyond the capacity
  double deepest = 0;  // largest depth below the distance to be kept, before the solution [m]
};

/// Sites with the forces and anchors of the last ones.
PairSites find_pair_sites(const Exec& exec, const std::array<PairSurface, 2>& surfaces,
                          const PairParams& params, std::span<const PairSite> last);

/// Sites of one surface on the ground.
PairSites find_ground_sites(const PairSurface& surface, const GroundPlane& ground, const PairParams& params,
                            std::span<const PairSite> last);

/// Nodes that carry the surface of a lattice, each with the point of the surface nearest to it.
struct SurfaceNodes {
  std::span<const Vec3d> rest, x;       // that point of every node: at rest, and now [m]
  std::span<const int> vertex;          // of the surface, next to it
  std::span<const double> rest_height;  // as in PairSurface; empty = unknown
};

/// Sites of nodes of the first surface on the second one. PairSite::node is the index of the node.
PairSites find_node_sites(const Exec& exec, const SurfaceNodes& nodes,
                          const std::array<PairSurface, 2>& surfaces, const PairParams& params,
                          std::span<const PairSite> last);
/// The same on the ground, of nodes of the body `index`.
PairSites find_node_sites(const SurfaceNodes& nodes, int index, const GroundPlane& ground,
                          const PairParams& params, std::span<const PairSite> last);
/// Height of every node above another surface at rest, within `reach`; else `reach` [m].
std::vector<double> rest_heights(const Exec& exec, const SurfaceNodes& nodes,
                                 const std::array<PairSurface, 2>& surfaces, const PairParams& params);

/// Sites of sharp edges that cross (edge_sites.cpp). One that stuck keeps its point of the first edge.
std::vector<PairSite> find_edge_sites(const std::array<PairSurface, 2>& surfaces, const PairParams& params,
                                      std::span<const PairSite> last);

/// Sites of nodes of the first surface on the second one, a ball or a capsule; PairSite::node is set.
std::vector<PairSite> find_round_node_sites(const SurfaceNodes& nodes,
                                            const std::array<PairSurface, 2>& surfaces,
                                            const PairParams& params);
/// Sites of a pair with a ball or a capsule, and of a surface on the ground, not yet reduced to the capacity.
std::vector<PairSite> find_round_sites(const std::array<PairSurface, 2>& surfaces, const PairParams& params);
std::vector<PairSite> ground_sites(const PairSurface& surface, const GroundPlane& ground,
                                   const PairParams& params);

/// Height of every surface vertex of the first above the second at rest, within `reach`; else `reach` [m].
std::vector<double> rest_heights(const Exec& exec, const PairSurface& of, const PairSurface& above,
                                 double reach, double deepest);

/// Mean length of the edges of a surface [m].
double mean_edge(std::span<const Vec3d> x, std::span<const Int3> triangles);

}  // namespace turgor::contact
