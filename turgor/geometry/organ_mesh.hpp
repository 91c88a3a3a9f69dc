// From what people have of an organ, a closed surface or a label of a segmentation, to a mesh of tetrahedra
// that a body can be made of: checks the input, stuffs it, keeps its volume and its largest part, and says
// what was done.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/core/progress.hpp"
#include "turgor/core/result.hpp"
#include "turgor/geometry/solid_mesh.hpp"
#include "turgor/geometry/tri_mesh.hpp"
#include "turgor/geometry/volume.hpp"

namespace turgor {

/// What lies between the corners of a mesh's outer faces: planes, or quadratic tetrahedra whose middles are
/// on the surface (curve_sides.hpp), a polyhedron in it whose edges are half as long.
enum class Sides : std::uint8_t { kFlat, kCurved };

struct OrganMesh {
  SolidMesh mesh;
  double input_volume = 0;         // of the largest part of the surface or of the labelled voxels [m³]
  std::vector<std::string> notes;  // what was dropped, turned round or doubtful: sentences
};

/// Tetrahedra of about this edge length [m] inside a closed surface. Error: what surface_check.hpp refuses,
/// or a size that does not suit the surface.
Result<OrganMesh> mesh_of_surface(const Exec& exec, const TriMesh& surface, double size,
                                  const Progress& progress = {}, Sides sides = Sides::kFlat);

/// The same inside all voxels that have one of the labels, such as an organ and the nodules in it. Every
/// element's region is the label at its centroid; where that is none of them, the first label.
Result<OrganMesh> mesh_of_labels(const Exec& exec, const LabelVolume& labels, std::span<const int> wanted,
                                 double size, const Progress& progress = {}, Sides sides = Sides::kFlat);

}  // namespace turgor
