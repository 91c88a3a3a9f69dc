// Synthetic surfaces for trying tools: a liver and a pair of forceps, with the vertex and triangle counts of
// [RC] Zhang, Song, Sun, Zou 2010.
#pragma once

#include <cstddef>
#include <utility>

#include "turgor/geometry/tri_mesh.hpp"

namespace turgor {

/// A liver of 0.22 m, closed and of genus 0: 3116 vertices and 6228 triangles at `detail` = 1, which divides
/// the edge length.
TriMesh phantom_liver(double detail = 1);

/// One of the two mirror-symmetric halves of forceps: a finger ring, a shank and a jaw, 87 vertices and 174
/// triangles. In the closed position the jaws are 0.1 mm apart (coincident corners would be welded), with
/// their tip at the origin and the rings 0.13 m above it (z). `mirrored` gives the half of negative x.
TriMesh phantom_forceps_half(bool mirrored);
/// Both halves: 174 vertices, 348 triangles.
TriMesh phantom_forceps();

}  // namespace turgor
