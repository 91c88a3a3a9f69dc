#include "turgor/models/lattice/cutting/embed_point.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/models/lattice/cutting/drawn_curve.hpp"
#include "turgor/models/lattice/cutting/fragment_view.hpp"
#include "turgor/models/lattice/mechanics/skin_queries.hpp"

namespace turgor::lattice {

namespace {

/// Points up to this height above the skin of partial cells belong to its tissue [cells].
constexpr double kBeyondSkin = 0.25;

/// Tissue of one cell: a whole cell (fragment −1) or a fragment of a cut cell.
struct CellTissue {
  Int3 cell;
  int fragment = -1;
  std::array<int, 8> corner{};
};

struct PointEmbedding {
  const Model& model;
  const Cuts& cuts;
  const Fragments& fragments;
  Vec3d position;  // [cells]

  bool is_cell(Int3 cell) const {
    return contains(model.anatomy.lattice, cell) && contains(model.anatomy.lattice, cell + Int3{1, 1, 1});
  }
  CellTissue tissue(Int3 cell, int fragment) const {
    return {cell, fragment, corners_of(model, fragments, node_slot(model.anatomy.lattice, cell), fragment)};
  }
  int fragment_count(Int3 cell) const {
    const CutCell* cut = find_cell(fragments, node_slot(model.anatomy.lattice, cell));
    return cut ? cut->fragment_count : 0;
  }
  /// True if every corner is solved for.
  bool is_bearing(const CellTissue& at) const {
    return std::all_of(at.corner.begin(), at.corner.end(),
                       [&](int corner) { return has_unknowns(model, cuts, fragments, corner); });
  }
  /// True if two tissues in neighboring cells share all four corners of their common face.
  bool are_connected(const CellTissue& a, const CellTissue& b) const {
    const Int3 step = b.cell - a.cell;
    for (int c = 0; c < 8; c++) {
      const Int3 corner = cell_corner(c), other = corner - step;
      if (other.x < 0 || other.y < 0 || other.z < 0 || other.x > 1 || other.y > 1 || other.z > 1) continue;
      if (a.corner[std::size_t(c)] != b.corner[std::size_t(corner_of(other))]) return false;
    }
    return true;
  }
  /// Distance of the point outside a cell, the largest of the three axes [cells].
  double distance(Int3 cell) const {
    double most = 0;
    for (int axis = 0; axis < 3; axis++) {
      const double at = position[axis] - cell[axis];
      most = std::max({most, -at, at - 1});
    }
    return most;
  }

  /// Level set of the nodes at the point, positive in the body [HU].
  double level(Int3 cell) const {
    const std::array<double, 8> weight = trilinear(position - Vec3d(cell));
    const CellTissue whole = tissue(cell, -1);
    double sum = 0;
    for (std::size_t c = 0; c < 8; c++) sum += weight[c] * double(node_level(model, cuts, whole.corner[c]));
    return sum;
  }

  /// True if the point is in tissue that a cell shows, or just above its skin.
  bool is_tissue_in(Int3 cell) const {
    constexpr double kSkinTolerance = 150;  // [HU], about a tenth of the step from tissue to air
    const Skin& skin = model.anatomy.skin;
    const int patch = patch_of_cell(skin, node_slot(model.anatomy.lattice, cell));
    if (patch < 0) return level(cell) >= -kSkinTolerance;
    // height above the skin in a partial cell
    const SkinPatch& p = skin.patches[std::size_t(patch)];
    const Vec3d above = position - Vec3d(cell) - (Vec3d(p.point) + Vec3d{1, 1, 1}) * 0.5,
                normal = cross(Vec3d(p.along), Vec3d(p.across));
    return dot(hadamard(above, Vec3d(model.anatomy.lattice.spacing)), normal) <=
           kBeyondSkin * smallest_spacing(model.anatomy.lattice);
  }
  /// Cell that contains the point. Just above the skin of partial cells, the nearest one with skin.
  Int3 cell_of_point() const {
    Int3 own;
    for (int axis = 0; axis < 3; axis++)
      own[axis] = std::min(int(std::floor(position[axis])), model.anatomy.lattice.size[axis] - 2);
    const Skin& skin = model.anatomy.skin;
    if (skin.patches.empty() || !is_cell(own) || is_tissue_in(own)) return own;
    Int3 best = own;
    double least = kBeyondSkin;
    for (int n = 0; n < 27; n++) {
      const Int3 cell = own + Int3{n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1};
      if (!is_cell(cell) || distance(cell) >= least) continue;
      if (patch_of_cell(skin, node_slot(model.anatomy.lattice, cell)) < 0 || !is_tissue_in(cell)) continue;
      best = cell, least = distance(cell);
    }
    return best;
  }

