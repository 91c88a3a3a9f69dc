#include "turgor/sim/live/undo_cut.hpp"

#include <limits>

#include "turgor/core/assert.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

namespace {

/// Memory of the arrays by slot, which dominate a state.
std::size_t bytes_of(const lattice::State& state) {
  const lattice::Motion& motion = state.motion;
  std::size_t reals = 0;
  for (const lattice::VecField* field : {&motion.u, &motion.u_before, &motion.v})
    reals += field->x.size() + field->y.size() + field->z.size();
  return reals * sizeof(Real) + state.cuts.cut.size() + state.cuts.removed.size() +
         state.cuts.edges.size() * sizeof(lattice::CutEdge) +
         state.cut_elements.cells.size() * sizeof(lattice::CutCellElement);
}

}  // namespace

std::shared_ptr<const lattice::State> state_before_cut(World& world, const LatticeBody& body) {
  const lattice::State& state = body.state.host();
  std::size_t bytes = bytes_of(state);
  if (bytes > kCopiedBytes) return nullptr;

  // drop the oldest copies beyond the limit
  for (auto cut = world.cuts.rbegin(); cut != world.cuts.rend(); ++cut) {
    if (!cut->before) continue;
    bytes += bytes_of(*cut->before);
    if (bytes > kCopiedBytes) cut->before.reset();
  }
  return std::make_shared<const lattice::State>(state);
}

Status undo_last_cut(World& world) {
  TURGOR_ASSERT(!world.cuts.empty(), "a cut is taken back");
  const Cut& cut = world.cuts.back();
  if (!cut.before) return Error{"no undo: the state before the cut was too large to keep"};
  LatticeBody& body = world.lattice_bodies[std::size_t(cut.body)];
  const double time = body.state.host().motion.time;
  lattice::State& state = body.state.change();
  state = *cut.before;
  state.motion.time = time;
  state.sleep = {};                                                  // wakes all rows
  body.surface_cuts = std::numeric_limits<std::size_t>::max();       // the surface is built again
  body.last_displacement = std::numeric_limits<double>::infinity();  // unknown
  world.cuts.pop_back();
  return Done{};
}

}  // namespace turgor
