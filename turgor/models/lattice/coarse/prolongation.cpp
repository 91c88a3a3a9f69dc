#include "turgor/models/lattice/coarse/prolongation.hpp"

#include "turgor/core/exec.hpp"

namespace turgor::lattice {

namespace {

/// Half a row in a block: what is trilinear there is linear in the place along x.
struct RowInBlock {
  const CoarseBlock& block;
  Real from, per_step;       // place of the first node, unclamped, and from node to node
  std::array<Real, 4> side;  // weight of the corners 2 n and 2 n + 1 together

  RowInBlock(const CoarseSpace& space, const FollowRun& run)
      : block(space.blocks[std::size_t(run.to)]),
        from(Real(run.first.x - block.low.x) / Real(block.size)),
        per_step(2 / Real(block.size)) {
    const Vec3 at = place_in_block(block, run.first);
    side = {(1 - at.y) * (1 - at.z), at.y * (1 - at.z), (1 - at.y) * at.z, at.y * at.z};
  }
  Real place(int n) const { return std::min(Real(1), std::max(Real(0), from + Real(n) * per_step)); }
};

/// What forces do to the corners of their block.
void add_row(const RowInBlock& row, const FollowRun& run, LayerForces forces, Vec3d* sums) {
  Vec3 all, far;
  for (int n = 0; n < run.count; n++) {
    const Vec3 f = forces[run.slot + n];
    all += f, far += f * row.place(n);
  }
  const Vec3 near = all - far;
  for (std::size_t c = 0; c < 4; c++) {
    sums[row.block.corner[2 * c]] += Vec3d(near * row.side[c]);
    sums[row.block.corner[2 * c + 1]] += Vec3d(far * row.side[c]);
  }
}

void move_row(const RowInBlock& row, const FollowRun& run, std::span<const Vec3> corners, VecField& u) {
  Vec3 near, far;
  for (std::size_t c = 0; c < 4; c++) {
    near += corners[std::size_t(row.block.corner[2 * c])] * row.side[c];
    far += corners[std::size_t(row.block.corner[2 * c + 1])] * row.side[c];
  }
  const Vec3 slope = far - near;
  Real *x = u.x.data() + run.slot, *y = u.y.data() + run.slot, *z = u.z.data() + run.slot;
  TURGOR_LANES
  for (int n = 0; n < run.count; n++) {
    const Vec3 way = near + slope * row.place(n);
    x[n] += way.x, y[n] += way.y, z[n] += way.z;
  }
}

/// Calls visit(block, weights, copy) or visit(row, copy) for the copies that follow the unknowns.
template <class OfBlock, class OfRow>
void for_copies(const Model& model, const State& state, const CoarseSpace& space, const OfBlock& of_block,
                const OfRow& of_row) {
  const int slots = slot_count(model.lattice);
  for (const ElementNode& copy : state.parts.virtual_nodes) {
    const int to = space.follows[std::size_t(copy.corner)];
    if (to >= 0) {
      const CoarseBlock& block = space.blocks[std::size_t(to)];
      of_block(block, corner_weights(block, slot_node(model.lattice, copy.slot)), copy.corner - slots);
    } else if (to != CoarseSpace::kFixed) {
      of_row(-2 - to, copy.corner - slots);
    }
  }
}

}  // namespace

std::vector<FollowRun> find_follow_runs(const Lattice& l, std::span<const int> follows) {
  std::vector<FollowRun> runs;
  for (int k = 0; k < l.size.z; k++)
    for (int j = 0; j < l.size.y; j++)
      for (int parity = 0; parity < 2; parity++) {
        const int first = row_slot(l, j, k) + parity * l.half;
        for (int n = 0; n < half_count(l, parity); n++) {
          const int to = follows[std::size_t(first + n)];
          if (to == CoarseSpace::kFixed) continue;
          const bool joins = n > 0 && to >= 0 && to == follows[std::size_t(first + n - 1)];
          if (joins)
            runs.back().count++;
          else
            runs.push_back({.first = {2 * n + parity, j, k}, .slot = first + n, .count = 1, .to = to});
        }
      }
  return runs;
}

void add_to_corners(const CoarseSpace& space, int k, LayerForces forces, std::span<Vec3d> sums) {
  for (const FollowRun& run : space.runs_of(k))
    if (run.to >= 0)
      add_row({space, run}, run, forces, sums.data());
    else
      sums[std::size_t(-2 - run.to)] += Vec3d(forces[run.slot]);
}

void add_copies_to_corners(const Model& model, const State& state, std::span<Vec3d> sums) {
  const auto force = [&](int c) {
    const VirtualNodeShift& f = state.residual_forces.virtual_nodes[std::size_t(c)];
    return Vec3d{f.x, f.y, f.z};
  };
  for_copies(
      model, state, *state.coarse,
      [&](const CoarseBlock& block, const std::array<float, 8>& w, int copy) {
        for (std::size_t c = 0; c < 8; c++) sums[std::size_t(block.corner[c])] += force(copy) * double(w[c]);
      },
      [&](int row, int copy) { sums[std::size_t(row)] += force(copy); });
}

void move_followers(const Exec& exec, const Model& model, State& state, std::span<const Vec3> corners) {
  const CoarseSpace& space = *state.coarse;
  parallel_for(exec, std::size_t(model.lattice.size.z), [&](std::size_t k) {
    for (const FollowRun& run : space.runs_of(int(k)))
      if (run.to >= 0)
        move_row({space, run}, run, corners, state.u);
      else
        state.u.set(std::size_t(run.slot),
                    state.u[std::size_t(run.slot)] + corners[std::size_t(-2 - run.to)]);
  });
  const auto move_copy = [&](int c, Vec3 way) {
    VirtualNodeShift& copy = state.virtual_nodes[std::size_t(c)];
    copy = {copy.x + way.x, copy.y + way.y, copy.z + way.z};
  };
  for_copies(
      model, state, space,
      [&](const CoarseBlock& block, const std::array<float, 8>& w, int copy) {
        Vec3 way;
        for (std::size_t c = 0; c < 8; c++) way += corners[std::size_t(block.corner[c])] * w[c];
        move_copy(copy, way);
      },
      [&](int row, int copy) { move_copy(copy, corners[std::size_t(row)]); });
}

}  // namespace turgor::lattice
