// Multifrontal factorization. The front of a supernode contains its entries of K and the contributions of its
// children. After elimination of its own columns, the rest is passed to its parent. [Duff, Reid 1983]
#include "turgor/models/sfem/cholesky.hpp"

#include <algorithm>
#include <atomic>
#include <mutex>
#include <string>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/models/sfem/dense_cholesky.hpp"
#include "turgor/models/sfem/sfem.hpp"

namespace turgor::sfem {

namespace {

/// Subtrees with less than this fraction of the work are factored by one thread each, the rest by all threads
/// together. The division, and so the result, does not depend on the number of threads.
constexpr double kSubtreeWork = 1.0 / 48;

struct Factoring {
  const BlockMatrix& k;
  Cholesky& factor;
  std::vector<std::vector<double>> rest;   // of each supernode, until used by its parent
  std::vector<std::vector<int>> children;  // of each supernode, ascending
  std::vector<double> flops;               // of each supernode
  std::atomic<int> bad_position{-1};       // smallest position without a positive pivot
  const Progress& progress;
  std::mutex progress_mutex;
  double done = 0;
};

double flops_of(const Supernode& s) {
  const double w = 3.0 * s.count, h = 3.0 * double(s.row_count);
  return w * w * w / 3 + 2 * w * w * h + w * h * h;
}

/// Addresses of a front's entries, in its panel or in its rest.
struct FrontView {
  const Elimination& plan;
  const Supernode& s;
  Front front;

