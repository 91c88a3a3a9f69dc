// Isosurface stuffing: fills a shape with tetrahedra of a body-centred cubic lattice, warped and cut at the
// surface so that every dihedral angle stays between 10.7° and 164.8°, whatever the shape. The uniform
// variant of [Labelle, Shewchuk 2007].
#pragma once

#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/geometry/bcc_lattice.hpp"
#include "turgor/geometry/signed_distance.hpp"
#include "turgor/geometry/solid_mesh.hpp"

namespace turgor {

/// What the paper proves for the warping distances used here [degrees].
constexpr double kLeastStuffedDihedral = 10.7843, kLargestStuffedDihedral = 164.7376;

/// A shape and its distances at the points of a lattice, so that several levels can be stuffed.
struct LatticeSamples {
  SignedDistance shape;
  BccLattice lattice;
  std::vector<float> distance;  // of every point [m]
};

/// The lattice of cubes of this size [m] that reaches `margin` [m] and a cube beyond the shape.
BccLattice lattice_around(const SignedDistance& shape, double size, double margin);
LatticeSamples sample(const Exec& exec, SignedDistance shape, const BccLattice& lattice);

/// The inside of a shape (distance < level, less than the lattice's margin) as tetrahedra whose edges are
/// about as long as the lattice's cubes. The surface is a closed manifold, its vertices lie on the level.
/// Details thinner than the lattice may break apart or vanish; nothing may be left.
SolidMesh stuff(const Exec& exec, const LatticeSamples& samples, double level = 0);

}  // namespace turgor
