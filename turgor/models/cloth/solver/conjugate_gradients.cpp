// Conjugate gradients on the system of the sweeps, preconditioned with its diagonal blocks and optionally the
// coarse correction of two_level.hpp. Sums are made in chunks that do not depend on the number of threads.
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "turgor/core/assert.hpp"
#include "turgor/models/cloth/model/packed_vectors.hpp"
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

/// Sums of the numbers that visit(first vertex) returns, over batches, in a fixed order.
template <std::size_t kSums, class Visit>
std::array<double, kSums> sums_of_batches(const Exec& exec, const Model& model, const Visit& visit) {
  const std::size_t batches = batch_count(model.rows);
  std::vector<std::array<double, kSums>> chunks((batches + kChunkSize - 1) / kChunkSize);
  parallel_for(exec, chunks.size(), [&](std::size_t p) {
    std::array<double, kSums> sums{};
    for (std::size_t b = p * kChunkSize; b < std::min((p + 1) * kChunkSize, batches); b++) {
      const std::array<Lanes, kSums> more = visit(b * std::size_t(kLanes));
      for (std::size_t n = 0; n < kSums; n++) sums[n] += lane_sum(more[n]);
    }
    chunks[p] = sums;
  });
  std::array<double, kSums> sums{};
  for (const std::array<double, kSums>& chunk : chunks)
    for (std::size_t n = 0; n < kSums; n++) sums[n] += chunk[n];
  return sums;
}
template <class Visit>
double sum_batches(const Exec& exec, const Model& model, const Visit& visit) {
  return sums_of_batches<1>(exec, model, [&](std::size_t i) { return std::array{visit(i)}; })[0];
}

/// force − W a with contact terms, for the sixteen vertices from i on; 0 for held ones. find_impulses of `a`
/// comes first.
Lanes3 residual_forces(const SheetView& sheet, const State& state, const Vectors& a, Lanes3 force,
                       std::size_t i) {
  return residual_forces<Lanes>(sheet, state.system.mass_factor, view(a), force, i, [&](Lanes3 sum) {
    return state.implicit_contacts.touches(i) ? sum + implicit_contact_terms(state, i) : sum;
  });
}

/// Product W p of residual_forces (system_kernels.hpp), eight vertices at a time.
struct EightProduct {
  const SheetView& s;
  Real mass_factor;
  ConstVectorsView p;
  const Real *packed_x, *packed_p;

  static Eight3 load(ConstVectorsView a, std::size_t i) { return load_eight(a.x + i, a.y + i, a.z + i); }
  /// Vectors of the neighbors of the vertices from `half` of their batch on.
  static Eight3 neighbors(const RowsView& rows, ConstVectorsView plain, const Real* packed, int slot,
                          std::size_t half) {
    const int first = rows.first[slot];
    return first >= 0 ? load(plain, std::size_t(first) + half)
                      : gather_eight(packed, rows.gathered - 1 - first + half);
  }

  /// `contacts`: their terms at these vertices.
  Eight3 operator()(std::size_t i, Eight3 contacts) const {
    // inertia and wind
    const Eight3 x = load(s.x, i), mine = load(p, i);
    const Eight mass = load_eight(s.free_mass + i);
    const Eight3 diagonal = load(s.air[0], i), off = load(s.air[1], i);
    const Eight3 air{diagonal.x * mine.x + off.x * mine.y + off.y * mine.z,
                     off.x * mine.x + diagonal.y * mine.y + off.z * mine.z,
                     off.y * mine.x + off.z * mine.y + diagonal.z * mine.z};
    Eight3 sum = Eight3{} - mine * (mass * mass_factor) - air;
    // springs or membrane
    const std::size_t half = i % std::size_t(kLanes);
    for (int slot = s.rows.begin(i); slot < s.rows.end(i); slot++) {
      const Eight3 d = neighbors(s.rows, s.x, packed_x, slot, half) - x,
                   u = neighbors(s.rows, p, packed_p, slot, half) - mine;
      const std::size_t entry = std::size_t(slot) * std::size_t(kLanes) + half;
      sum = sum + d * (load_eight(s.along + entry) * dot(d, u)) + u * load_eight(s.across + entry);
    }
    // bending
    Eight3 bend{};
    if (s.is_sheet())
      for (int slot = s.far.begin(i); slot < s.far.end(i); slot++) {
        const std::size_t entry = std::size_t(slot) * std::size_t(kLanes) + half;
        bend = bend + (neighbors(s.far, p, packed_p, slot, half) - mine) * load_eight(s.far.bend + entry);
      }
    const Eight is_free = mass > 0 ? Eight{} + 1 : Eight{};
    return Eight3{} - (sum + contacts + bend * (Eight{} + s.stiffness_factor)) * is_free;
  }
};

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

/// One solution: vectors of the system, and its criterion.
struct Solution {
  const Exec& exec;
  const Model& model;
  State& state;
  const StopCriterion& stop;
  System& system = state.system;
  SheetView sheet = view(model, state);
  PackedVectors packed_x, packed_p;  // positions and search directions
  double residual2 = 0, rz = 0;      // squared norm of the residual; r · z

