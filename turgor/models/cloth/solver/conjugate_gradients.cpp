// Conjugate gradients on the system of the sweeps, preconditioned with its diagonal blocks and optionally the
// coarse correction of two_level.hpp. Sums are made in chunks that do not depend on the number of threads.
#include <algorithm>
#include <cmath>

#include "turgor/core/assert.hpp"
#include "turgor/models/cloth/solver/implicit_contact.hpp"
#include "turgor/models/cloth/solver/system.hpp"
#include "turgor/models/cloth/solver/system_kernels.hpp"
#include "turgor/models/cloth/solver/two_level.hpp"

namespace turgor::cloth {

namespace {

constexpr std::size_t kChunkSize = 64;  // batches of a chunk

double lane_sum(Lanes a) {
  double sum = 0;
  for (int l = 0; l < kLanes; l++) sum += double(a[l]);
  return sum;
}

/// Sum of visit(first vertex) over batches, in a fixed order.
template <class Visit>
double sum_batches(const Exec& exec, const Model& model, const Visit& visit) {
  const std::size_t batches = batch_count(model.rows);
  std::vector<double> chunks((batches + kChunkSize - 1) / kChunkSize);
  parallel_for(exec, chunks.size(), [&](std::size_t p) {
    for (std::size_t b = p * kChunkSize; b < std::min((p + 1) * kChunkSize, batches); b++)
      chunks[p] += lane_sum(visit(b * std::size_t(kLanes)));
  });
  double sum = 0;
  for (const double chunk : chunks) sum += chunk;
  return sum;
}

/// force − W a with contact terms, for the sixteen vertices from i on; 0 for held ones. find_impulses of `a`
/// comes first.
Lanes3 residual_forces(const SheetView& sheet, const State& state, const Vectors& a, Lanes3 force,
                       std::size_t i) {
  return residual_forces<Lanes>(sheet, state.system.mass_factor, view(a), force, i, [&](Lanes3 sum) {
    return state.implicit_contacts.touches(i) ? sum + implicit_contact_terms(state, i) : sum;
  });
}

/// Squared norm of a residual for the sixteen vertices from i on. If it is weighted by the inverse diagonal,
/// stiff directions count as little as they move.
Lanes square(const SheetView& sheet, bool by_diagonal, Lanes3 r, std::size_t i) {
  return dot(r, by_diagonal ? inverse_diagonal<Lanes>(sheet, i) * r : r);
}

/// Squared norm of the force on the free vertices.
double square_of_force(const Exec& exec, const Model& model, const SheetView& sheet, bool by_diagonal) {
  return sum_batches(exec, model, [&](std::size_t i) {
    return square(sheet, by_diagonal, load<Lanes>(sheet.force, i) * is_free<Lanes>(sheet, i), i);
  });
}

}  // namespace

double residual(const Exec& exec, const Model& model, State& state) {
  const System& system = state.system;
  const SheetView sheet = view(model, state);
  TURGOR_ASSERT(system.air[0].size() > 0, "assemble was not told to measure the residual");
  const double force2 = square_of_force(exec, model, sheet, false);
  find_impulses(exec, state, system.change, true);
  const double residual2 = sum_batches(exec, model, [&](std::size_t i) {
    return square(sheet, false, residual_forces(sheet, state, system.change, load(system.force, i), i), i);
  });
  return force2 > 0 ? std::sqrt(residual2 / force2) : 0;
}

namespace {

/// Preconditioner: z = D⁻¹ r, plus the coarse correction; z is stored in System::previous. Returns r · z.
double precondition(const Exec& exec, const Model& model, State& state, bool two_level) {
  System& system = state.system;
  const SheetView sheet = view(model, state);
  Vectors& z = system.previous;
  const auto divide_by_diagonal = [&](std::size_t i) {
    const Lanes3 r = load(system.residual_vector, i), z_i = inverse_diagonal<Lanes>(sheet, i) * r;
    store(z, i, z_i);
    return dot(r, z_i);
  };
  if (!two_level) return sum_batches(exec, model, divide_by_diagonal);
  parallel_for(
      exec, batch_count(model.rows),
      [&](std::size_t batch) { divide_by_diagonal(batch * std::size_t(kLanes)); }, kChunkSize);
  add_coarse_correction(exec, model, state, system.two_level, system.residual_vector, z);
  return sum_batches(exec, model,
                     [&](std::size_t i) { return dot(load(system.residual_vector, i), load(z, i)); });
}

}  // namespace

void solve_by_conjugate_gradients(const Exec& exec, const Model& model, State& state,
                                  const StopCriterion& stop) {
  // initial residual
  System& system = state.system;
  TURGOR_CHECK(system.change.size() == state.x.size(), "every vertex has a change of velocity");
  Vectors &r = system.residual_vector, &p = system.search, &q = system.image, &z = system.previous;
  for (Vectors* field : {&r, &p, &q}) field->resize(system.change.size());
  const SheetView sheet = view(model, state);
  find_impulses(exec, state, system.change, true);
  double residual2 = sum_batches(exec, model, [&](std::size_t i) {
    const Lanes3 r_i = residual_forces(sheet, state, system.change, load(system.force, i), i);
    store(r, i, r_i);
    return square(sheet, stop.by_diagonal, r_i, i);
  });
  // tolerance and preconditioner
  const double force2 = square_of_force(exec, model, sheet, stop.by_diagonal);
  TURGOR_CHECK(stop.iterations >= 1, "a solution takes at least one iteration");
  const double enough = stop.residual * stop.residual * force2;
  const bool two_level = stop.two_level && residual2 > enough;
  if (two_level && !system.two_level.is_factored) factor_coarse_system(exec, model, state, system.two_level);
  double rz = precondition(exec, model, state, two_level), beta = 0;
  int n = 0;
  for (; n < stop.iterations && rz > 0 && residual2 > enough; n++) {
    // search direction
    parallel_for(
        exec, batch_count(model.rows),
        [&](std::size_t batch) {
          const std::size_t i = batch * std::size_t(kLanes);
          store(p, i, n == 0 ? load(z, i) : load(z, i) + load(p, i) * all_lanes(float(beta)));
        },
        kChunkSize);
    // matrix product
    find_impulses(exec, state, p, false);
    const double pq = sum_batches(exec, model, [&](std::size_t i) {
      const Lanes3 zero{};
      const Lanes3 image = zero - residual_forces(sheet, state, p, zero, i);
      store(q, i, image);
      return dot(load(p, i), image);
    });
    if (!(pq > 0)) break;
    // step along the direction
    const Lanes alpha = all_lanes(float(rz / pq));
    residual2 = sum_batches(exec, model, [&](std::size_t i) {
      const Lanes3 r_i = load(r, i) - load(q, i) * alpha;
      store(system.change, i, load(system.change, i) + load(p, i) * alpha);
      store(r, i, r_i);
      return square(sheet, stop.by_diagonal, r_i, i);
    });
    // next preconditioned residual
    if (!(residual2 > enough)) continue;
    const double next = precondition(exec, model, state, two_level);
    beta = next / rz, rz = next;
  }
  system.iterations = n, system.residual = force2 == 0 ? 0 : std::sqrt(residual2 / force2);
}

}  // namespace turgor::cloth
