// Dense store. Columns are solved in the order of elimination, each only down to its own position. The part
// before it is known from other columns, because Ξ is symmetric. That halves the work, and values that should
// be equal are equal.
#include "turgor/models/sfem/green.hpp"

#include <algorithm>
#include <atomic>
#include <mutex>

#include "turgor/core/assert.hpp"
#include "turgor/models/sfem/dissection.hpp"
#include "turgor/models/sfem/gpu_green.hpp"
#include "turgor/models/sfem/stored_permutation.hpp"

namespace turgor::sfem {

namespace {

constexpr std::size_t kUnits = 32;  // nodes whose columns are solved together

Elimination make_plan(const Model& model) {
  return plan_elimination(model.stiffness, nested_dissection(model.stiffness));
}

/// Operations for all columns, each solved down to its own position.
double count_solve_flops(const Elimination& plan, const StoredPermutation& stored) {
  const std::vector<unsigned char> wanted = with_ancestors(plan, stored.rows);
  // cost of the paths up and down from each supernode
  std::vector<double> down(plan.supernodes.size() + 1, 0), up(plan.supernodes.size(), 0);
  for (std::size_t n = plan.supernodes.size(); n-- > 0;) {
    const Supernode& s = plan.supernodes[n];
    const double width = 3.0 * s.count, rows = 2 * width * 3 * double(s.row_count);
    down[n] = down[n + 1] + (wanted[n] ? rows : 0);
    up[n] = rows + 2 * width * width + (s.parent >= 0 ? up[std::size_t(s.parent)] : 0);
  }
  // sum over the stored nodes
  double flops = 0;
  for (const int position : stored.position) {
    const auto n = std::size_t(plan.supernode_of[std::size_t(position)]);
    flops += 3 * (up[n] + down[n]);
  }
  return flops;
}

GreenCost cost_of(const Model& model, const Elimination& plan) {
  const std::size_t side = 3 * model.green.nodes.size();
  const std::size_t size = model.params.precision == Precision::kSingle ? sizeof(float) : sizeof(double);
  GreenCost cost;
  cost.factor_bytes = sizeof(double) * plan.value_count + sizeof(int) * plan.rows.size();
  cost.store_bytes = size * side * side;
  const std::size_t columns = 3 * plan.order.size() * 3 * kUnits;
  cost.work_bytes = sizeof(double) * std::max(plan.work_count, columns);
  cost.factor_flops = plan.flops;
  cost.solve_flops = count_solve_flops(plan, stored_permutation(model, plan));
  return cost;
}

std::string gigabytes(std::size_t bytes) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g GB", double(bytes) * 1e-9);
  return text;
}

Status check_memory(const Model& model, const GreenCost& cost, int threads, std::size_t limit) {
  const std::size_t work = cost.work_bytes * std::size_t(threads);
  const std::size_t needed = cost.factor_bytes + cost.store_bytes + work;
  if (needed <= limit) return Done{};
  return Error{"Green's functions of " + std::to_string(model.green.nodes.size()) + " nodes need " +
               gigabytes(needed) + " of memory (store " + gigabytes(cost.store_bytes) + ", factor " +
               gigabytes(cost.factor_bytes) + "), allowed are " + gigabytes(limit) +
               ": allow more, take a coarser mesh, a smaller depth of touch or single precision, or fetch "
               "columns on demand"};
}

template <class T>
struct Store {
  std::vector<T>& values;
  std::size_t side;

