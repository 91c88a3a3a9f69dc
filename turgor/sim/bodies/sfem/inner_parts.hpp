// What is of another material inside a body of elements, such as a nodule in a liver: its surface, for
// pictures that show it through the body, and where it is, for curves that say when a tool is over it.
#pragma once

#include <string>
#include <vector>

#include "turgor/models/sfem/sfem.hpp"
#include "turgor/sim/scene/sfem_scene.hpp"

namespace turgor {

struct InnerPart {
  std::string name;             // of the scene
  std::vector<int> vertices;    // of the body's mesh, ascending
  std::vector<Int3> triangles;  // of `vertices`, counter-clockwise seen from outside the part
  Vec3d center;                 // of its volume [m]
  double radius = 0;            // of a ball of that volume [m]
};

/// Of every material but the body's own, in the order of the scene.
std::vector<InnerPart> inner_parts(const SfemScene& scene, const sfem::Body& body);

}  // namespace turgor
