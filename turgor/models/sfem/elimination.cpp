#include "turgor/models/sfem/elimination.hpp"

#include <algorithm>
#include <numeric>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/models/sfem/dissection.hpp"

namespace turgor::sfem {

namespace {

std::vector<int> inverted(const std::vector<int>& order) {
  TURGOR_CHECK(is_permutation(order, order.size()), "an order is a permutation");
  std::vector<int> position(order.size());
  for (std::size_t p = 0; p < order.size(); p++) position[std::size_t(order[p])] = int(p);
  return position;
}

/// Parent of each position in the elimination tree. [Liu 1990]
std::vector<int> elimination_tree(const BlockMatrix& k, const std::vector<int>& order,
                                  const std::vector<int>& position) {
  std::vector<int> parent(order.size(), -1), top(order.size(), -1);  // `top` shortens paths
  for (int i = 0; i < int(order.size()); i++)
    for (const int other : neighbors(k, order[std::size_t(i)]))
      for (int j = position[std::size_t(other)]; j >= 0 && j < i;) {
        const int next = top[std::size_t(j)];
        top[std::size_t(j)] = i;
        if (next < 0) parent[std::size_t(j)] = i;
        j = next;
      }
  return parent;
}

/// Children before parents, each subtree contiguous.
std::vector<int> postorder(const std::vector<int>& parent) {
  std::vector<int> roots, order, stack;
  // children of each node
  std::vector<std::vector<int>> children(parent.size());
  for (std::size_t j = 0; j < parent.size(); j++)
    (parent[j] < 0 ? roots : children[std::size_t(parent[j])]).push_back(int(j));
  // depth-first traversal
  stack.assign(roots.rbegin(), roots.rend());
  std::vector<std::size_t> next(parent.size(), 0);
  while (!stack.empty()) {
    const auto j = std::size_t(stack.back());
    if (next[j] < children[j].size()) {
      stack.push_back(children[j][next[j]++]);
    } else {
      order.push_back(int(j));
      stack.pop_back();
    }
  }
  TURGOR_CHECK(order.size() == parent.size(), "the tree contains every node once");
  return order;
}

/// Rows below the diagonal in each column of the factor: row i has an entry in every column on the path up
/// the tree from its entries in K.
std::vector<int> column_counts(const BlockMatrix& k, const std::vector<int>& order,
                               const std::vector<int>& position, const std::vector<int>& parent) {
  std::vector<int> count(order.size(), 0), seen(order.size(), -1);
  for (int i = 0; i < int(order.size()); i++) {
    seen[std::size_t(i)] = i;
    for (const int other : neighbors(k, order[std::size_t(i)]))
      for (int j = position[std::size_t(other)]; j < i && seen[std::size_t(j)] != i;
           j = parent[std::size_t(j)]) {
        count[std::size_t(j)]++;
        seen[std::size_t(j)] = i;
      }
  }
  return count;
}

/// Supernodes while they are being united: sizes in nodes.
struct Groups {
  std::vector<int> parent;     // of each group; -1 = root
  std::vector<double> width;   // columns
  std::vector<double> height;  // rows below
  std::vector<double> zeros;   // entries that are stored but zero
  std::vector<int> into;       // the group it was united with; itself = alive
};

/// Columns whose rows are those of the next one and the next itself are one group.
Groups equal_columns(const std::vector<int>& parent, const std::vector<int>& count, std::vector<int>& group) {
  Groups g;
  group.resize(parent.size());
  for (std::size_t j = 0; j < parent.size(); j++) {
    const bool joins = j > 0 && parent[j - 1] == int(j) && count[j - 1] == count[j] + 1;
    if (!joins) g.width.push_back(0);
    g.width.back()++;
    group[j] = int(g.width.size()) - 1;
  }
  const std::size_t groups = g.width.size();
  g.parent.resize(groups), g.height.resize(groups), g.zeros.assign(groups, 0), g.into.resize(groups);
  for (std::size_t j = 0; j < parent.size(); j++) {  // the last column of a group decides
    g.parent[std::size_t(group[j])] = parent[j] < 0 ? -1 : group[std::size_t(parent[j])];
    g.height[std::size_t(group[j])] = count[j];
  }
  std::iota(g.into.begin(), g.into.end(), 0);
  return g;
}

/// Merges small groups with their parents. Small groups make dense products slow, but merging stores zeros.
/// The smaller the groups, the more zeros are accepted.
bool worth_uniting(double width, double zeros, double total) {
  const double share = zeros / total;
  return width <= 8 || (width <= 24 && share < 0.3) || (width <= 64 && share < 0.1) || share < 0.03;
}

void unite_with_parents(Groups& g) {
  for (std::size_t s = 0; s < g.parent.size(); s++) {
    if (g.parent[s] < 0) continue;
    const auto p = std::size_t(g.parent[s]);
    const double width = g.width[s] + g.width[p], total = width * (width + g.height[p]);
    const double added = g.width[s] * (g.width[p] + g.height[p] - g.height[s]);
    const double zeros = g.zeros[s] + g.zeros[p] + added;
    if (!worth_uniting(width, zeros, total)) continue;
    g.into[s] = int(p);
    g.width[p] = width;
    g.zeros[p] = zeros;
  }
}

int alive(Groups& g, int s) {
  while (g.into[std::size_t(s)] != s)
    s = g.into[std::size_t(s)] = g.into[std::size_t(g.into[std::size_t(s)])];
  return s;
}

/// Supernodes of the remaining groups in postorder, and the corresponding order of the columns.
void number_supernodes(Groups& g, const std::vector<int>& group, Elimination& plan) {
  // parents of the remaining groups
  std::vector<int> parent(g.parent.size());
  for (std::size_t s = 0; s < parent.size(); s++) {
    const int into = alive(g, int(s));
    const int above = g.parent[std::size_t(into)];
    parent[s] = into != int(s) ? into : above < 0 ? -1 : alive(g, above);
  }
  // supernodes in postorder
  std::vector<int> supernode(parent.size(), -1);
  for (const int s : postorder(parent))
    if (g.into[std::size_t(s)] == s) {
      supernode[std::size_t(s)] = int(plan.supernodes.size());
      plan.supernodes.push_back({.count = int(g.width[std::size_t(s)])});
    }
  // columns of each supernode, contiguous
  int first = 0;
  for (Supernode& s : plan.supernodes) s.first = first, first += s.count;
  std::vector<int> next, order(plan.order.size());
  for (const Supernode& s : plan.supernodes) next.push_back(s.first);
  plan.supernode_of.resize(order.size());
  for (std::size_t j = 0; j < order.size(); j++) {
    const int s = supernode[std::size_t(alive(g, group[j]))];
    plan.supernode_of[std::size_t(next[std::size_t(s)])] = s;
    order[std::size_t(next[std::size_t(s)]++)] = plan.order[j];
  }
  plan.order = std::move(order);
  plan.position = inverted(plan.order);
}

/// The rows of each supernode: those of K's entries and of its children, below itself.
void find_rows(const BlockMatrix& k, Elimination& plan) {
  std::vector<std::vector<int>> children(plan.supernodes.size());
  std::vector<int> seen(plan.order.size(), -1), found;
  for (std::size_t n = 0; n < plan.supernodes.size(); n++) {
    Supernode& s = plan.supernodes[n];
    found.clear();
    // rows of K's entries and of the children
    const auto add = [&](int position) {
      if (position < s.first + s.count || seen[std::size_t(position)] == int(n)) return;
      seen[std::size_t(position)] = int(n);
      found.push_back(position);
    };
    for (int j = s.first; j < s.first + s.count; j++)
      for (const int other : neighbors(k, plan.order[std::size_t(j)])) add(plan.position[std::size_t(other)]);
    for (const int c : children[n])
      for (const int row : rows_of(plan, plan.supernodes[std::size_t(c)])) add(row);
    // store; the first row gives the parent
    std::sort(found.begin(), found.end());
    s.row_begin = plan.rows.size(), s.row_count = found.size();
    plan.rows.insert(plan.rows.end(), found.begin(), found.end());
    if (found.empty()) continue;
    s.parent = plan.supernode_of[std::size_t(found[0])];
    TURGOR_CHECK(s.parent > int(n), "children come before their parents");
    children[std::size_t(s.parent)].push_back(int(n));
  }
}

void count_cost(Elimination& plan) {
  std::vector<std::size_t> waiting(plan.supernodes.size(), 0);  // numbers that a supernode's children left
  std::size_t held = 0;
  for (std::size_t n = 0; n < plan.supernodes.size(); n++) {
    Supernode& s = plan.supernodes[n];
    const std::size_t width = 3 * std::size_t(s.count), height = 3 * s.row_count;
    s.value_begin = plan.value_count;
    plan.value_count += width * (width + height);
    const auto w = double(width), h = double(height);
    plan.flops += w * w * w / 3 + 2 * w * w * h +
                  w * h * h;  // pivot block; its rows, twice; contribution to the parent
    held += height * height;
    plan.work_count = std::max(plan.work_count, held);
    held -= waiting[n];
    if (s.parent >= 0) waiting[std::size_t(s.parent)] += height * height;
  }
}

}  // namespace

Elimination plan_elimination(const BlockMatrix& k, std::vector<int> order) {
  // A postorder keeps the factor's size and makes the columns of supernodes contiguous.
  Elimination plan;
  const std::vector<int> tree = elimination_tree(k, order, inverted(order));
  for (const int j : postorder(tree)) plan.order.push_back(order[std::size_t(j)]);
  plan.position = inverted(plan.order);
  const std::vector<int> parent = elimination_tree(k, plan.order, plan.position);
  std::vector<int> group;
  Groups groups = equal_columns(parent, column_counts(k, plan.order, plan.position, parent), group);
  unite_with_parents(groups);
  number_supernodes(groups, group, plan);
  find_rows(k, plan);
  count_cost(plan);
  TURGOR_CHECK(all_indices(plan.supernode_of, plan.supernodes.size()),
               "every position belongs to a supernode");
  return plan;
}

std::vector<unsigned char> with_ancestors(const Elimination& plan, std::span<const int> rows) {
  TURGOR_CHECK(all_indices(rows, plan.position.size()), "the rows belong to the matrix");
  std::vector<unsigned char> marked(plan.supernodes.size(), 0);
  for (const int row : rows)
    for (int s = plan.supernode_of[std::size_t(plan.position[std::size_t(row)])];
         s >= 0 && !marked[std::size_t(s)]; s = plan.supernodes[std::size_t(s)].parent)
      marked[std::size_t(s)] = 1;
  return marked;
}

}  // namespace turgor::sfem
