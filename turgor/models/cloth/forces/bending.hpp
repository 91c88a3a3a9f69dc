// Bending rigidity of a sheet on any triangles: the second derivative of the surface is averaged around every
// vertex from the folds of its edges, and B times its square integrated. With the shape at rest unrolled flat
// that is a quadratic form of the places, whose weights never change. Equations: docs/models/cloth.md.
#pragma once

#include <vector>

#include "turgor/geometry/tri_mesh.hpp"
#include "turgor/models/cloth/model/rows.hpp"

namespace turgor::cloth {

struct Fabric;

/// One weight for every two vertices that bending couples: Spring::bend, the force on one over the way to the
/// other, negative between those farther apart [N/m].
std::vector<Spring> bending_weights(const TriMesh& mesh, const Fabric& fabric);

/// What Jacobi's diagonal needs beyond the sum of a row to outweigh it: half of what rows of both signs lack
/// [N/m], by vertex.
std::vector<double> lacking_weight(const std::vector<Spring>& springs, int count);

}  // namespace turgor::cloth
