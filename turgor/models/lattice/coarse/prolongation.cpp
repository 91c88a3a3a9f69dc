#include "turgor/models/lattice/coarse/prolongation.hpp"

#include "turgor/core/assert.hpp"
#include "turgor/core/exec.hpp"

namespace turgor::lattice {

namespace {

/// Adds the forces of a run to the corners of its block.
void add_row(const CoarseBlock& block, const RunWeights& row, const ProlongationRun& run, LayerForces forces,
             Vec3d* sums) {
  TURGOR_CHECK(run.count > 0, "a run has at least one node");
  Vec3 all, far;
  for (int n = 0; n < run.count; n++) {
    const Vec3 f = forces[run.slot + n];
    all += f, far += f * row.coordinate(n);
  }
  const Vec3 near = all - far;
  for (std::size_t c = 0; c < 4; c++) {
    sums[block.corner[2 * c]] += Vec3d(near * row.side[c]);
    sums[block.corner[2 * c + 1]] += Vec3d(far * row.side[c]);
  }
}

void move_row(const CoarseBlock& block, const RunWeights& row, const ProlongationRun& run,
              std::span<const Vec3> corners, VecField& u) {
  Vec3 near, far;
  for (std::size_t c = 0; c < 4; c++) {
    near += corners[std::size_t(block.corner[2 * c])] * row.side[c];
    far += corners[std::size_t(block.corner[2 * c + 1])] * row.side[c];
  }
  const Vec3 slope = far - near;
  Real *x = u.x.data() + run.slot, *y = u.y.data() + run.slot, *z = u.z.data() + run.slot;
  for (int n = 0; n < run.count; n++) {
    const Vec3 displacement = near + slope * row.coordinate(n);
    x[n] += displacement.x, y[n] += displacement.y, z[n] += displacement.z;
  }
}

/// Calls of_block(block, position, virtual_node) or of_row(row, virtual_node) for the interpolated virtual
/// nodes.
template <class OfBlock, class OfRow>
void for_virtual_nodes(const Model& model, const State& state, const CoarseSpace& space,
                       const OfBlock& of_block, const OfRow& of_row) {
  const int slots = slot_count(model.anatomy.lattice);
  for (const ElementNode& virtual_node : state.cut_elements.virtual_nodes) {
    const int source = space.interpolation[std::size_t(virtual_node.corner)];
    if (source >= 0) {
      const CoarseBlock& block = space.blocks[std::size_t(source)];
      of_block(block, position_in_block(block, slot_node(model.anatomy.lattice, virtual_node.slot)),
               virtual_node.corner - slots);
    } else if (source != CoarseSpace::kFixed) {
      of_row(-2 - source, virtual_node.corner - slots);
    }
  }
}

}  // namespace

std::vector<ProlongationRun> find_prolongation_runs(const Lattice& l, std::span<const int> interpolation) {
  TURGOR_CHECK(interpolation.size() >= std::size_t(slot_count(l)), "every node has an interpolation");
  std::vector<ProlongationRun> runs;
  for (int k = 0; k < l.size.z; k++)
    for (int j = 0; j < l.size.y; j++)
      for (int parity = 0; parity < 2; parity++) {
        const int first = row_slot(l, j, k) + parity * l.half;
        for (int n = 0; n < half_count(l, parity); n++) {
          const int source = interpolation[std::size_t(first + n)];
          if (source == CoarseSpace::kFixed) continue;
          // extend the last run, or begin one
          const bool extends = n > 0 && source >= 0 && source == interpolation[std::size_t(first + n - 1)];
          if (extends)
            runs.back().count++;
          else
            runs.push_back(
                {.first = {2 * n + parity, j, k}, .slot = first + n, .count = 1, .source = source});
        }
      }
  return runs;
}

std::vector<RunWeights> weights_of_runs(const CoarseSpace& space) {
  std::vector<RunWeights> weights(space.runs.size());
  for (std::size_t r = 0; r < weights.size(); r++) {
    const ProlongationRun& run = space.runs[r];
    if (run.source < 0) continue;
    const CoarseBlock& block = space.blocks[std::size_t(run.source)];
    const Vec3 at = position_in_block(block, run.first);
    weights[r] = {.side = {(1 - at.y) * (1 - at.z), at.y * (1 - at.z), (1 - at.y) * at.z, at.y * at.z},
                  .from = Real(run.first.x - block.low.x) / Real(block.size),
                  .per_step = 2 / Real(block.size)};
  }
  return weights;
}

void restrict_layer(const CoarseSpace& space, int k, LayerForces forces, std::span<Vec3d> sums) {
  TURGOR_CHECK(sums.size() + 1 == space.row_begin.size(), "every row of the space has a sum");
  const RunWeights* row = space.weights_of(k);
  for (const ProlongationRun& run : space.runs_of(k)) {
    if (run.source >= 0)
      add_row(space.blocks[std::size_t(run.source)], *row, run, forces, sums.data());
    else
      sums[std::size_t(-2 - run.source)] += Vec3d(forces[run.slot]);
    row++;
  }
}

void restrict_virtual_nodes(const Model& model, const State& state, std::span<Vec3d> sums) {
  const auto force = [&](int c) {
    const VirtualNodeDisplacement& f = state.workspace.residual.virtual_nodes[std::size_t(c)];
    return Vec3d{f.x, f.y, f.z};
  };
  for_virtual_nodes(
      model, state, *state.workspace.coarse,
      [&](const CoarseBlock& block, Vec3 position, int virtual_node) {
        for (int c = 0; c < 8; c++)
          sums[std::size_t(block.corner[std::size_t(c)])] +=
              force(virtual_node) * double(corner_weight(position, c));
      },
      [&](int row, int virtual_node) { sums[std::size_t(row)] += force(virtual_node); });
}

void prolongate(const Exec& exec, const Model& model, State& state, std::span<const Vec3> corners) {
  const CoarseSpace& space = *state.workspace.coarse;
  TURGOR_CHECK(corners.size() + 1 == space.row_begin.size(), "every row of the space has a displacement");
  parallel_for(exec, std::size_t(model.anatomy.lattice.size.z), [&](std::size_t k) {
    const RunWeights* row = space.weights_of(int(k));
    for (const ProlongationRun& run : space.runs_of(int(k))) {
      if (run.source >= 0)
        move_row(space.blocks[std::size_t(run.source)], *row, run, corners, state.motion.u);
      else
        state.motion.u.set(std::size_t(run.slot),
                           state.motion.u[std::size_t(run.slot)] + corners[std::size_t(-2 - run.source)]);
      row++;
    }
  });
  const auto at_row = [&](int row) { return corners[std::size_t(row)]; };
  const auto move = [&](int c, Vec3 by) { state.motion.virtual_u[std::size_t(c)].move(by); };
  for_virtual_nodes(
      model, state, space,
      [&](const CoarseBlock& block, Vec3 position, int virtual_node) {
        move(virtual_node, interpolate(block, position, at_row));
      },
      [&](int row, int virtual_node) { move(virtual_node, at_row(row)); });
}

}  // namespace turgor::lattice
