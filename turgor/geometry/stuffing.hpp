// Isosurface stuffing: fills a shape with tetrahedra of a body-centered cubic lattice, warped and cut at the
// surface so that every dihedral angle stays between 10.7° and 164.8° for any shape. This is the uniform
// variant of [Labelle, Shewchuk 2007]; it does not grade the element size.
#pragma once

#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/core/progress.hpp"
#include "turgor/geometry/bcc_lattice.hpp"
#include "turgor/geometry/signed_distance.hpp"
#include "turgor/geometry/solid_mesh.hpp"

namespace turgor {

/// Bounds that the paper proves for these warping distances [degrees].
constexpr double kLeastStuffedDihedral = 10.7843, kLargestStuffedDihedral = 164.7376;

/// A shape with its distances at the points of a lattice, so that several levels can be stuffed.
struct LatticeSamples {
  SignedDistance shape;
  BccLattice lattice;
  std::vector<float> distance;  // of every point [m]
};

/// Lattice with cubes of this size [m] that extends `margin` [m] and one cube beyond the shape.
BccLattice lattice_around(const SignedDistance& shape, double size, double margin);
LatticeSamples sample(const Exec& exec, SignedDistance shape, const BccLattice& lattice,
                      const Progress& progress = {});

/// Fills the inside of a shape (distance < level, with level below the lattice's margin) with tetrahedra
/// whose edges are about as long as the lattice's cubes. The surface is a closed manifold with its vertices
/// on the level. Details thinner than the lattice may separate or vanish; the result may be empty.
SolidMesh stuff(const Exec& exec, const LatticeSamples& samples, double level = 0);

}  // namespace turgor
