#include "turgor/contact/lattice_points.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "turgor/core/assert.hpp"
#include "turgor/models/lattice/mechanics/cells.hpp"

namespace turgor::contact {

namespace {

using lattice::EmbeddedPoint;
using lattice::SurfaceSample;

constexpr double kFarthest = 0.5;  // extrapolation from a cell [cells]

/// Distance of a point outside a cell, the largest of the three axes [cells].
double distance_outside(Int3 cell, Vec3d at) {
  double outside = 0;
  for (int axis = 0; axis < 3; axis++)
    outside = std::max({outside, cell[axis] - at[axis], at[axis] - cell[axis] - 1});
  return outside;
}

struct SampleEmbedding {
  const lattice::Model& model;
  const lattice::Cuts& cuts;
  const lattice::BodySurface& surface;
  std::vector<int> vertices;  // of the surface near cuts, ordered by their nodes

  int slot_of(int vertex) const { return surface.slot[std::size_t(vertex)]; }
  Vec3d in_cells(Vec3d rest) const {
    const Lattice& l = model.anatomy.lattice;
    return {rest.x / l.spacing.x, rest.y / l.spacing.y, rest.z / l.spacing.z - l.first};
  }

  EmbeddedPoint point_in(Int3 cell, const std::array<int, 8>& corner, Vec3d at) const {
    return {.cell = node_slot(model.anatomy.lattice, cell),
            .corner = corner,
            .weight = lattice::trilinear(Vec3(at - Vec3d(cell)))};
  }

  /// Whole cell that contains a position, or the nearest within half a cell. Nothing if all of these are cut
  /// or empty.
  std::optional<EmbeddedPoint> in_whole_cell(Vec3d at) const {
    const Lattice& l = model.anatomy.lattice;
    std::optional<Int3> nearest;
    double least = kFarthest;
    for (int n = 0; n < 27; n++) {
      const Int3 cell{int(std::floor(at.x)) + n % 3 - 1, int(std::floor(at.y)) + n / 3 % 3 - 1,
                      int(std::floor(at.z)) + n / 9 - 1};
      const double outside = distance_outside(cell, at);
      if (outside >= least || !contains(l, cell) || !contains(l, cell + Int3{1, 1, 1}) ||
          !is_whole_cell(model, cuts, cell))
        continue;
      nearest = cell, least = outside;
    }
    if (!nearest) return {};
    return point_in(*nearest, corners_of(model, *surface.fragments, node_slot(l, *nearest), -1), at);
  }

  /// Fragment of the nearest vertex that has the node of the sample.
  std::optional<EmbeddedPoint> in_fragment(const SurfaceSample& sample, Vec3d at) const {
    // nearest vertex whose fragment bears
    const auto first = std::lower_bound(vertices.begin(), vertices.end(), sample.slot,
                                        [this](int v, int slot) { return slot_of(v) < slot; });
    std::optional<EmbeddedPoint> nearest;
    double least = 0;
    for (auto v = first; v != vertices.end() && slot_of(*v) == sample.slot; ++v) {
      const lattice::EmbeddingCell embedding = surface.embedding[std::size_t(*v)];
      const Int3 cell = slot_node(model.anatomy.lattice, embedding.cell);
      const double apart = norm(Vec3d(surface.rest[std::size_t(*v)]) - sample.rest);
      if ((nearest && apart >= least) || distance_outside(cell, at) > kFarthest) continue;
      const std::array<int, 8> corner =
          corners_of(model, *surface.fragments, embedding.cell, embedding.fragment);
      const bool bears = std::all_of(corner.begin(), corner.end(), [this](int c) {
        return has_unknowns(model, cuts, *surface.fragments, c);
      });
      if (bears) nearest = point_in(cell, corner, at), least = apart;
    }
    return nearest;
  }

  static EmbeddedPoint on_nodes(const SurfaceSample& sample) {
    EmbeddedPoint point;
    point.cell = sample.slot, point.corner.fill(sample.slot), point.weight[0] = 1;
    if (sample.other >= 0) point.corner[1] = sample.other, point.weight[0] = point.weight[1] = Real(0.5);
    return point;
  }

  bool is_near_cut(int cell) const { return find_cell(*surface.fragments, cell) != nullptr; }

  /// True if no edge of the cells around a cell is cut. `row_cut` marks rows next to a cut edge.
  bool is_far_from_cuts(Int3 cell) const {
    const Lattice& l = model.anatomy.lattice;
    if (!contains(l, cell)) return false;
    for (int n = 0; n < 9; n++)
      if (const Int3 row = cell + Int3{0, n % 3 - 1, n / 3 - 1};
          contains(l, row) && cuts.row_cut[std::size_t(node_slot(l, row) / row_stride(l))])
        return false;
    return !is_near_cut(node_slot(l, cell));
  }

  /// Adds the point of a sample. `known`: its point far from cuts, or null.
  void add(const SurfaceSample& sample, const EmbeddedPoint* known, SamplePoints& points) const {
    const Vec3d at = in_cells(sample.rest);
    const Int3 cell{int(std::floor(at.x)), int(std::floor(at.y)), int(std::floor(at.z))};
    // away from cuts
    const bool is_far = !sample.wall && is_far_from_cuts(cell);
    if (is_far && known && !is_near_cut(known->cell)) {
      points.at.push_back(*known), points.is_far.push_back(1);
      return;
    }
    const bool near_cut = sample.wall || (contains(model.anatomy.lattice, cell) &&
                                          is_near_cut(node_slot(model.anatomy.lattice, cell)));
    std::optional<EmbeddedPoint> point = near_cut ? in_fragment(sample, at) : in_whole_cell(at);
    const bool stays = is_far && point && !is_near_cut(point->cell);
    if (!point && near_cut && !sample.wall) point = in_whole_cell(at);
    points.at.push_back(point ? *point : on_nodes(sample)), points.is_far.push_back(stays);
  }
};

}  // namespace

SamplePoints embed_samples(const lattice::Model& model, const lattice::Cuts& cuts,
                           const lattice::BodySurface& surface, std::span<const SurfaceSample> samples,
                           std::span<const EmbeddedPoint* const> known) {
  TURGOR_ASSERT(surface.fragments != nullptr, "samples are those of a surface");
  TURGOR_ASSERT(known.empty() || known.size() == samples.size(), "every sample has a known point or none");
  // vertices near cuts
  SampleEmbedding embedding{model, cuts, surface, {}};
  std::vector<int>& vertices = embedding.vertices;
  for (int v = 0; v < int(surface.rest.size()); v++)
    if (find_cell(*surface.fragments, surface.embedding[std::size_t(v)].cell) != nullptr)
      vertices.push_back(v);
  std::stable_sort(vertices.begin(), vertices.end(),
                   [&](int a, int b) { return embedding.slot_of(a) < embedding.slot_of(b); });
  // points
  SamplePoints points;
  points.at.reserve(samples.size()), points.is_far.reserve(samples.size());
  for (std::size_t p = 0; p < samples.size(); p++)
    embedding.add(samples[p], known.empty() ? nullptr : known[p], points);
  return points;
}

}  // namespace turgor::contact
