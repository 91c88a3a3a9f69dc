// Stiffness over the surface of a body of finite elements, for chains that lie on it: an organ is softer than
// a half space where it is thin or far from what holds it, and stiffer beside that. Its Green's functions say
// by how much.
#pragma once

#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/core/result.hpp"
#include "turgor/models/rhombus/rhombus.hpp"
#include "turgor/models/sfem/sfem.hpp"

namespace turgor {

/// The surface of a solid, and which of its vertices it is made of.
struct SurfacePart {
  rhombus::Body body;
  std::vector<int> vertices;  // of the solid, by vertex of the surface
};
SurfacePart surface_part(const sfem::Model& model);

/// The radius at which a ball of this one touches tissue that it presses by a third of it [m].
inline double usual_contact(double tip) { return 0.6 * tip; }

/// At each vertex of that surface: how many times as stiff the body is as a half space of its first material,
/// under a disc of this radius. Two edges around, elements know how far a body moves as a whole, not what is
/// next to a touch: what the body gives more than a half space would under Hertz's pressure there is added
/// to what a half space gives under the disc. Between 1/50 and 50; that much where it is held. Error:
/// Green's functions are there for some columns only.
Result<std::vector<double>> elastic_stiffness(const Exec& exec, const sfem::Model& model,
                                              const SurfacePart& part, const rhombus::Surface& surface,
                                              double disc);

}  // namespace turgor
