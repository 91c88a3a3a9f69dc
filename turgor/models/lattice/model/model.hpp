// Data of a lattice body that no step changes: parameters, anatomy, springs and the tables of the solvers.
// Data that a step changes is in state.hpp.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "turgor/core/aligned.hpp"
#include "turgor/geometry/lattice.hpp"
#include "turgor/geometry/volume.hpp"
#include "turgor/models/lattice/model/params.hpp"
#include "turgor/models/lattice/model/runs.hpp"
#include "turgor/models/lattice/model/surroundings.hpp"

namespace turgor::lattice {

/// Material of a node. Outside is air around the body; gas is air inside it (lungs, bowel).
enum class Tissue : std::uint8_t { kOutside, kGas, kFat, kMuscle, kBone };
inline bool is_body(Tissue t) { return t != Tissue::kOutside; }

/// Skin triangle. F d = Σ along[q] x[vertex[q]] is the image of the unit vector d along Langer's lines;
/// `across` holds the coefficients of the perpendicular direction.
struct SkinTriangle {
  Int3 vertex;        // slots, counter-clockwise seen from outside
  Vec3 edge1, edge2;  // at rest, from the first corner to the others [m]
  Real area;          // in the CT [m²]
  Real along[3];      // [1/m]
  Real across[3];     // [1/m]
  Real stiffness;     // PBD: from the density of the nodes, in [0, 1]
};

/// Triangles per batch, one SIMD lane each. Lanes after the last triangle repeat the first one.
constexpr int kSkinLanes = 16;

/// PBD: batch of triangles without a common node.
struct SkinBatch {
  int vertex[3][kSkinLanes];    // slots
  Real edge[2][3][kSkinLanes];  // SkinTriangle::edge1, edge2 by axis [m]
  Real area[kSkinLanes];        // [m²]
  Real stiffness[kSkinLanes];   // in [0, 1]
};

/// VBD: corners of triangles, each relative to its own node.
struct SkinCorners {
  int triangle[kSkinLanes];
  int vertex[3][kSkinLanes];    // slots, the node itself first
  Real edge[2][3][kSkinLanes];  // from that node to the others, by axis [m]
  Real along[3][kSkinLanes],
      across[3][kSkinLanes];  // SkinTriangle::along and across, in the order of `vertex` [1/m]
  Real area[kSkinLanes];      // [m²]
};

/// Skin of a partial cell: a membrane in the displacement field of the cell. Unit vectors along Langer's
/// lines and across them span its tangent plane at rest. [Cenanovic, Hansbo, Larson 2016]
struct SkinPatch {
  int cell = 0;         // slot of the cell's lowest node
  Vec3 point;           // center of the skin in the cell, in half cells from the center of the cell
  Vec3 reach1, reach2;  // integration points: point ± reach1 ± reach2 [half cells]
  Vec3 along, across;   // along the axes of the lattice
  Real area = 0;        // in the CT [m²]
};

/// VBD: corners of the cells of patches, one for each node.
struct PatchCorners {
  int patch[kSkinLanes], cell[kSkinLanes];
  int parity[kSkinLanes];  // of i of the cell
  int at[kSkinLanes];      // corner of the cell that is the node
  // SkinPatch, by axis
  Real point[3][kSkinLanes], reach1[3][kSkinLanes], reach2[3][kSkinLanes];
  Real along[3][kSkinLanes], across[3][kSkinLanes];
  Real area[kSkinLanes];
};

/// All skin triangles, sorted by cell layer. Each layer is split into batches whose triangles share no node.
/// Batch b holds triangles [batch_begin[b], batch_begin[b + 1]). Layer k holds batches [layer_begin[k],
/// layer_begin[k + 1]). PBD with colors splits each layer into four groups by the parities of i and j of the
/// cells: group 4 k + p with p = 0 to 3.
struct Skin {
  std::vector<SkinTriangle> triangles;
  std::vector<SkinPatch> patches;             // bear instead of the triangles unless empty; cells ascend
  std::vector<Vec3> lines;                    // by triangle, lattice frame; empty: SkinParams::direction
  std::vector<int> batch_begin, layer_begin;  // empty without skin
  std::vector<int> nodes;                     // corners of triangles or of patches, ascending slots
  std::vector<int> row_begin;                 // by half row, and the end: indices into nodes
};

/// Elements around a group of slots: none, full cells only, partial cells as well, or springs as well.
enum class IncidentElements : std::uint8_t { kNothing, kCells, kPartialCells, kSprings };

/// Layers [begin, end) of nodes, or of the cells above these nodes.
struct Layers {
  int begin = 0, end = 0;
};

/// Laws of solid cells by slot of the lowest node, per unit of cell_young and times the cell's volume. Empty:
/// all cells follow solid_law of the body.
struct CellLaws {
  aligned_vector<std::uint8_t> energy;  // SolidEnergy; empty: all cells have that of the body
  aligned_vector<Real> shear, bulk;  // V µ/E and V κ/E, with the moduli of the law (solid_laws.hpp) [m³]
  aligned_vector<Real> stiffening;   // b or α [1]
  // Fibers; empty without. V k1/E [m³], k2 [1] and unit direction in the lattice frame.
  aligned_vector<Real> fiber, fiber_stiffening, fiber_x, fiber_y, fiber_z;
  // Relaxation: 0 = pairs of the body, n = those of layer n − 1. Empty: all cells have those of the body.
  aligned_vector<std::uint8_t> relaxation;
};

/// Share of a cell that lies in a region (TissueLayer).
struct RegionShare {
  int cell = 0;    // number of its lowest node, i fastest (sample_index)
  int layer = 0;   // index in TissueParams::layers
  Real share = 0;  // of the cell's tissue [1]
};

/// Nodes, cells and skin of a body, with their materials.
struct Anatomy {
  Grid grid;                          // of the nodes, patient frame
  Lattice lattice;                    // storage of the nodes
  Layers owned;                       // layers of this process; all without MPI (halo.hpp)
  aligned_vector<Tissue> tissue;      // by slot
  aligned_vector<std::int16_t> hu;    // by slot, mean of the voxel block [HU]
  aligned_vector<Real> inverse_mass;  // by slot; 0 = fixed or no node [1/kg]
  // Solid, by slot of a cell's lowest node; without partial cells `cell_center` is empty.
  aligned_vector<Real> cell_young;  // Young's modulus times the filled fraction; 0 = not a whole cell [Pa]
  aligned_vector<std::uint32_t> cell_center;  // center of the filled part (CellCenter)
  CellLaws cell_laws;
  std::vector<RegionShare> regions;     // in lattice order of the cells
  aligned_vector<std::uint16_t> label;  // by slot, of nodes; empty without moduli by label
  Runs free_runs;                       // slots of free nodes
  Surroundings surroundings;            // in the CT
  Skin skin;
  int body_nodes = 0, free_nodes = 0;
};

/// Springs along the edges, and volumes of the tetrahedra.
struct Springs {
  aligned_vector<Real> root_stiffness;  // by slot; an edge has the product of both ends [√Pa; PBD: 1]
  std::array<Real, kFamilyCount> rest_length{};  // [m]
  std::array<Real, kFamilyCount> scale{};        // spring stiffness = scale · root · root [m]
  Real rest_volume = 0;                          // of a tetrahedron [m³]
  Real volume_scale = 0;                         // volume stiffness = scale · mean root² [1]
};

/// Tables of the PBD solver; empty with VBD.
struct PbdTables {
  Runs constraint_runs;                 // slots of nodes whose edges or tetrahedra contain a free node
  std::vector<SkinBatch> skin_batches;  // by batch of Skin
};

/// Tables of the VBD solver; empty with PBD. Corner c of a half row whose first corner is b uses lane
/// (c − b) % kSkinLanes of corners[lanes_begin + (c − b) / kSkinLanes].
struct VbdTables {
  std::vector<IncidentElements> incident_elements;  // solid: by group of slots, uncut
  std::vector<int> corner_begin;                    // by skin node, and the end: its corners of elements
  std::vector<int> lanes_begin;                     // by half row, and the end: indices into corners
  std::vector<SkinCorners> corners;                 // of triangles; empty with patches
  std::vector<PatchCorners> patch_corners;          // instead of `corners`
};

/// A body. A person may change some of `params` between steps; the prestress follows them. All else is
/// constant.
struct Model {
  Params params;
  std::vector<Vec3> prestress_force;  // VBD: skin force at each node of Skin in the CT, balanced by prestress
                                      // of the tissue (measure_prestress) [N]
  Anatomy anatomy;
  Springs springs;
  PbdTables pbd;
  VbdTables vbd;
};

/// Number of elements of the skin: patches, or triangles without patches.
inline std::size_t skin_element_count(const Skin& skin) {
  return skin.patches.empty() ? skin.triangles.size() : skin.patches.size();
}

/// True for a rim node: a node outside that is a corner of a partial cell (build/partial_cells.hpp). Rim
/// nodes have no springs. Those that are fixed count as outside.
inline bool is_rim(const Model& model, int slot) {
  return !is_body(model.anatomy.tissue[std::size_t(slot)]) &&
         model.anatomy.inverse_mass[std::size_t(slot)] > 0;
}
/// True if a slot has a node of the body or of its rim.
inline bool has_node(const Model& model, int slot) {
  return is_body(model.anatomy.tissue[std::size_t(slot)]) || is_rim(model, slot);
}

}  // namespace turgor::lattice
