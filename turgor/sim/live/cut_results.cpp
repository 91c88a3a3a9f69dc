#include "turgor/sim/live/cut_results.hpp"

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

namespace {

/// Surface with the present cuts: that of the contact with tools, or one around the cuts.
const lattice::BodySurface& surface_of(const Exec& exec, const LatticeBody& body, CutMeasuring& measuring) {
  const lattice::Cuts& cuts = body.state.cuts();
  if (!body.rest.empty() && body.surface_cuts == cut_version(cuts)) return body.surface;
  if (!measuring.near.fragments || measuring.near.fragments->version != cut_version(cuts))
    measuring.near = build_surface(body.model, cuts, &body.ct, lattice::Extent::kCuts, exec);
  return measuring.near;
}

lattice::Wound wound_of(const Exec& exec, const LatticeBody& body, const Cut& cut, int number,
                        CutMeasuring& measuring) {
  const lattice::BodySurface& surface = surface_of(exec, body, measuring);
  std::vector<int> nodes;
  if (body.state.is_on_device())
    nodes = wound_support_nodes(body.model, body.state.cuts(), body.state.virtual_u(), surface, *cut.path,
                                number);
  return body.state.read_wound_nodes(nodes, [&](const lattice::State& state) {
    return lattice::measure_wound(body.model, state, surface, *cut.path, number);
  });
}

}  // namespace

void update_cut_result(const Exec& exec, const World& world, std::size_t scene_cuts, CutMeasuring& measuring,
                       CutResult& result) {
  if (world.cuts.size() <= scene_cuts) {
    result = {}, measuring = {};
    return;
  }
  const int number = int(world.cuts.size()) - 1;
  const Cut& cut = world.cuts.back();
  TURGOR_CHECK(is_index(cut.body, world.lattice_bodies.size()), "a cut belongs to a lattice");
  if (result.cut != number) result = {.cut = number}, measuring = {};
  result.done = cut.done, result.depth = cut.blade.depth;
  if (cut.done < 1 || !cut.path) return;

  // the open wound
  constexpr double kPause = 0.25;  // between measurements [s]
  const bool is_due = measuring.cut != number || time_of(world) >= measuring.time + kPause;
  if (!is_due) return;
  measuring.cut = number, measuring.time = time_of(world);
  const LatticeBody& body = world.lattice_bodies[std::size_t(cut.body)];
  const lattice::Wound wound = wound_of(exec, body, cut, number, measuring);
  result.length = wound.length, result.gape_max = wound.gape_max, result.gape_mean = wound.gape_mean;
  result.is_measured = true;
}

}  // namespace turgor
