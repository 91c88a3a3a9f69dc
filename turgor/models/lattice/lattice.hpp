// The lattice model: a body from a CT volume, made of springs, volumes and tense skin, that can be cut. [STC]
// is Jeon, Seo, Kye 2025; docs/models/lattice.md lists the corrections. Two solvers share the constraints:
// position-based dynamics as in the paper, and vertex block descent (Chen et al. 2024). The stiffness of the
// VBD solution does not depend on the number of sweeps.
//
// Displacements, velocities and forces are along the axes of the lattice. Anatomy::grid.axes rotates them
// into the patient frame.
#pragma once

#include <cstdint>

#include "turgor/core/exec.hpp"
#include "turgor/core/result.hpp"
#include "turgor/geometry/volume.hpp"
#include "turgor/models/lattice/model/inputs.hpp"
#include "turgor/models/lattice/model/model.hpp"
#include "turgor/models/lattice/model/params.hpp"
#include "turgor/models/lattice/model/state.hpp"
#include "turgor/models/lattice/solver/energy.hpp"

namespace turgor::lattice {

/// Optional fields on the same patient as the CT; null = absent.
struct BodyFields {
  const LabelVolume* labels = nullptr;  // a segmentation, for TissueParams::young_of_label
  const VectorVolume* lines = nullptr;  // Langer's lines, instead of SkinParams::direction
};

/// Builds a body from a CT. Errors: only air in the CT, no skin although skin is enabled, fields that do not
/// cover the CT.
Result<Model> build(const Exec& exec, const CtVolume& ct, const BodyFields& fields, const Params& params);
State make_state(const Model& model);
StepReport step(const Exec& exec, const Model& model, State& state, const Inputs& inputs, double dt);

/// Memory of a model and its state during a simulation [bytes].
std::size_t memory_bytes(const Model& model, const State& state);
/// Hash of displacements, velocities, cuts and removed nodes. It does not depend on the number of threads.
std::uint64_t state_hash(const Model& model, const State& state);
/// Hash of the owned layers without virtual nodes, continued from the hash of the layers below.
std::uint64_t hash_of_layers(const Model& model, const State& state, std::uint64_t hash);

}  // namespace turgor::lattice
