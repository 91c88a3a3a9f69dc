#include "turgor/sim/live/undo_cut.hpp"

#include <limits>
#include <utility>

#include "turgor/core/assert.hpp"
#include "turgor/models/lattice/build/scale_stiffness.hpp"
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

std::shared_ptr<const BeforeCut> state_before_cut(World& world, const LatticeBody& body) {
  const lattice::State& state = body.state.host();
  std::size_t bytes = bytes_of(state);
  if (bytes > kCopiedBytes) return nullptr;

  // drop the oldest copies beyond the limit
  for (auto cut = world.cuts.rbegin(); cut != world.cuts.rend(); ++cut) {
    if (!cut->before) continue;
    bytes += bytes_of(cut->before->state);
    if (bytes > kCopiedBytes) cut->before.reset();
  }
  BeforeCut before{.state = state, .stiffness_scale = body.stiffness_scale, .cuts = {}};
  for (const Cut& cut : world.cuts)
    before.cuts.push_back({.has_path = cut.path.has_value(), .done = cut.done, .edges = cut.edges});
  return std::make_shared<const BeforeCut>(std::move(before));
}

Status undo_last_cut(World& world) {
  TURGOR_ASSERT(!world.cuts.empty(), "a cut is taken back");
  const std::shared_ptr<const BeforeCut> before = world.cuts.back().before;
  const int number = world.cuts.back().body;
  if (!before) return Error{"no undo: the state before the cut was too large to keep"};
  LatticeBody& body = world.lattice_bodies[std::size_t(number)];
  const double time = body.state.host().motion.time;
  lattice::State& state = body.state.change();
  // cut cells have the stiffness of the time of the copy
  const double factor = body.stiffness_scale / before->stiffness_scale;
  if (factor != 1) lattice::scale_stiffness(1 / factor, body.model, state);
  state = before->state;
  if (factor != 1) lattice::scale_stiffness(factor, body.model, state);
  state.motion.time = time;
  state.sleep = {};                                                  // wakes all rows
  body.surface_cuts = std::numeric_limits<std::size_t>::max();       // the surface is built again
  body.last_displacement = std::numeric_limits<double>::infinity();  // unknown
  world.cuts.pop_back();
  // earlier cuts of the body
  for (std::size_t n = 0; n < world.cuts.size(); n++) {
    Cut& cut = world.cuts[n];
    if (cut.body != number) continue;
    const CutProgress& progress = before->cuts[n];
    if (!progress.has_path) cut.path.reset();
    cut.done = progress.done, cut.edges = progress.edges;
  }
  return Done{};
}

}  // namespace turgor
