#include "turgor/models/lattice/build/skin_lanes.hpp"

#include <algorithm>
#include <tuple>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/models/lattice/mechanics/skin_forces.hpp"

namespace turgor::lattice {

namespace {

/// Corner of a triangle, or of the cell of a patch.
struct Corner {
  int slot, triangle, corner;
};

std::vector<Corner> corners_of_triangles(const Skin& skin) {
  std::vector<Corner> corners;
  for (int t = 0; t < int(skin.triangles.size()); t++)
    for (int c = 0; c < 3; c++) corners.push_back({skin.triangles[std::size_t(t)].vertex[c], t, c});
  return corners;
}

std::vector<Corner> corners_of_patches(const Model& model) {
  const Skin& skin = model.anatomy.skin;
  const CellOffsets offset(model.anatomy.lattice);
  std::vector<Corner> corners;
  for (int p = 0; p < int(skin.patches.size()); p++) {
    const int slot = skin.patches[std::size_t(p)].cell, parity = slot_node(model.anatomy.lattice, slot).x & 1;
    for (int c = 0; c < kCellCorners; c++) corners.push_back({slot + offset.of[parity][c], p, c});
  }
  return corners;
}

/// Stores the corner of a patch in lane `i`.
void set_lane(const Lattice& lattice, const Skin& skin, const Corner& corner, int i, PatchCorners& lanes) {
  const SkinPatch& p = skin.patches[std::size_t(corner.triangle)];
  lanes.patch[i] = corner.triangle, lanes.cell[i] = p.cell, lanes.at[i] = corner.corner;
  lanes.parity[i] = slot_node(lattice, p.cell).x & 1, lanes.area[i] = p.area;
  for (int axis = 0; axis < 3; axis++)
    lanes.point[axis][i] = p.point[axis], lanes.reach1[axis][i] = p.reach1[axis],
    lanes.reach2[axis][i] = p.reach2[axis], lanes.along[axis][i] = p.along[axis],
    lanes.across[axis][i] = p.across[axis];
}

/// Stores a corner in lane `i`.
void set_lane(const Lattice&, const Skin& skin, const Corner& corner, int i, SkinCorners& lanes) {
  TURGOR_CHECK(is_index(corner.triangle, skin.triangles.size()) && corner.corner >= 0 && corner.corner < 3,
               "a lane is the corner of a triangle");
  const SkinTriangle& t = skin.triangles[std::size_t(corner.triangle)];
  const Vec3 rest[3] = {{}, t.edge1, t.edge2};
  lanes.triangle[i] = corner.triangle, lanes.area[i] = t.area;
  for (int q = 0; q < 3; q++) {
    const int vertex = (corner.corner + q) % 3;
    lanes.vertex[q][i] = t.vertex[vertex];
    lanes.along[q][i] = t.along[vertex], lanes.across[q][i] = t.across[vertex];
    const Vec3 edge = rest[vertex] - rest[corner.corner];
    for (int axis = 0; axis < 3 && q > 0; axis++) lanes.edge[q - 1][axis][i] = edge[axis];
  }
}

/// Packs the corners of each half row into lanes.
template <class Lanes>
void lay_out_corners(const Lattice& lattice, const std::vector<Corner>& corners, const Skin& skin,
                     std::vector<Lanes>& out, VbdTables& vbd) {
  // ranges by node
  for (std::size_t c = 0; c < corners.size(); c++)
    if (c == 0 || corners[c].slot != corners[c - 1].slot) vbd.corner_begin.push_back(int(c));
  vbd.corner_begin.push_back(int(corners.size()));
  TURGOR_CHECK(is_csr(vbd.corner_begin, corners.size()) && is_csr(skin.row_begin, skin.nodes.size()),
               "the offsets of rows and nodes cover all corners");
  const auto begin_of = [&](std::size_t row) {
    return std::size_t(vbd.corner_begin[std::size_t(skin.row_begin[row])]);
  };
  // number of batches
  std::size_t count = 0;
  for (std::size_t row = 0; row + 1 < skin.row_begin.size(); row++)
    count += (begin_of(row + 1) - begin_of(row) + kSkinLanes - 1) / kSkinLanes;
  out.reserve(count);
  // batches by half row
  vbd.lanes_begin = {0};
  for (std::size_t row = 0; row + 1 < skin.row_begin.size(); row++) {
    const std::size_t begin = begin_of(row), end = begin_of(row + 1);
    for (std::size_t first = begin; first < end; first += kSkinLanes) {
      Lanes& lanes = out.emplace_back();
      for (int i = 0; i < kSkinLanes; i++)
        set_lane(lattice, skin, corners[first + std::size_t(i) < end ? first + std::size_t(i) : first], i,
                 lanes);
    }
    vbd.lanes_begin.push_back(int(out.size()));
  }
}

/// Packs the triangles of each batch into lanes.
void lay_out_batches(const Skin& skin, PbdTables& pbd) {
  for (std::size_t b = 0; b + 1 < skin.batch_begin.size(); b++) {
    SkinBatch& batch = pbd.skin_batches.emplace_back();
    const int begin = skin.batch_begin[b], end = skin.batch_begin[b + 1];
    for (int i = 0; i < kSkinLanes; i++) {
      const SkinTriangle& t = skin.triangles[std::size_t(begin + i < end ? begin + i : begin)];
      batch.area[i] = t.area, batch.stiffness[i] = t.stiffness;
      for (int axis = 0; axis < 3; axis++) {
        batch.vertex[axis][i] = t.vertex[axis];
        batch.edge[0][axis][i] = t.edge1[axis], batch.edge[1][axis][i] = t.edge2[axis];
      }
    }
  }
}

/// Sorts corners by slot, and lists the nodes of the skin.
std::vector<Corner> collect_corners(const Lattice& lattice, std::vector<Corner> entries, Skin& skin) {
  std::sort(entries.begin(), entries.end(), [](const Corner& a, const Corner& b) {
    return std::tie(a.slot, a.triangle) < std::tie(b.slot, b.triangle);
  });
  // nodes, and their ranges by half row
  skin.row_begin.assign(std::size_t(slot_count(lattice) / lattice.half + 1), 0);
  for (const Corner& e : entries) {
    if (skin.nodes.empty() || skin.nodes.back() != e.slot) {
      skin.nodes.push_back(e.slot);
      skin.row_begin[std::size_t(e.slot / lattice.half + 1)]++;
    }
  }
  for (std::size_t r = 1; r < skin.row_begin.size(); r++) skin.row_begin[r] += skin.row_begin[r - 1];
  TURGOR_CHECK(is_sorted_unique(skin.nodes), "the nodes of the skin ascend");
  return entries;
}

}  // namespace

void lay_out_skin(Model& model) {
  Skin& skin = model.anatomy.skin;
  const Lattice& lattice = model.anatomy.lattice;
  const bool in_cells = !skin.patches.empty();
  const std::vector<Corner> corners =
      collect_corners(lattice, in_cells ? corners_of_patches(model) : corners_of_triangles(skin), skin);
  if (model.params.solver.method == Method::kPbd) return lay_out_batches(skin, model.pbd);
  if (in_cells)
    lay_out_corners(lattice, corners, skin, model.vbd.patch_corners, model.vbd);
  else
    lay_out_corners(lattice, corners, skin, model.vbd.corners, model.vbd);
  TURGOR_CHECK(is_csr(model.vbd.lanes_begin, model.vbd.corners.size() + model.vbd.patch_corners.size()),
               "the half rows cover all lanes");
}

}  // namespace turgor::lattice
