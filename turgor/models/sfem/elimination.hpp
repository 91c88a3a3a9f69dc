// Symbolic factorization for the sparse Cholesky factor: the elimination order, the supernodes (columns with
// the same rows), their tree, and the cost.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace turgor::sfem {

struct BlockMatrix;

/// Columns [first, first + count) of the order, which have the same rows below their diagonal block.
struct Supernode {
  int first = 0, count = 0;
  int parent = -1;            // the supernode of its first row; -1 = none
  std::size_t row_begin = 0;  // its rows in Elimination::rows
  std::size_t row_count = 0;
  std::size_t value_begin = 0;  // its panel in Cholesky::values, column-major
};

/// Everything counts nodes, of three unknowns each.
struct Elimination {
  std::vector<int> order;             // row of K at each position
  std::vector<int> position;          // of each row of K
  std::vector<Supernode> supernodes;  // children before parents
  std::vector<int> rows;              // positions, ascending within a supernode
  std::vector<int> supernode_of;      // of each position
  std::size_t value_count = 0;        // numbers in the factor
  std::size_t work_count = 0;         // numbers held besides while factoring on one thread
  double flops = 0;                   // of the factorization
};

/// The order is refined: supernodes become contiguous, and small ones are united with their parents where
/// that costs few zeros.
Elimination plan_elimination(const BlockMatrix& k, std::vector<int> order);

inline std::span<const int> rows_of(const Elimination& plan, const Supernode& s) {
  return {plan.rows.data() + s.row_begin, s.row_count};
}

/// 1 for the supernodes of these rows of K and for all their ancestors.
std::vector<unsigned char> with_ancestors(const Elimination& plan, std::span<const int> rows);

}  // namespace turgor::sfem
