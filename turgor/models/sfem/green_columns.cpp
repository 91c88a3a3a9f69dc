// Columns of Green's functions from the stored factor, when the dense store would be too large.
#include <algorithm>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/core/sort_unique.hpp"
#include "turgor/models/sfem/green.hpp"

namespace turgor::sfem {

namespace {

/// Slots without a column, each once; fixed vertices have none.
std::vector<int> missing_slots(const Model& model, std::span<const int> vertices) {
  const Green& green = model.green;
  std::vector<int> slots;
  for (const int v : vertices) {
    if (model.free_node[std::size_t(v)] < 0) continue;
    const int slot = green.slot[std::size_t(v)];
    TURGOR_ASSERT(slot >= 0, "a column of Green's functions is fetched for a vertex that is not kept");
    if (!has_column(green, slot)) slots.push_back(slot);
  }
  sort_unique(slots);
  return slots;
}

std::vector<int> rows_of_nodes(const Model& model, std::span<const int> vertices) {
  std::vector<int> rows;
  for (const int v : vertices) rows.push_back(model.free_node[std::size_t(v)]);
  return rows;
}

/// Symmetrizes the block of a node with itself, which is slightly asymmetric by rounding.
void make_symmetric(FetchedColumns& fetched, std::size_t n, std::size_t side) {
  float* block = &fetched.values[n][3 * std::size_t(fetched.slots[n])];
  for (const std::size_t i : {1, 2})
    for (std::size_t j = 0; j < i; j++) block[i * side + j] = block[j * side + i];
}

}  // namespace

FetchedColumns compute_columns(const Exec& exec, const Model& model, std::span<const int> vertices) {
  constexpr std::size_t kFew = 8, kMany = 16;  // solved together; a tool waits for a few
  const Green& green = model.green;
  TURGOR_ASSERT(model.factor.has_value(), "columns are computed from the factor");
  const Elimination& plan = model.factor->plan;
  FetchedColumns fetched{missing_slots(model, vertices), {}};
  const std::size_t count = fetched.slots.size(), units_at_once = count < 8 * kFew ? kFew : kMany;
  fetched.values.resize(count);
  const std::vector<int> kept_rows = rows_of_nodes(model, green.nodes);
  const std::vector<unsigned char> wanted = with_ancestors(plan, kept_rows);
  parallel_for(exec, (count + units_at_once - 1) / units_at_once, [&](std::size_t block) {
    const std::size_t first = block * units_at_once, units = std::min(units_at_once, count - first);
    std::vector<int> rows;
    for (std::size_t i = 0; i < units; i++) rows.push_back(kept_rows[std::size_t(fetched.slots[first + i])]);
    UnitSolutions solved;
    solve_units(*model.factor, rows, wanted, 0, solved);
    for (std::size_t c = 0; c < 3 * units; c++) {
      std::vector<float>& values = fetched.values[first + c / 3];
      values.reserve(9 * kept_rows.size());
      for (const int row : kept_rows)
        for (std::size_t i = 0; i < 3; i++)
          values.push_back(float(solved.row(plan.position[std::size_t(row)])[i * solved.columns + c]));
    }
    for (std::size_t n = first; n < first + units; n++) make_symmetric(fetched, n, 3 * green.nodes.size());
  });
  return fetched;
}

void add_columns(Green& green, FetchedColumns fetched) {
  TURGOR_CHECK(
      fetched.values.size() == fetched.slots.size() && all_indices(fetched.slots, green.columns.size()),
      "fetched columns are those of kept nodes");
  for (std::size_t i = 0; i < fetched.slots.size(); i++)
    green.columns[std::size_t(fetched.slots[i])] = std::move(fetched.values[i]);
}

void fetch_columns(const Exec& exec, Model& model, const std::vector<int>& vertices) {
  add_columns(model.green, compute_columns(exec, model, vertices));
}

std::size_t column_bytes(const Green& green) {
  std::size_t bytes = 0;
  for (const std::vector<float>& column : green.columns) bytes += sizeof(float) * column.capacity();
  return bytes;
}

void keep_columns(Green& green, std::span<const int> vertices) {
  TURGOR_CHECK(is_sorted_unique(vertices), "vertices with columns ascend");
  for (std::size_t slot = 0; slot < green.columns.size(); slot++)
    if (!std::binary_search(vertices.begin(), vertices.end(), green.nodes[slot]))
      green.columns[slot] = std::vector<float>();  // {} would keep the memory
}

CheckColumns full_columns(const Model& model, std::span<const int> vertices) {
  const Elimination& plan = model.factor->plan;
  const std::vector<unsigned char> all(plan.supernodes.size(), 1);
  UnitSolutions solved;
  solve_units(*model.factor, rows_of_nodes(model, vertices), all, 0, solved);
  CheckColumns columns{{vertices.begin(), vertices.end()}, {}};
  for (std::size_t c = 0; c < solved.columns; c++)
    for (const int position : plan.position)
      for (std::size_t i = 0; i < 3; i++)
        columns.values.push_back(solved.row(position)[i * solved.columns + c]);
  return columns;
}

}  // namespace turgor::sfem
