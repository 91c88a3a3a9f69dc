#include "turgor/models/lattice/mechanics/skin_queries.hpp"

#include <algorithm>

#include "turgor/core/assert.hpp"
#include "turgor/models/lattice/mechanics/cells.hpp"

namespace turgor::lattice {

Int3 cell_of(const Lattice& l, Int3 triangle) {
  Int3 low = l.size - Int3{2, 2, 2};
  for (int c = 0; c < 3; c++) low = min(low, slot_node(l, triangle[c]));
  return low;
}

std::span<const SkinTriangle> skin_of_cells(const Model& model, Layers cells) {
  const Skin& skin = model.anatomy.skin;
  if (skin.triangles.empty()) return {};
  const auto layers = std::size_t(model.anatomy.lattice.size.z - 1),
             groups = (skin.layer_begin.size() - 1) / layers;
  TURGOR_CHECK(groups > 0 && (skin.layer_begin.size() - 1) % layers == 0,
               "every layer has the same number of groups");
  const auto first_of = [&](int layer) {
    return std::size_t(
        skin.batch_begin[std::size_t(skin.layer_begin[std::min(std::size_t(layer), layers) * groups])]);
  };
  const std::size_t first = first_of(cells.begin);
  return std::span(skin.triangles).subspan(first, first_of(cells.end) - first);
}

std::span<const SkinPatch> patches_of_cells(const Model& model, Layers cells) {
  const std::vector<SkinPatch>& patches = model.anatomy.skin.patches;
  const auto first_of = [&](int layer) {
    return std::partition_point(patches.begin(), patches.end(), [&](const SkinPatch& p) {
      return p.cell < row_slot(model.anatomy.lattice, -1, layer);
    });
  };
  return {first_of(cells.begin), first_of(cells.end)};
}

int patch_of_cell(const Skin& skin, int slot) {
  const auto at = std::lower_bound(skin.patches.begin(), skin.patches.end(), slot,
                                   [](const SkinPatch& p, int s) { return p.cell < s; });
  return at != skin.patches.end() && at->cell == slot ? int(at - skin.patches.begin()) : -1;
}

Edge edge_between(const Lattice& lattice, int a, int b) {
  const Int3 from = slot_node(lattice, a), to = slot_node(lattice, b), offset = to - from;
  if (const int family = family_of(offset); family >= 0) return {a, family};
  return {b, family_of(-offset)};
}

void cut_skin(const Model& model, Cuts& cuts) {
  const Skin& skin = model.anatomy.skin;
  for (std::size_t p = 0; p < skin.patches.size(); p++)
    if (cuts.row_cut[std::size_t(skin.patches[p].cell / row_stride(model.anatomy.lattice))])
      cuts.skin_cut[p] = !is_whole_cell(model, cuts, slot_node(model.anatomy.lattice, skin.patches[p].cell));
  for (std::size_t t = 0; t < skin.triangles.size() && skin.patches.empty(); t++) {
    const Int3 v = model.anatomy.skin.triangles[t].vertex;
    if (!cuts.row_cut[std::size_t(v.x / row_stride(model.anatomy.lattice))]) continue;
    for (int c = 0; c < 3; c++) {
      const Edge edge = edge_between(model.anatomy.lattice, v[c], v[(c + 1) % 3]);
      if (cuts.cut[std::size_t(edge.slot)] >> edge.family & 1) cuts.skin_cut[t] = 1;
      TURGOR_CHECK(edge.family >= 0, "the corners of a skin triangle are neighbors");
    }
  }
}

}  // namespace turgor::lattice
