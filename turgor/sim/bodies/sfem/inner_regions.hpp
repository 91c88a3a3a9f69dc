// Regions of another material inside a body, such as a nodule in a liver: their surfaces for drawing, and
// bounding spheres for marks in force curves.
#pragma once

#include <string>
#include <vector>

#include "turgor/models/sfem/sfem.hpp"
#include "turgor/sim/scene/sfem_scene.hpp"

namespace turgor {

struct InnerRegion {
  std::string name;             // from the scene
  int material = 0;             // index into sfem::Body::materials
  std::vector<int> vertices;    // indices in the body's mesh, ascending
  std::vector<Int3> triangles;  // of `vertices`, counter-clockwise seen from outside the region
  Vec3d center;                 // center of mass [m]
  double radius = 0;            // radius of a sphere of the same volume [m]
};

/// Regions of all materials except the body's own, in the order of the scene.
std::vector<InnerRegion> inner_regions(const SfemScene& scene, const sfem::Body& body);

/// The same with names only, for drawing recorded surfaces.
std::vector<InnerRegion> named_regions(const SfemScene& scene);

}  // namespace turgor
