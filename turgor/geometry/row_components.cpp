#include "turgor/geometry/row_components.hpp"

#include <algorithm>
#include <cstring>

namespace turgor {

namespace {

/// First index in [at, end) of a row with the value, or end.
int find_in(const std::uint8_t* row, int at, int end, int value) {
  const void* found = std::memchr(row + at, value, std::size_t(end - at));
  return found == nullptr ? end : int(static_cast<const std::uint8_t*>(found) - row);
}

/// Representative run of a component (its first run).
int root_of_run(std::vector<CellRun>& runs, int run) {
  while (runs[std::size_t(run)].component != run) {
    int& parent = runs[std::size_t(run)].component;
    parent = runs[std::size_t(parent)].component;
    run = parent;
  }
  return run;
}

/// Joins overlapping runs of two neighboring rows.
void join_rows(std::vector<CellRun>& runs, int a, int a_end, int b, int b_end) {
  while (a < a_end && b < b_end) {
    const CellRun &first = runs[std::size_t(a)], &second = runs[std::size_t(b)];
    if (first.begin < second.end && second.begin < first.end) {
      const int root_a = root_of_run(runs, a), root_b = root_of_run(runs, b);
      runs[std::size_t(std::max(root_a, root_b))].component = std::min(root_a, root_b);
    }
    if (first.end < second.end)
      a++;
    else
      b++;
  }
}

/// Numbers the components from 0.
void number_components(RowComponents& found) {
  std::vector<int> number(found.runs.size());
  for (int r = 0; r < int(found.runs.size()); r++) {
    CellRun& run = found.runs[std::size_t(r)];
    const bool is_root = run.component == r;
    number[std::size_t(r)] = is_root ? int(found.sizes.size()) : number[std::size_t(run.component)];
    if (is_root) found.sizes.push_back(0);
    run.component = number[std::size_t(r)];  // roots precede the other runs of their component
    found.sizes[std::size_t(run.component)] += std::size_t(run.end - run.begin);
  }
}

}  // namespace

int RowComponents::largest() const {
  return sizes.empty() ? -1 : int(std::max_element(sizes.begin(), sizes.end()) - sizes.begin());
}

RowComponents row_components(const std::vector<std::uint8_t>& mask, Int3 size) {
  RowComponents found;
  std::vector<int> row_begin;  // first run of each row
  for (int k = 0; k < size.z; k++)
    for (int j = 0; j < size.y; j++) {
      row_begin.push_back(int(found.runs.size()));
      const std::uint8_t* row =
          mask.data() + (std::size_t(k) * std::size_t(size.y) + std::size_t(j)) * std::size_t(size.x);
      for (int at = find_in(row, 0, size.x, 1); at < size.x;) {
        const int end = find_in(row, at, size.x, 0);
        found.runs.push_back({at, end, j, k, int(found.runs.size())});
        at = find_in(row, end, size.x, 1);
      }
    }
  row_begin.push_back(int(found.runs.size()));
  const auto join = [&](int a, int b) {
    join_rows(found.runs, row_begin[std::size_t(a)], row_begin[std::size_t(a) + 1], row_begin[std::size_t(b)],
              row_begin[std::size_t(b) + 1]);
  };
  for (int k = 0; k < size.z; k++)
    for (int j = 0; j < size.y; j++) {
      const int row = k * size.y + j;
      if (j > 0) join(row - 1, row);
      if (k > 0) join(row - size.y, row);
    }
  for (int r = 0; r < int(found.runs.size()); r++)
    found.runs[std::size_t(r)].component = root_of_run(found.runs, r);
  number_components(found);
  return found;
}

}  // namespace turgor
