#include "turgor/models/sfem/dissection.hpp"

#include <mutex>
#include <numeric>

#include <metis.h>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"

namespace turgor::sfem {

std::vector<int> nested_dissection(const BlockMatrix& k) {
  auto count = idx_t(k.row_begin.size() - 1);
  std::vector<int> order(static_cast<std::size_t>(count));
  std::iota(order.begin(), order.end(), 0);
  std::vector<idx_t> first{0}, others;
  for (const int row : order) {
    for (const int other : neighbors(k, row))
      if (other != row) others.push_back(other);
    first.push_back(idx_t(others.size()));
  }
  if (others.empty()) return order;
  std::vector<idx_t> permuted(order.size()), inverse_order(order.size());
  idx_t options[METIS_NOPTIONS];
  METIS_SetDefaultOptions(options);
  static std::mutex one_at_a_time;  // METIS uses std::rand, which is global
  const std::lock_guard lock(one_at_a_time);
  const int status = METIS_NodeND(&count, first.data(), others.data(), nullptr, options, permuted.data(),
                                  inverse_order.data());
  TURGOR_ASSERT(status == METIS_OK, "METIS orders every graph without an error");
  order.assign(permuted.begin(), permuted.end());
  TURGOR_CHECK(is_permutation(order, order.size()), "the elimination order is a permutation of the rows");
  return order;
}

}  // namespace turgor::sfem