  /// Index of a position within the front, in nodes.
  std::size_t local(int position) const {
    if (position < s.first + s.count) return std::size_t(position - s.first);
    const auto rows = rows_of(plan, s);
    return std::size_t(s.count) +
           std::size_t(std::lower_bound(rows.begin(), rows.end(), position) - rows.begin());
  }
  /// First entry of a 3×3 block and the distance of its columns; row ≥ column.
  std::pair<double*, std::size_t> block(std::size_t row, std::size_t column) const {
    const std::size_t height = front.width + front.height;
    if (3 * column < front.width) return {front.panel + 3 * column * height + 3 * row, height};
    return {front.rest + (3 * column - front.width) * front.height + 3 * row - front.width, front.height};
  }
};

void add_stiffness(const BlockMatrix& k, const FrontView& view) {
  const Elimination& plan = view.plan;
  for (int p = view.s.first; p < view.s.first + view.s.count; p++) {
    const auto row = std::size_t(plan.order[std::size_t(p)]);
    for (std::size_t b = k.row_begin[row]; b < k.row_begin[row + 1]; b++) {
      const int q = plan.position[std::size_t(k.column[b])];
      if (q < p) continue;
      // Block (p, q) of K is the transpose of the block (q, p) of the lower half.
      const auto [to, stride] = view.block(view.local(q), std::size_t(p - view.s.first));
      for (std::size_t i = 0; i < 9; i++) to[i / 3 * stride + i % 3] += k.value[9 * b + i];
    }
  }
}

void add_child(const Elimination& plan, const Supernode& child, const std::vector<double>& rest,
               const FrontView& view) {
  const auto rows = rows_of(plan, child);
  const std::size_t height = 3 * rows.size();
  TURGOR_CHECK(rest.size() == height * height, "a child contributes to all of its rows");
  std::vector<std::size_t> local(rows.size());
  for (std::size_t i = 0; i < rows.size(); i++) local[i] = view.local(rows[i]);
  for (std::size_t c = 0; c < rows.size(); c++)
    for (std::size_t axis = 0; axis < 3; axis++) {
      const double* from = &rest[(3 * c + axis) * height];
      for (std::size_t r = c; r < rows.size(); r++) {
        const auto [block, stride] = view.block(local[r], local[c]);
        double* to = block + axis * stride;
        for (std::size_t i = 0; i < 3; i++) to[i] += from[3 * r + i];
      }
    }
}

void report_progress(Factoring& f, double flops) {
  if (!f.progress) return;
  const std::lock_guard lock(f.progress_mutex);
  f.done += flops;
  f.progress(f.done / std::max(f.factor.plan.flops, 1.0));
}

void factor_supernode(const Exec& exec, Factoring& f, int n) {
  const Elimination& plan = f.factor.plan;
  const Supernode& s = plan.supernodes[std::size_t(n)];
  std::vector<double>& rest = f.rest[std::size_t(n)];
  const std::size_t width = 3 * std::size_t(s.count), height = 3 * s.row_count;
  // assemble the front: entries of K, contributions of children
  rest.assign(height * height, 0);
  const FrontView view{plan, s, {width, height, &f.factor.values[s.value_begin], rest.data()}};
  add_stiffness(f.k, view);
  for (const int c : f.children[std::size_t(n)]) {
    add_child(plan, plan.supernodes[std::size_t(c)], f.rest[std::size_t(c)], view);
    f.rest[std::size_t(c)] = std::vector<double>();  // {} would keep the memory
  }
  // factor; keep the smallest bad position of all threads
  if (const int bad = factor_front(exec, view.front); bad >= 0) {
    const int position = s.first + bad / 3;
    for (int known = f.bad_position;
         (known < 0 || position < known) && !f.bad_position.compare_exchange_weak(known, position);) {
    }
  }
  report_progress(f, flops_of(s));
}

/// First and last supernode of every subtree for one thread, those with most work first, and the supernodes
/// above them.
struct Schedule {
  std::vector<std::pair<int, int>> subtrees;
  std::vector<int> above;
};

Schedule make_schedule(const Elimination& plan) {
  std::vector<double> work;
  std::vector<int> first;  // of each supernode's subtree, which is contiguous
  for (std::size_t n = 0; n < plan.supernodes.size(); n++) first.push_back(int(n));
  for (const Supernode& s : plan.supernodes) work.push_back(flops_of(s));
  for (std::size_t n = 0; n < plan.supernodes.size(); n++)
    if (const int p = plan.supernodes[n].parent; p >= 0) {
      work[std::size_t(p)] += work[n];
      first[std::size_t(p)] = std::min(first[std::size_t(p)], first[n]);
    }
  const double most = plan.flops * kSubtreeWork;
  Schedule schedule;
  for (std::size_t n = 0; n < plan.supernodes.size(); n++) {
    const int p = plan.supernodes[n].parent;
    if (work[n] > most)
      schedule.above.push_back(int(n));
    else if (p < 0 || work[std::size_t(p)] > most)
      schedule.subtrees.emplace_back(first[n], int(n));
  }
  std::stable_sort(schedule.subtrees.begin(), schedule.subtrees.end(), [&](const auto& a, const auto& b) {
    return work[std::size_t(a.second)] > work[std::size_t(b.second)];
  });
  return schedule;
}

}  // namespace

Result<Cholesky> factorize(const Exec& exec, const BlockMatrix& k, Elimination plan,
                           std::span<const int> vertex, const Progress& progress) {
  Cholesky factor{std::move(plan), {}};
  factor.values.assign(factor.plan.value_count, 0);
  const std::vector<Supernode>& supernodes = factor.plan.supernodes;
  Factoring f{.k = k,
              .factor = factor,
              .rest = {},
              .children = {},
              .flops = {},
              .progress = progress,
              .progress_mutex = {}};
  TURGOR_CHECK(k.row_begin.size() == factor.plan.order.size() + 1 &&
                   is_permutation(factor.plan.order, factor.plan.order.size()),
               "the elimination order is a permutation of the rows");
  f.rest.resize(supernodes.size()), f.children.resize(supernodes.size());
  for (std::size_t n = 0; n < supernodes.size(); n++)
    if (supernodes[n].parent >= 0) f.children[std::size_t(supernodes[n].parent)].push_back(int(n));

  const Schedule schedule = make_schedule(factor.plan);
  const Exec alone(1);
  parallel_for(exec, schedule.subtrees.size(), [&](std::size_t t) {
    const auto [first, last] = schedule.subtrees[t];
    for (int n = first; n <= last && f.bad_position < 0; n++) factor_supernode(alone, f, n);
  });
  for (const int n : schedule.above)
    if (f.bad_position < 0) factor_supernode(exec, f, n);
  if (f.bad_position < 0) return factor;
  const int row = factor.plan.order[std::size_t(f.bad_position)];
  return Error{"the stiffness is not positive definite: a motion of vertex " +
               std::to_string(vertex[std::size_t(row)]) + " is resisted by nothing"};
}

}  // namespace turgor::sfem