  /// Memory, and positions of the neighbors.
  void begin() {
    for (Vectors* field : {&system.residual_vector, &system.search, &system.image})
      field->resize(system.change.size());
    packed_x.resize(4 * state.x.size()), packed_p.resize(4 * state.x.size());
    for_batches([&](std::size_t i) { pack(state.x, i, packed_x); });
  }
  static void pack(const Vectors& a, std::size_t i, PackedVectors& packed) {
    for (std::size_t n = i; n < i + std::size_t(kLanes); n += 8)
      store_packed(packed, n, load_eight(&a.x[n], &a.y[n], &a.z[n]));
  }
  template <class Visit>
  void for_batches(const Visit& visit) {
    parallel_for(
        exec, batch_count(model.rows), [&](std::size_t batch) { visit(batch * std::size_t(kLanes)); },
        kChunkSize);
  }

  /// r ← find(first vertex) and z ← D⁻¹ r, with both sums.
  template <class Find>
  void set_residual(const Find& find) {
    const std::array<double, 2> sums = sums_of_batches<2>(exec, model, [&](std::size_t i) {
      const Lanes3 r = find(i), z = inverse_diagonal<Lanes>(sheet, i) * r;
      store(system.residual_vector, i, r), store(system.previous, i, z);
      const Lanes rz_i = dot(r, z);
      return std::array{stop.by_diagonal ? rz_i : dot(r, r), rz_i};
    });
    residual2 = sums[0], rz = sums[1];
  }
  /// Adds the coarse correction to z.
  void precondition(bool two_level) {
    if (!two_level) return;
    add_coarse_correction(exec, model, state, system.two_level, system.residual_vector, system.previous);
    rz = sum_batches(exec, model, [&](std::size_t i) {
      return dot(load(system.residual_vector, i), load(system.previous, i));
    });
  }
  /// p ← z + beta p
  void set_search(double beta) {
    for_batches([&](std::size_t i) {
      const Lanes3 z = load(system.previous, i);
      const Lanes3 p = beta == 0 ? z : z + load(system.search, i) * all_lanes(float(beta));
      store(system.search, i, p);
      pack(system.search, i, packed_p);
    });
  }
  /// q ← W p. Returns p · q.
  double multiply() {
    find_impulses(exec, state, system.search, false);
    const EightProduct product{sheet, system.mass_factor, view(std::as_const(system.search)), packed_x.data(),
                               packed_p.data()};
    return sum_batches(exec, model, [&](std::size_t i) {
      Lanes3 contacts{};
      if (state.implicit_contacts.touches(i)) contacts = implicit_contact_terms(state, i);
      Lanes work;
      for (std::size_t n = 0; n < std::size_t(kLanes); n += 8) {
        const auto half = [n](const Lanes& a) { return load_eight(reinterpret_cast<const Real*>(&a) + n); };
        const Eight3 image = product(i + n, {half(contacts.x), half(contacts.y), half(contacts.z)});
        store_eight(&system.image.x[i + n], image.x), store_eight(&system.image.y[i + n], image.y);
        store_eight(&system.image.z[i + n], image.z);
        store_eight(reinterpret_cast<Real*>(&work) + n, dot(EightProduct::load(product.p, i + n), image));
      }
      return work;
    });
  }
};

}  // namespace

void solve_by_conjugate_gradients(const Exec& exec, const Model& model, State& state,
                                  const StopCriterion& stop) {
  // initial residual
  System& system = state.system;
  TURGOR_CHECK(system.change.size() == state.x.size(), "every vertex has a change of velocity");
  Solution s{exec, model, state, stop};
  s.begin();
  find_impulses(exec, state, system.change, true);
  s.set_residual([&](std::size_t i) {
    return residual_forces(s.sheet, state, system.change, load(system.force, i), i);
  });
  // tolerance and preconditioner
  const double force2 = square_of_force(exec, model, s.sheet, stop.by_diagonal);
  TURGOR_CHECK(stop.iterations >= 1, "a solution takes at least one iteration");
  const double enough = stop.residual * stop.residual * force2;
  const bool two_level = stop.two_level && s.residual2 > enough;
  if (two_level && !system.two_level.is_factored) factor_coarse_system(exec, model, state, system.two_level);
  s.precondition(two_level);
  double beta = 0;
  int n = 0;
  for (; n < stop.iterations && s.rz > 0 && s.residual2 > enough; n++) {
    // search direction and its image
    s.set_search(beta);
    const double pq = s.multiply();
    if (!(pq > 0)) break;
    // step along the direction
    const double before = s.rz;
    const Lanes alpha = all_lanes(float(before / pq));
    s.set_residual([&](std::size_t i) {
      store(system.change, i, load(system.change, i) + load(system.search, i) * alpha);
      return load(system.residual_vector, i) - load(system.image, i) * alpha;
    });
    // next preconditioned residual
    if (!(s.residual2 > enough)) continue;
    s.precondition(two_level);
    beta = s.rz / before;
  }
  system.iterations = n, system.residual = force2 == 0 ? 0 : std::sqrt(s.residual2 / force2);
}

}  // namespace turgor::cloth
