#include "turgor/contact/dense_system.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/contact/coulomb_steps.hpp"
#include "turgor/core/assert.hpp"

namespace turgor::contact {

namespace {

/// Largest absolute value of the entries [begin, end) of a column; both are multiples of kLanes.
double largest_of(const double* column, int begin, int end) {
  double largest[kLanes] = {};
  for (int i = begin; i < end; i += kLanes) {
    TURGOR_LANES
    for (int q = 0; q < kLanes; q++) largest[q] = std::max(largest[q], std::abs(column[i + q]));
  }
  return *std::max_element(largest, largest + kLanes);
}

double largest_diagonal(const DenseSystem& s) {
  double largest = 0;
  for (int k = 0; k < s.n; k++) largest = std::max(largest, std::abs(s.column(k)[k]));
  return largest;
}

void exchange_rows(const DenseSystem& s, int a, int b) {
  for (int j = 0; j < s.n; j++) std::swap(s.column(j)[a], s.column(j)[b]);
  std::swap(s.rhs[a], s.rhs[b]);
}

/// Row of the pivot of column k: k itself, unless another entry below it is more than ten times as large.
int pivot_row(const DenseSystem& s, int k) {
  constexpr double kEnough = 0.1;  // of the largest entry
  const double* column = s.column(k);
  const int lane = k / kLanes * kLanes + kLanes;
  // largest entry below: to the end of the lane, then in whole lanes
  double largest = 0;
  for (int i = k; i < std::min(lane, s.n); i++) largest = std::max(largest, std::abs(column[i]));
  if (lane < s.n) largest = std::max(largest, largest_of(column, lane, padded(s.n)));
  if (std::abs(column[k]) >= kEnough * largest) return k;
  return int(std::find_if(column + k, column + s.n, [=](double a) { return std::abs(a) == largest; }) -
             column);
}

/// target −= factor · column in the rows [begin, end).
void subtract(const double* column, double factor, int begin, int end, double* target) {
  TURGOR_LANES
  for (int i = begin; i < end; i++) target[i] -= factor * column[i];
}

/// Eliminates the columns [first, last) from each other and copies their factors of the rows behind `last` to
/// the workspace. False if a pivot vanishes.
bool factorize_panel(const DenseSystem& s, int first, int last, double smallest) {
  const int end = padded(s.n);
  for (int k = first; k < last; k++) {
    const int row = pivot_row(s, k);
    double* pivot = s.column(k);
    if (!(std::abs(pivot[row]) > smallest)) return false;
    if (row != k) exchange_rows(s, k, row);
    // factors replace the column below the pivot
    const double inverse = 1 / pivot[k];
    for (int i = k + 1; i < end; i++) pivot[i] *= inverse;
    for (int j = k + 1; j < last; j++) subtract(pivot, s.column(j)[k], k + 1, end, s.column(j));
  }
  // factors of the rows of the panel and above are zero, so that whole lanes can be processed
  const int lane = last / kLanes * kLanes;
  for (int k = first; k < last; k++) {
    double* factors = s.factors + (k - first) * s.stride;
    std::fill(factors + lane, factors + last, 0.0);
    std::copy(s.column(k) + last, s.column(k) + end, factors + last);
  }
  return true;
}

/// Row of the panel at a target column: solves with the unit triangle of the panel.
void solve_triangle(const DenseSystem& s, int first, int last, double* target) {
  for (int k = first; k < last; k++)
    for (int i = k + 1; i < last; i++) target[i] -= s.column(k)[i] * target[k];
}

/// Subtracts a panel of kPanel columns from two target columns in the rows [begin, end), whole lanes.
void subtract_panel(const double* f, int stride, const double* u, const double* v, int begin, int end,
                    double* a, double* b) {
  const double *f0 = f, *f1 = f0 + stride, *f2 = f1 + stride, *f3 = f2 + stride;
  const double u0 = u[0], u1 = u[1], u2 = u[2], u3 = u[3], v0 = v[0], v1 = v[1], v2 = v[2], v3 = v[3];
  TURGOR_LANES
  for (int i = begin; i < end; i++) {
    const double l0 = f0[i], l1 = f1[i], l2 = f2[i], l3 = f3[i];
    a[i] = a[i] - l0 * u0 - l1 * u1 - l2 * u2 - l3 * u3;
    b[i] = b[i] - l0 * v0 - l1 * v1 - l2 * v2 - l3 * v3;
  }
}

/// Eliminates a panel from all columns behind it and from the right-hand side.
void eliminate_panel(const DenseSystem& s, int first, int last) {
  const int begin = last / kLanes * kLanes, end = padded(s.n);
  const auto target = [&](int j) { return j < s.n ? s.column(j) : s.rhs; };
  for (int j = last; j <= s.n; j++) solve_triangle(s, first, last, target(j));
  int j = last;
  // pairs of columns
  if (last - first == DenseSystem::kPanel)
    for (; j + 1 <= s.n; j += 2) {
      double u[DenseSystem::kPanel], v[DenseSystem::kPanel];
      std::copy_n(target(j) + first, DenseSystem::kPanel, u);
      std::copy_n(target(j + 1) + first, DenseSystem::kPanel, v);
      subtract_panel(s.factors, s.stride, u, v, begin, end, target(j), target(j + 1));
    }
  // last column, or those behind an incomplete panel
  for (; j <= s.n; j++)
    for (int k = first; k < last; k++)
      subtract(s.factors + (k - first) * s.stride, target(j)[k], begin, end, target(j));
}

}  // namespace

bool solve_in_place(const DenseSystem& s) {
  TURGOR_CHECK(s.n >= 0 && s.n <= s.stride, "a dense system fits its storage");
  constexpr double kSingular = 1e-13;
  const double smallest = kSingular * largest_diagonal(s);
  // forward elimination
  for (int first = 0; first < s.n; first += DenseSystem::kPanel) {
    const int last = std::min(first + DenseSystem::kPanel, s.n);
    if (!factorize_panel(s, first, last, smallest)) return false;
    eliminate_panel(s, first, last);
  }
  // back substitution
  for (int k = s.n - 1; k >= 0; k--) {
    s.rhs[k] /= s.column(k)[k];
    subtract(s.column(k), s.rhs[k], 0, k, s.rhs);
  }
  return true;
}

}  // namespace turgor::contact
