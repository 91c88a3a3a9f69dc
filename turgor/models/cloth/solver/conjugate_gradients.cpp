// Conjugate gradients on the same system, preconditioned with the same diagonal blocks: the reference that
// sweeps are compared with. Sums are made in pieces that do not depend on the number of threads.
#include <algorithm>
#include <cmath>

#include "turgor/core/assert.hpp"
#include "turgor/models/cloth/solver/system.hpp"
#include "turgor/models/cloth/solver/system_kernels.hpp"

namespace turgor::cloth {

namespace {

constexpr std::size_t kPiece = 64;  // batches that are summed at once

double lane_sum(Lanes a) {
  double sum = 0;
  for (int l = 0; l < kLanes; l++) sum += double(a[l]);
  return sum;
}

/// Σ over batches of visit(first vertex) in a fixed order.
template <class Visit>
double sum_batches(const Exec& exec, const Model& model, const Visit& visit) {
  const std::size_t batches = batch_count(model.rows);
  std::vector<double> pieces((batches + kPiece - 1) / kPiece);
  parallel_for(exec, pieces.size(), [&](std::size_t p) {
    for (std::size_t b = p * kPiece; b < std::min((p + 1) * kPiece, batches); b++)
      pieces[p] += lane_sum(visit(b * std::size_t(kLanes)));
  });
  double sum = 0;
  for (const double piece : pieces) sum += piece;
  return sum;
}

/// force − W a and what bears the sheet, of the vertices from i on; 0 for held ones.
Lanes3 residual_forces(const SheetView& sheet, const State& state, const Vectors& a, Lanes3 force,
                       std::size_t i, bool with_loads = true) {
  return residual_forces<Lanes>(sheet, state.system.keep, view(a), force, i, [&](Lanes3 sum) {
    return state.implicit_contacts.touches(i) ? sum + implicit_contact_terms(state, a, with_loads, i) : sum;
  });
}

/// The square of a residual at the vertices from i on. Where obstacles bear the sheet it is weighed by what
/// the diagonal makes of it, so that stiff directions count for as little as they move.
Lanes square(const SheetView& sheet, const State& state, Lanes3 r, std::size_t i) {
  return dot(r, state.implicit_contacts.contacts.list.empty() ? r : inverse_diagonal<Lanes>(sheet, i) * r);
}

/// The same of the force on the free vertices.
double square_of_force(const Exec& exec, const Model& model, const SheetView& sheet, const State& state) {
  return sum_batches(exec, model, [&](std::size_t i) {
    return square(sheet, state, load<Lanes>(sheet.force, i) * is_free<Lanes>(sheet, i), i);
  });
}

}  // namespace

double residual(const Exec& exec, const Model& model, State& state) {
  const System& system = state.system;
  const SheetView sheet = view(model, state);
  TURGOR_ASSERT(system.air[0].size() > 0, "assemble was not told to measure the residual");
  const double force2 = square_of_force(exec, model, sheet, state);
  const double left2 = sum_batches(exec, model, [&](std::size_t i) {
    return square(sheet, state, residual_forces(sheet, state, system.change, load(system.force, i), i), i);
  });
  return force2 > 0 ? std::sqrt(left2 / force2) : 0;
}

namespace {

/// z = what the preconditioner makes of r, in System::before; returns r · z.
double precondition(const Exec& exec, const Model& model, State& state, bool by_blocks) {
  System& system = state.system;
  const SheetView sheet = view(model, state);
  Vectors& z = system.before;
  const auto diagonal = [&](std::size_t i) {
    const Lanes3 r = load(system.left, i), answer = inverse_diagonal<Lanes>(sheet, i) * r;
    store(z, i, answer);
    return dot(r, answer);
  };
  if (!by_blocks) return sum_batches(exec, model, diagonal);
  sum_batches(exec, model, diagonal);
  system.blocks.add_answer(exec, model, state, system.left, z);
  return sum_batches(exec, model, [&](std::size_t i) { return dot(load(system.left, i), load(z, i)); });
}

}  // namespace

void solve_by_conjugate_gradients(const Exec& exec, const Model& model, State& state, const Stop& stop) {
  System& system = state.system;
  Vectors &r = system.left, &p = system.search, &q = system.image, &z = system.before;
  for (Vectors* field : {&r, &p, &q}) field->resize(system.change.size());
  const SheetView sheet = view(model, state);
  double left2 = sum_batches(exec, model, [&](std::size_t i) {
    const Lanes3 left = residual_forces(sheet, state, system.change, load(system.force, i), i);
    store(r, i, left);
    return square(sheet, state, left, i);
  });
  const double force2 = square_of_force(exec, model, sheet, state);
  const double enough = stop.residual * stop.residual * force2;
  const bool by_blocks = stop.blocks && left2 > enough && system.blocks.factor(exec, model, state);
  double rz = precondition(exec, model, state, by_blocks), beta = 0;
  int n = 0;
  for (; n < stop.iterations && rz > 0 && left2 > enough; n++) {
    parallel_for(
        exec, batch_count(model.rows),
        [&](std::size_t batch) {
          const std::size_t i = batch * std::size_t(kLanes);
          store(p, i, n == 0 ? load(z, i) : load(z, i) + load(p, i) * all_lanes(float(beta)));
        },
        kPiece);
    const double pq = sum_batches(exec, model, [&](std::size_t i) {
      const Lanes3 zero{};
      const Lanes3 image = zero - residual_forces(sheet, state, p, zero, i, false);
      store(q, i, image);
      return dot(load(p, i), image);
    });
    if (!(pq > 0)) break;
    const Lanes alpha = all_lanes(float(rz / pq));
    left2 = sum_batches(exec, model, [&](std::size_t i) {
      const Lanes3 left = load(r, i) - load(q, i) * alpha;
      store(system.change, i, load(system.change, i) + load(p, i) * alpha);
      store(r, i, left);
      return square(sheet, state, left, i);
    });
    if (!(left2 > enough)) continue;
    const double next = precondition(exec, model, state, by_blocks);
    beta = next / rz, rz = next;
  }
  system.iterations = n, system.residual = force2 == 0 ? 0 : std::sqrt(left2 / force2);
}

}  // namespace turgor::cloth