  /// Tissue of the cell that contains the point; the owner of a ghost fragment. Empty in air.
  std::optional<CellTissue> start() const {
    const Int3 cell = cell_of_point();
    const double beyond = model.anatomy.skin.patches.empty() ? 1e-6 : kBeyondSkin;
    if (!is_cell(cell) || distance(cell) > beyond || !is_tissue_in(cell)) return {};
    const int slot = node_slot(model.anatomy.lattice, cell);
    if (const CutCell* cut = find_cell(fragments, slot)) {
      const int fragment = fragment_at(fragments, cuts, *cut, Vec3(position - Vec3d(cell)));
      if (fragment < 0) return {};
      if (fragment < cut->fragment_count) return tissue(cell, fragment);
      const GhostFragment& ghost =
          fragments.ghosts[std::size_t(cut->first_ghost + fragment - cut->fragment_count)];
      const int home = fragments.cells[std::size_t(ghost.cell)].slot;
      return tissue(slot_node(model.anatomy.lattice, home), ghost.fragment);
    }
    const CellTissue whole = tissue(cell, -1);
    const bool any = std::any_of(whole.corner.begin(), whole.corner.end(),
                                 [&](int corner) { return is_solid(model, cuts, corner); });
    return any ? std::optional(whole) : std::nullopt;
  }

  /// Appends the tissues of the neighbor cells that are connected to one.
  void add_neighbors(const CellTissue& at, std::vector<CellTissue>& found) const {
    for (int n = 0; n < 6; n++) {
      Int3 cell = at.cell;
      cell[n / 2] += n % 2 ? 1 : -1;
      if (!is_cell(cell)) continue;
      const int count = fragment_count(cell);
      for (int fragment = count > 0 ? 0 : -1; fragment < count; fragment++) {
        const CellTissue next = tissue(cell, fragment);
        const bool known = std::any_of(found.begin(), found.end(), [&](const CellTissue& other) {
          return other.cell == cell && other.fragment == fragment;
        });
        if (!known && are_connected(at, next)) found.push_back(next);
      }
    }
  }

  /// Nearest bearing tissue within `reach` steps from cell to cell; the first one of equals.
  std::optional<CellTissue> nearest(const CellTissue& from, int reach) const {
    std::vector<CellTissue> found{from};
    std::size_t begin = 0;
    for (int step = 0; step < reach; step++) {
      const std::size_t end = found.size();
      for (; begin < end; begin++) add_neighbors(CellTissue(found[begin]), found);
    }
    std::optional<CellTissue> best;
    for (const CellTissue& at : found)
      if (is_bearing(at) && (!best || distance(at.cell) < distance(best->cell))) best = at;
    return best;
  }
};

}  // namespace

std::optional<EmbeddedPoint> embed_point(const Model& model, const Cuts& cuts, const Fragments& fragments,
                                         Vec3d position) {
  constexpr int kReach = 3;        // steps between neighboring cells
  constexpr double kFarthest = 2;  // extrapolation [cells]
  const Vec3d spacing(model.anatomy.lattice.spacing);
  TURGOR_CHECK(is_finite(position), "a point has finite coordinates");
  Vec3d at{position.x / spacing.x, position.y / spacing.y, position.z / spacing.z};
  at.z -= model.anatomy.lattice.first;
  for (int axis = 0; axis < 3; axis++)
    if (!(std::abs(at[axis]) < 1e6)) return {};
  const PointEmbedding embedding{model, cuts, fragments, at};
  // connected tissue
  const std::optional<CellTissue> start = embedding.start();
  if (!start) return {};
  const std::optional<CellTissue> tissue = embedding.nearest(*start, kReach);
  if (!tissue || embedding.distance(tissue->cell) > kFarthest) return {};
  // trilinear weights
  EmbeddedPoint point{.cell = node_slot(model.anatomy.lattice, tissue->cell), .corner = tissue->corner};
  point.weight = trilinear(Vec3(at - Vec3d(tissue->cell)));
  return point;
}

}  // namespace turgor::lattice
