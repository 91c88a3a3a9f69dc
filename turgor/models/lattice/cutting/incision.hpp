// Incisions. A blade follows a curve on the skin and sweeps a surface. Every edge of the lattice and of the
// fine lattice that crosses this surface is cut. The measures of the open wound are also declared in this
// file.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "turgor/core/exec.hpp"
#include "turgor/core/result.hpp"
#include "turgor/models/lattice/model/state.hpp"

namespace turgor::lattice {

struct HaloExchange;

/// Ellipse of skin with pointed ends, bounded by two arcs of circles, and the tissue below it. A disc if its
/// length is its width. It is cut out along a closed path and along a floor.
struct Excision {
  Vec3d center;                  // on or near the skin, patient frame [m]
  Vec3d direction{0, 0, 1};      // of its length, patient frame; may leave the skin
  double angle = 0;              // turns the direction counter-clockwise, seen from outside [degrees]
  double length = 0, width = 0;  // [m]
};

/// Skin that is freed from the tissue below it on both sides of a cut, or around an excision (undermine.hpp).
struct Undermining {
  double width = 0;  // from the cut on; 0 = none [m]
  double depth = 0;  // below the skin [m]
};

struct Incision {
  std::string name;
  Vec3d from, to;  // on or near the skin, patient frame [m]
  // control points of a smooth curve that replaces from and to; equal first and last points close it
  std::vector<Vec3d> path;
  double depth = 0.01;  // below the skin [m]
  double tilt = 0;   // angle of the blade from upright [degrees]; positive if its edge lies to the right of
                     // the cutting direction, seen from outside
  double start = 0;  // time at which the blade starts [s]
  double duration = 0;  // time from the start of the path to its end; 0 = instantaneous [s]
  // 0 = edges are cut; otherwise width of the region whose nodes are removed [Jeon et al. 2025] [m]
  double width = 0;
  bool through_bone = false;  // false: the blade stops above bone
  // set: `path` is the outline of a piece, which is cut free at `depth` and leaves the body (excision.hpp)
  std::optional<Excision> excision;
  Undermining undermine;
};

/// Pending cut of a lattice edge. It is cut when the blade reaches the arc length `along`.
struct PendingEdgeCut {
  int slot = 0;
  std::uint8_t family = 0;
  Real along = 0;  // arc length on the path [m]
};

/// Pending cut of a sample line through a cell (cut_fraction.hpp).
struct PendingSampleCut {
  int slot = 0;  // of the cell's lowest node
  std::uint8_t axis = 0, line = 0;
  Real along = 0;  // arc length on the path [m]
};

/// Path of a blade on the skin, fixed when the blade starts.
struct BladePath {
  // on the skin of the nodes, for excisions from partial cells on that of the patches; about half a cell
  // apart, lattice frame [m]
  std::vector<Vec3d> points;
  std::vector<Vec3d> inward;    // per point: unit vector into the body, orthogonal to the path
  double depth = 0, width = 0;  // [m]
  // per point, below the skin of the nodes: `depth`, less above bone (bone_stop.hpp), and less by the height
  // of the CT's skin for excisions (ct_skin.hpp) [m]
  std::vector<double> depths;

  // All pending cuts, found when the blade is laid on the skin. The opening wound deforms the tissue ahead of
  // the blade, and a later search in the deformed tissue would leave bridges and islands.
  std::vector<PendingEdgeCut> edges;
  std::vector<CutEdge> fine_edges;
  std::vector<PendingSampleCut> lines;
  bool is_excision = false;  // the points are the outline of an excised piece; the last is the first
};

/// Blade that was laid earlier in the same body. A later blade whose end is drawn on its curve joins its cut.
struct LaidBlade {
  const Incision& drawn;
  const BladePath& path;
};

/// Lays a path on the skin and finds its pending cuts. Errors: two equal points, a body without skin, no skin
/// near the path, or skin without a normal. `halo` as in Inputs.
Result<BladePath> lay_blade(const Model& model, const State& state, const Incision& incision,
                            const HaloExchange* halo = nullptr, std::span<const LaidBlade> laid = {});
/// Cuts all pending edges between two fractions of the path's length. Returns the number of lattice edges
/// cut. Downloads only the node positions that new virtual nodes need.
int cut_edges(const Model& model, State& state, const BladePath& path, double begin, double end, int incision,
              const DownloadNodes& download = {});
/// Static incision [Jeon et al. 2025]: removes nodes within `width`/2 of the blade. Returns their number.
int cut_region(const Model& model, State& state, const BladePath& path);

double path_length(const BladePath& path);
/// Position on a path: segment index and fraction in the segment, 0 to 1.
struct PathPosition {
  std::size_t segment = 0;
  double fraction = 0;
};
PathPosition position_along(const BladePath& path, double along);
/// Unit vectors at point n of the path: tangent, and direction to the right seen from outside.
Vec3d tangent_at(const BladePath& path, std::size_t n);
Vec3d across_at(const BladePath& path, std::size_t n);
/// Mean direction into the body along the path.
Vec3d mean_inward(const BladePath& path);

struct GapePoint {
  double along = 0;  // arc length along the cut [m]
  double gape = 0;   // [m]
};
struct Wound {
  double length = 0;                   // of the cut skin [m]
  double gape_max = 0, gape_mean = 0;  // opening across the cut [m]
  double opening_area = 0;             // [m²]
  double edge_displacement = 0;        // largest displacement of a lip from its position in the CT [m]
  std::vector<GapePoint> profile;
};

struct BodySurface;
/// Measures the wound between the lips of the drawn surface. After cut_region, the lips are the skin nodes
/// next to the removed region.
Wound measure_wound(const Model& model, const State& state, const BodySurface& surface, const BladePath& path,
                    int incision);
/// The same, with a surface built for this call.
Wound measure_wound(const Model& model, const State& state, const BladePath& path, int incision);
/// Nodes whose displacements determine the wound measures, ascending. They depend only on the cuts.
std::vector<int> wound_support_nodes(const Model& model, const Cuts& cuts,
                                     std::span<const VirtualNodeDisplacement> virtual_u,
                                     const BodySurface& surface, const BladePath& path, int incision);

}  // namespace turgor::lattice
