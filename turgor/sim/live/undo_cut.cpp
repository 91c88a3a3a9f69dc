#include "turgor/sim/live/undo_cut.hpp"

#include <limits>
#include <utility>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/models/lattice/build/scale_stiffness.hpp"
#include "turgor/models/lattice/cutting/cut_topology.hpp"
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

/// Young's moduli of the cells of all cut-cell elements [Pa].
std::vector<Real> cell_moduli(const lattice::Model& model, const lattice::State& state) {
  std::vector<Real> moduli;
  for (const lattice::CutCellElement& element : state.cut_elements.cells)
    moduli.push_back(model.anatomy.cell_young[std::size_t(element.slot)]);
  return moduli;
}

/// Restores the state. Its cut cells and histories have the stiffness of the time of the copy, and its
/// prestress is that of the skin then; both follow changes since.
void restore_state(const BeforeCut& before, LatticeBody& body) {
  lattice::State& state = body.state.change();
  const double factor = body.stiffness_scale / before.stiffness_scale;
  const bool has_scale = factor != 1 && body.model.params.tissue == before.tissue;
  if (has_scale) lattice::scale_stiffness(1 / factor, body.model, state);
  state = before.state;
  if (has_scale) lattice::scale_stiffness(factor, body.model, state);
  if (body.model.params.tissue != before.tissue) {
    const std::vector<Real> now = cell_moduli(body.model, state);
    for (std::size_t n = 0; n < now.size(); n++)
      if (before.cell_moduli[n] > 0) state.cut_elements.cells[n].young *= now[n] / before.cell_moduli[n];
    state.viscosity = {};
    state.workspace.coarse.reset();  // its operator has the former moduli
  }
  lattice::renew_prestress(body.model, state.cuts, state.cut_elements);
}

/// Tool contact without the contacts, whose samples a cut renumbers.
contact::LatticeTouch without_contacts(contact::LatticeTouch touch) {
  touch.contacts.clear(), touch.nodes.clear(), touch.contact_points = {};
  return touch;
}

/// Restores the samples that tools touch. The tools keep their poses.
void restore_touch(const BeforeCut& before, LatticeBody& body) {
  std::vector<contact::ToolPose> poses = std::move(body.touch.poses);
  body.touch = before.touch;
  body.touch.poses = std::move(poses);
}

/// Restores the stitches of a body. Those that were laid after the copy are embedded again, or laid again
/// once their wound is cut.
void restore_stitches(const BeforeCut& before, int number, World& world) {
  const LatticeBody& body = world.lattice_bodies[std::size_t(number)];
  for (std::size_t n = 0; n < world.sutures.size(); n++) {
    Suture& suture = world.sutures[n];
    if (suture.scene.body != number) continue;
    std::optional<lattice::WoundClosure>& closure = suture.closure;
    if (n < before.closures.size()) closure = before.closures[n];
    TURGOR_CHECK(is_index(suture.scene.incision, world.cuts.size()), "a suture closes a cut of the world");
    if (world.cuts[std::size_t(suture.scene.incision)].done < 1) closure.reset();
    const lattice::Cuts& cuts = body.state.cuts();
    if (closure && closure->version != cut_version(cuts) &&
        !lattice::embed_closure(body.model, cuts, *closure))
      closure.reset();
  }
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
  BeforeCut before{.state = state,
                   .stiffness_scale = body.stiffness_scale,
                   .tissue = body.model.params.tissue,
                   .cell_moduli = cell_moduli(body.model, state),
                   .cuts = {},
                   .closures = {},
                   .touch = without_contacts(body.touch)};
  for (const Cut& cut : world.cuts)
    before.cuts.push_back({.has_path = cut.path.has_value(), .done = cut.done, .edges = cut.edges});
  for (const Suture& suture : world.sutures) before.closures.push_back(suture.closure);
  return std::make_shared<const BeforeCut>(std::move(before));
}

Status undo_last_cut(World& world) {
  TURGOR_ASSERT(!world.cuts.empty(), "a cut is taken back");
  const std::shared_ptr<const BeforeCut> before = world.cuts.back().before;
  const int number = world.cuts.back().body;
  if (!before) return Error{"no undo: the state before the cut was too large to keep"};
  LatticeBody& body = world.lattice_bodies[std::size_t(number)];
  const double time = body.state.host().motion.time;
  restore_state(*before, body);
  lattice::State& state = body.state.change();
  state.motion.time = time;
  state.sleep = {};                                                  // wakes all rows
  body.surface_cuts = std::numeric_limits<std::size_t>::max();       // the surface is built again
  body.last_displacement = std::numeric_limits<double>::infinity();  // unknown
  restore_touch(*before, body);
  world.cuts.pop_back();
  // earlier cuts of the body
  for (std::size_t n = 0; n < world.cuts.size(); n++) {
    Cut& cut = world.cuts[n];
    if (cut.body != number) continue;
    const CutProgress& progress = before->cuts[n];
    if (!progress.has_path) cut.path.reset();
    cut.done = progress.done, cut.edges = progress.edges;
  }
  restore_stitches(*before, number, world);
  return Done{};
}

}  // namespace turgor
