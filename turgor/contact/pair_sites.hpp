// Sites between two deformed surfaces: vertices of one that are near the other, and the reverse. A vertex
// meets the nearest point of the other surface. Where vertices of both surfaces meet, one site is made.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "turgor/contact/coupling.hpp"
#include "turgor/geometry/triangle_tree.hpp"

namespace turgor::contact {

/// One of the two surfaces.
struct PairSurface {
  int body = 0;                         // see SurfacePoint
  std::span<const Vec3d> rest, x;       // of every vertex of the mesh: at rest, and now [m]
  std::span<const Int3> triangles;      // counter-clockwise seen from outside
  std::span<const double> rest_height;  // of every vertex above the other surface at rest [m]; empty =
                                        // unknown
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

/// Height of every surface vertex of the first above the second at rest, within `reach`; else `reach` [m].
std::vector<double> rest_heights(const Exec& exec, const PairSurface& of, const PairSurface& above,
                                 double reach, double deepest);

/// Mean length of the edges of a surface [m].
double mean_edge(std::span<const Vec3d> x, std::span<const Int3> triangles);

}  // namespace turgor::contact
