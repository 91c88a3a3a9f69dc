#include "turgor/models/lattice/coarse/coarse_correction.hpp"

#include <algorithm>
#include <numeric>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/models/lattice/coarse/coarse_levels.hpp"
#include "turgor/models/lattice/coarse/coupled_points.hpp"
#include "turgor/models/lattice/coarse/prolongation.hpp"
#include "turgor/models/lattice/coarse/secant_search.hpp"
#include "turgor/models/lattice/mechanics/point_springs.hpp"

namespace turgor::lattice {

namespace {

/// Restricts the residual to the unknowns [N].
std::vector<double> restrict_residual(const Exec& exec, const Model& model, State& state,
                                      const Inputs& inputs, double dt) {
  const CoarseSpace& space = *state.workspace.coarse;
  TURGOR_CHECK(space.version == cut_version(state.cuts), "the coarse space was built for the current cuts");
  // residual at corners of blocks, by chunk
  const std::size_t rows = space.row_begin.size() - 1;
  std::vector<Vec3d> sums(kLayerChunks * rows);
  const auto sums_of = [&](std::size_t chunk) { return std::span(sums).subspan(chunk * rows, rows); };
  visit_residual_forces(exec, model, state, space, inputs, dt, state.workspace.residual,
                        [&](int chunk, int k, LayerForces forces) {
                          restrict_layer(space, k, forces, sums_of(std::size_t(chunk)));
                        });
  restrict_virtual_nodes(model, state, sums_of(0));
  // corners to unknowns
  std::vector<double> out(3 * std::size_t(space.unknowns));
  for (std::size_t row = 0; row < rows; row++) {
    Vec3d sum;
    for (std::size_t chunk = 0; chunk < kLayerChunks; chunk++) sum += sums_of(chunk)[row];
    for (int t = space.row_begin[row]; t < space.row_begin[row + 1]; t++)
      for (int axis = 0; axis < 3; axis++)
        out[std::size_t(3 * space.terms[std::size_t(t)].unknown + axis)] +=
            double(space.terms[std::size_t(t)].weight) * sum[axis];
  }
  return out;
}

/// Adds `step_length` times the prolongation of the unknowns to nodes and virtual nodes.
void add_prolongation(const Exec& exec, const Model& model, State& state, std::span<const double> unknowns,
                      double step_length) {
  const CoarseSpace& space = *state.workspace.coarse;
  TURGOR_CHECK(unknowns.size() == 3 * std::size_t(space.unknowns), "every unknown has three numbers");
  // unknowns to corners
  std::vector<Vec3> corners(space.row_begin.size() - 1);
  for (std::size_t row = 0; row < corners.size(); row++) {
    Vec3d sum;
    for (int t = space.row_begin[row]; t < space.row_begin[row + 1]; t++)
      for (int axis = 0; axis < 3; axis++)
        sum[axis] += double(space.terms[std::size_t(t)].weight) *
                     unknowns[std::size_t(3 * space.terms[std::size_t(t)].unknown + axis)];
    corners[row] = Vec3(sum * step_length);
  }
  // corners to nodes
  prolongate(exec, model, state, corners);
}

double work(std::span<const double> forces, std::span<const double> correction) {
  return std::inner_product(forces.begin(), forces.end(), correction.begin(), 0.0);
}

/// Largest norm of vectors of three numbers each.
double largest_displacement(std::span<const double> displacements) {
  TURGOR_CHECK(displacements.size() % 3 == 0, "every unknown has three numbers");
  double most = 0;
  for (std::size_t n = 0; n < displacements.size(); n += 3)
    most = std::max(most, norm(Vec3d{displacements[n], displacements[n + 1], displacements[n + 2]}));
  return most;
}

/// Phases of a correction on the host (secant_search.hpp).
struct HostCorrection {
  const Exec& exec;
  const Model& model;
  State& state;
  const Inputs& inputs;
  double dt;
  std::vector<double> residual = {}, correction = {};  // three components per unknown [N] [m]
  SecantSearch search = {};