  T& at(std::size_t row, std::size_t column) const { return values[column * side + row]; }
};

/// Copies one block of solved columns. Rows before each column's own position are mirrored later.
template <class T>
void store_columns(const StoredPermutation& stored, std::span<const int> slots, const UnitSolutions& solved,
                   const Store<T>& store) {
  TURGOR_CHECK(!slots.empty(), "at least one column is stored");
  const int first_position = stored.position[std::size_t(slots[0])];
  for (std::size_t r = 0; r < stored.position.size(); r++) {
    if (stored.position[r] < first_position) continue;
    const double* row = solved.row(stored.position[r]);
    for (std::size_t c = 0; c < slots.size(); c++) {
      const auto slot = std::size_t(slots[c]);
      if (stored.position[slot] > stored.position[r]) break;
      for (std::size_t j = 0; j < 3; j++)
        for (std::size_t i = 0; i < 3; i++)
          store.at(3 * r + i, 3 * slot + j) = T(row[i * solved.columns + 3 * c + j]);
    }
  }
  for (const int slot : slots)
    for (const auto& [i, j] : {std::pair{0, 1}, {0, 2}, {1, 2}})
      store.at(std::size_t(3 * slot + i), std::size_t(3 * slot + j)) =
          store.at(std::size_t(3 * slot + j), std::size_t(3 * slot + i));
}

template <class T>
void mirror_block(const Store<T>& store, std::size_t known_row, std::size_t known_column) {
  for (std::size_t j = 0; j < 3; j++)
    for (std::size_t i = 0; i < 3; i++)
      store.at(3 * known_column + j, 3 * known_row + i) = store.at(3 * known_row + i, 3 * known_column + j);
}

/// Mirrors the solved half into the other one, tile by tile, so that both stay in the cache.
template <class T>
void mirror(const Exec& exec, const StoredPermutation& stored, const Store<T>& store) {
  constexpr std::size_t kTile = 32;
  const std::size_t nodes = stored.position.size(), tiles = (nodes + kTile - 1) / kTile;
  parallel_for(exec, tiles, [&](std::size_t tile) {
    for (std::size_t other = tile; other < tiles; other++)
      for (std::size_t a = tile * kTile; a < std::min(nodes, (tile + 1) * kTile); a++)
        for (std::size_t b = std::max(a + 1, other * kTile); b < std::min(nodes, (other + 1) * kTile); b++)
          if (stored.position[a] > stored.position[b])
            mirror_block(store, a, b);
          else
            mirror_block(store, b, a);
  });
}

template <class T>
void fill_store(const Exec& exec, const Model& model, std::vector<T>& values, const Progress& progress) {
  TURGOR_ASSERT(model.factor.has_value(), "Green's functions need the factor");
  const StoredPermutation stored = stored_permutation(model, model.factor->plan);
  const std::size_t nodes = stored.position.size(), blocks = (nodes + kUnits - 1) / kUnits;
  const Store<T> store{values, 3 * nodes};
  const std::vector<unsigned char> wanted = with_ancestors(model.factor->plan, stored.rows);
  std::atomic<std::size_t> done{0};
  exec.run_ranges(blocks, 1, [&](std::size_t begin, std::size_t end) {
    UnitSolutions solved;
    for (std::size_t block = begin; block < end; block++) {
      const std::size_t first = block * kUnits;
      const std::span<const int> slots(&stored.by_position[first], std::min(kUnits, nodes - first));
      std::vector<int> rows;
      for (const int slot : slots) rows.push_back(stored.rows[std::size_t(slot)]);
      solve_units(*model.factor, rows, wanted, stored.position[std::size_t(slots[0])], solved);
      store_columns(stored, slots, solved, store);
      if (progress) progress(double(++done) / double(blocks));
    }
  });
  mirror(exec, stored, store);
}

Status factorize_as(const Exec& exec, Model& model, Elimination plan, const Progress& progress) {
  Result<Cholesky> factor = factorize(exec, model.stiffness, std::move(plan), model.vertex, progress);
  if (!factor) return factor.error();
  model.factor = std::move(*factor);
  return Done{};
}

/// Vertices with full check columns, spread over the stored ones.
std::vector<int> check_vertices(const Green& green) {
  const std::size_t count = std::min<std::size_t>(3, green.nodes.size());
  std::vector<int> vertices;
  for (std::size_t i = 0; i < count; i++)
    vertices.push_back(green.nodes[(2 * i + 1) * green.nodes.size() / (2 * count)]);
  return vertices;
}

void clear_store(Green& green) {
  // {} would keep the memory
  green.single_values = std::vector<float>();
  green.double_values = std::vector<double>();
  green.columns = std::vector<std::vector<float>>();
  green.check = {};
  green.checksum = 0;
}

}  // namespace

GreenCost green_cost(const Model& model) {
  return cost_of(model, model.factor ? model.factor->plan : make_plan(model));
}

Status factorize(const Exec& exec, Model& model, const Progress& progress) {
  return model.factor ? Status(Done{}) : factorize_as(exec, model, make_plan(model), progress);
}

Status compute_green(const Exec& exec, Model& model, std::size_t memory_limit, const Progress& progress,
                     const Gpu* gpu) {
  Elimination plan = model.factor ? Elimination{} : make_plan(model);
  const GreenCost cost = cost_of(model, model.factor ? model.factor->plan : plan);
  if (const Status fits = check_memory(model, cost, exec.threads(), memory_limit); !fits) return fits;
  const double factor_share = cost.factor_flops / (cost.factor_flops + cost.solve_flops);
  const auto scaled = [&](double from, double to) -> Progress {
    if (!progress) return {};
    return [&progress, from, to](double done) { progress(from + (to - from) * done); };
  };
  if (!model.factor) {
    const Status s = factorize_as(exec, model, std::move(plan), scaled(0, factor_share));
    if (!s) return s;
  }

  Green& green = model.green;
  clear_store(green);
  const std::size_t side = 3 * green.nodes.size();
  const bool single = model.params.precision == Precision::kSingle;
  green.single_values.resize(single ? side * side : 0);
  green.double_values.resize(single ? 0 : side * side);
  const Progress filled = scaled(factor_share, 1);
  if (gpu != nullptr) {
    if (const Status filled_status = fill_green_on_device(*gpu, model, filled); !filled_status)
      return filled_status;
  } else if (single) {
    fill_store(exec, model, green.single_values, filled);
  } else {
    fill_store(exec, model, green.double_values, filled);
  }
  green.check = full_columns(model, check_vertices(green));
  green.checksum = checksum(green);
  return Done{};
}

Status prepare_columns(const Exec& exec, Model& model, const Progress& progress) {
  if (const Status s = factorize(exec, model, progress); !s) return s;
  clear_store(model.green);
  model.green.columns.resize(model.green.nodes.size());
  return Done{};
}

}  // namespace turgor::sfem
