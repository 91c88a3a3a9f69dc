// Surfaces to try tools on without patient data: a liver and a pair of forceps, with the numbers of vertices
// and triangles of [RC] Zhang, Song, Sun, Zou 2010.
#pragma once

#include <cstddef>
#include <utility>

#include "turgor/geometry/tri_mesh.hpp"

namespace turgor {

/// A liver of 0.22 m, closed and without handles: 3116 vertices and 6228 triangles at `detail` = 1; edges get
/// shorter by it.
TriMesh phantom_liver(double detail = 1);

/// One of the two mirror-symmetric halves of forceps: a finger ring, a shank and a jaw, 87 vertices and 174
/// triangles. Closed, the jaws are a tenth of a millimetre apart (at
/// one place, programs would take their corners for one), their tip at the origin; the rings are
/// 0.13 m above it (z). `mirrored` gives the half of negative x.
TriMesh phantom_forceps_half(bool mirrored);
/// Both halves: 174 vertices, 348 triangles.
TriMesh phantom_forceps();

}  // namespace turgor