  void restrict_residual() {
    if (inputs.springs && inputs.springs->refresh) inputs.springs->refresh(state);
    residual = lattice::restrict_residual(exec, model, state, inputs, dt);
  }
  void solve() {
    correction = solve_coupled(*state.workspace.coarse, inputs.springs,
                               find_contact_columns(model, state, inputs), residual);
  }
  void begin_search() { search.begin(work(residual, correction)); }
  void prolongate() {
    if (search.change != 0) add_prolongation(exec, model, state, correction, search.change);
  }
  void end_search() { search.end(work(residual, correction)); }
};

/// True if a blade may cut in the next steps. It counts as stopped after some steps without a cut.
bool is_blade_active(State& state, std::size_t cuts) {
  constexpr int kStopped = 8;
  state.workspace.steps_since_cut =
      cuts != state.workspace.cuts_before ? 0 : state.workspace.steps_since_cut + 1;
  state.workspace.cuts_before = cuts;
  return state.cuts.active_blades.any() && state.workspace.steps_since_cut < kStopped;
}

/// True if the body is uncut, unloaded and still, so that there is no residual to correct.
bool is_at_rest(const Model& model, const State& state, const Inputs& inputs, double dt) {
  constexpr double kStill = 1e-6;  // cells per step; above rounding errors
  const Vec3 h = model.anatomy.lattice.spacing;
  return cut_version(state.cuts) == 0 && inputs.loads.empty() && inputs.contacts.empty() &&
         inputs.springs == nullptr && norm(inputs.gravity) == 0 &&
         double(state.motion.fastest) * dt < kStill * double(std::min({h.x, h.y, h.z}));
}

}  // namespace

bool supports_coarse_space(const Model& model) {
  const Params& params = model.params;
  return params.solver.coarse && params.solver.method == Method::kVbd &&
         params.tissue.law == TissueLaw::kSolid;
}

bool prepare_coarse_space(const Model& model, State& state, const Inputs& inputs, double dt,
                          const Exec& exec) {
  TURGOR_CHECK(is_step_length(dt), "a step has a positive length");
  if (!supports_coarse_space(model)) return false;
  const std::size_t cuts = cut_version(state.cuts);
  const bool blade_active = is_blade_active(state, cuts);
  if (is_at_rest(model, state, inputs, dt)) return false;
  // Frame times are rounded. Substeps of a frame, with a fast tool, are not worth a space of their own.
  if (state.workspace.coarse && dt < 0.99 * state.workspace.coarse->dt) return false;
  if (!state.workspace.coarse || state.workspace.coarse->version != cuts ||
      dt > 1.01 * state.workspace.coarse->dt) {
    if (blade_active) return false;
    state.workspace.coarse = make_coarse_space(model, state, dt, exec);
  }
  couple_points(model, state, inputs.springs);
  return state.workspace.coarse->unknowns > 0;
}

CoarseStep apply_coarse_correction(const Exec& exec, const Model& model, State& state, const Inputs& inputs,
                                   double dt) {
  TURGOR_ASSERT(state.workspace.coarse != nullptr, "a coarse correction needs a coarse space");
  HostCorrection body{exec, model, state, inputs, dt};
  correct_two_grid(body);
  return {body.search.step_length * largest_displacement(body.correction), body.search.step_length};
}

std::size_t memory_bytes(const CoarseSpace& space) {
  const auto bytes = [](const auto& list) { return list.capacity() * sizeof(list[0]); };
  return bytes(space.blocks) + bytes(space.row_begin) + bytes(space.terms) + bytes(space.interpolation) +
         bytes(space.runs) + bytes(space.run_weights) + bytes(space.runs_begin) + bytes(space.outside) +
         bytes(space.loose) + bytes(space.cells.all) + bytes(space.cells.row_begin) +
         bytes(space.factor.order) + bytes(space.factor.inverse_diagonal) + bytes(space.factor.column) +
         bytes(space.factor.row) + bytes(space.factor.value) +
         (space.coupled ? memory_bytes(*space.coupled) : 0);
}

}  // namespace turgor::lattice
