// Geodesic distances on a surface from one of its points, up to a radius. A front propagates over the
// triangles. At an edge, the distances of its ends give the position of the source with all triangles behind
// unfolded into one plane, and the next vertex is measured from there [Novotni, Klein 2002]. Exact on planes
// in any triangulation. On curved surfaces the error decreases with the edge length: 0.3 % on a sphere of 5
// cm with edges of 4 mm, 8 cm away.
#pragma once

#include <utility>
#include <vector>

#include "turgor/geometry/triangle_tree.hpp"
#include "turgor/models/rhombus/surface.hpp"

namespace turgor::rhombus {

struct GeodesicField {
  std::vector<double> distance;  // of every vertex; infinite where not reached [m]
  std::vector<int> reached;      // vertices with a distance, ascending; some are beyond the radius
  TrianglePoint source;
  double radius = 0;  // limit of valid distances [m]

  std::vector<std::pair<double, int>> front;  // valid during propagation only
};

/// Computes distances from a point of the surface. A field may be reused; only the vertices that it had
/// reached are cleared.
void measure_distances(const Surface& surface, const TrianglePoint& source, double radius,
                       GeodesicField& field);

}  // namespace turgor::rhombus
