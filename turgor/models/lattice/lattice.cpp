// Public functions of the lattice model except step() and energy(): construction, memory and hashes.
#include "turgor/models/lattice/lattice.hpp"

#include "turgor/core/hash.hpp"
#include "turgor/models/lattice/build/body_nodes.hpp"
#include "turgor/models/lattice/coarse/coarse_correction.hpp"
#include "turgor/models/lattice/model/fields.hpp"
#include "turgor/models/lattice/solver/sleep.hpp"

namespace turgor::lattice {

Result<Model> build(const Exec& exec, const CtVolume& ct, const BodyFields& fields, const Params& params) {
  Result<BodyNodes> nodes = classify(exec, ct, fields.labels, params);
  if (!nodes) return nodes.error();
  return assemble(exec, *nodes, fields.lines, params);
}

State make_state(const Model& model) {
  State state;
  const auto slots = std::size_t(slot_count(model.anatomy.lattice));
  for (VecField* field : {&state.motion.u, &state.motion.u_before, &state.motion.v}) field->resize(slots);
  state.cuts.cut.assign(slots, 0);
  state.cuts.removed.assign(slots, 0);
  state.cuts.row_cut.assign(slots / std::size_t(row_stride(model.anatomy.lattice)), 0);
  state.cuts.skin_cut.assign(skin_element_count(model.anatomy.skin), 0);
  return state;
}

std::size_t memory_bytes(const Model& model, const State& state) {
  return bytes_of_fields(model, state) + (state.workspace.coarse ? memory_bytes(*state.workspace.coarse) : 0);
}

std::uint64_t hash_of_layers(const Model& model, const State& state, std::uint64_t hash) {
  const Lattice& l = model.anatomy.lattice;
  for (int k = model.anatomy.owned.begin; k < model.anatomy.owned.end; k++)
    for (int j = 0; j < l.size.y; j++)
      for (int parity = 0; parity < 2; parity++)
        hash = hash_of_fields(state, std::size_t(row_slot(l, j, k) + parity * l.half),
                              std::size_t(half_count(l, parity)), hash);
  return hash;
}

std::uint64_t state_hash(const Model& model, const State& state) {
  std::uint64_t hash = hash_of_layers(model, state, kHashSeed);
  if (!state.motion.virtual_u.empty())
    hash = hash_values(std::span<const VirtualNodeDisplacement>(state.motion.virtual_u), hash);
  for (const SymmetricField& field : state.viscosity.history)
    for (const auto* entry : {&field.xx, &field.yy, &field.zz, &field.xy, &field.xz, &field.yz})
      hash = hash_values(std::span<const Real>(*entry), hash);
  if (can_sleep(model)) {
    hash = hash_values(std::span<const std::uint8_t>(state.sleep.still_steps), hash);
    hash = hash_values(std::span<const std::uint8_t>(&state.sleep.coarse_still_steps, 1), hash);
  }
  return hash;
}

}  // namespace turgor::lattice
