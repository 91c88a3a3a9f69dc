// Stiffness over the surface of a finite-element body, for rhombus chains on it. An organ is softer than a
// half space where it is thin or far from its fixed vertices, and stiffer near them; its Green's functions
// give the ratio.
#pragma once

#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/core/result.hpp"
#include "turgor/models/rhombus/rhombus.hpp"
#include "turgor/models/sfem/sfem.hpp"

namespace turgor {

/// Boundary surface of a solid, with the solid's vertex indices.
struct SolidBoundary {
  rhombus::Body body;
  std::vector<int> vertices;  // vertex of the solid for each surface vertex
};
SolidBoundary solid_boundary(const sfem::Model& model);

/// Contact radius of a ball of radius `tip` pressed in by a third of it [m].
inline double usual_contact(double tip) { return 0.6 * tip; }

/// Ratio of the body's stiffness to that of a half space of its first material, under a disc, at each surface
/// vertex. Within two edges of a contact, elements resolve the motion of the whole body but not the local
/// indentation. The difference between body and half space under Hertz's pressure is therefore added to the
/// half space's displacement under the disc. Clamped to 1/50 … 50; 50 at fixed vertices. Error: Green's
/// functions exist for some columns only.
Result<std::vector<double>> elastic_stiffness(const Exec& exec, const sfem::Model& model,
                                              const SolidBoundary& boundary, const rhombus::Surface& surface,
                                              double disc);

}  // namespace turgor
