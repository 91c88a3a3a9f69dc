// Tetrahedral meshes of organs from a closed surface or a label of a segmentation. The input is checked and
// stuffed (stuffing.hpp); the mesh has the input's volume and is its largest component. Notes report all
// changes.
#pragma once

#include <cstdint>
#include <functional>
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

/// Sides of the mesh: flat, or quadratic tetrahedra whose midside nodes are on the surface (curve_sides.hpp),
/// which halves the edge length of the boundary polyhedron.
enum class Sides : std::uint8_t { kFlat, kCurved };

/// Expected cost of a mesh, before it is made.
struct MeshForecast {
  double points = 0;    // of the lattice
  double elements = 0;  // tetrahedra
  double seconds = 0;   // wall time, from a few measured distances
};

/// Least number of edges across a body for which the user gave no size of elements: MeshBound::edges.
constexpr double kEdgesAcross = 5;

/// Limits of a mesh. `begin` is called with the forecast before the work starts.
struct MeshBound {
  double elements = 1e7;
  double edges = 0;  // at least, along the cube root of the body's volume; a smaller size is chosen for them
  std::function<void(const MeshForecast&)> begin;
};

/// Cavities of a labeled body, where it encloses voxels of other labels.
struct Cavities {
  bool are_filled = true;     // with the body's own tissue
  std::vector<int> kept_out;  // labels of other bodies, which are not filled
};

struct OrganMesh {
  SolidMesh mesh;
  double input_volume = 0;         // of the surface's or the label's largest component, cavities filled [m³]
  std::vector<std::string> notes;  // what was dropped, reversed or doubtful: sentences
};

/// Tetrahedra of about this edge length [m] inside a closed surface. Error: as in surface_check.hpp, a
/// size that does not fit the surface, or more elements than the bound.
Result<OrganMesh> mesh_of_surface(const Exec& exec, const TriMesh& surface, double size,
                                  const Progress& progress = {}, Sides sides = Sides::kFlat,
                                  const MeshBound& bound = {});

/// The same inside all voxels with one of the labels, such as an organ and its nodules, and inside the
/// cavities that they enclose. Every element's region is the label at its centroid, or the first label if
/// that is another one.
Result<OrganMesh> mesh_of_labels(const Exec& exec, const LabelVolume& labels, std::span<const int> chosen,
                                 double size, const Progress& progress = {}, Sides sides = Sides::kFlat,
                                 const MeshBound& bound = {}, const Cavities& cavities = {});

}  // namespace turgor
