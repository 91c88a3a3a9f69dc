// Newton steps on the equations of the sites that bear force. Unknowns are forces in the frames of their
// sites. A sticking site obeys c = 0. A sliding site with slip direction d = c_t/|c_t| obeys
//
//     c_n = 0,    λ_t + μ λ_n d = 0,    δd = (I − d dᵀ) δc_t/|c_t|
#include <algorithm>
#include <cmath>

#include "turgor/contact/coulomb_steps.hpp"
#include "turgor/core/assert.hpp"

namespace turgor::contact {

namespace {

/// Linear system of one step, stored in the work arrays of FrictionalContactProblem. Rows behind the last one
/// are zero.
struct System {
  double* a;  // column-major
  double* rhs;
  double* factors;  // of the rows below a pivot
  int n = 0, stride = 0;

  double* column(int j) const { return a + std::size_t(j) * std::size_t(stride); }
};

/// Largest absolute value of the entries [begin, end) of a column; both are multiples of kLanes.
double largest_of(const double* column, int begin, int end) {
  double largest[kLanes] = {};
  for (int i = begin; i < end; i += kLanes) {
    TURGOR_LANES
    for (int q = 0; q < kLanes; q++) largest[q] = std::max(largest[q], std::abs(column[i + q]));
  }
  return *std::max_element(largest, largest + kLanes);
}

double largest_entry(const System& s) {
  double largest = 0;
  for (int j = 0; j < s.n; j++) largest = std::max(largest, largest_of(s.column(j), 0, padded(s.n)));
  return largest;
}

void exchange_rows(const System& s, int a, int b) {
  for (int j = 0; j < s.n; j++) std::swap(s.column(j)[a], s.column(j)[b]);
  std::swap(s.rhs[a], s.rhs[b]);
}

/// Eliminates the pivot's row from all columns behind it. The factors of rows above are zero, so that whole
/// lanes can be processed.
void eliminate(const System& s, int k) {
  const int begin = k / kLanes * kLanes, end = padded(s.n);
  // factors of the rows below the pivot
  const double* pivot = s.column(k);
  const double inverse = 1 / pivot[k];
  for (int i = begin; i < end; i++) s.factors[i] = i > k ? pivot[i] * inverse : 0;
  // update the columns right of the pivot
  for (int j = k + 1; j < s.n; j++) {
    double* target = s.column(j);
    const double row = target[k];
    for (int i = begin; i < end; i += kLanes) {
      TURGOR_LANES
      for (int q = i; q < i + kLanes; q++) target[q] -= s.factors[q] * row;
    }
  }
  // update the right-hand side
  for (int i = k + 1; i < s.n; i++) s.rhs[i] -= s.factors[i] * s.rhs[k];
}

/// Row of the pivot of column k: k itself, unless another entry below it is more than ten times as large.
int pivot_row(const System& s, int k) {
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

/// Gaussian elimination with row exchanges. False for a singular matrix.
bool solve_in_place(const System& s) {
  TURGOR_CHECK(s.n >= 0 && s.n <= s.stride, "the Newton system fits the allocated storage");
  constexpr double kSingular = 1e-13;
  const double smallest = kSingular * largest_entry(s);
  // forward elimination
  for (int k = 0; k < s.n; k++) {
    const int row = pivot_row(s, k);
    if (!(std::abs(s.column(k)[row]) > smallest)) return false;
    if (row != k) exchange_rows(s, k, row);
    eliminate(s, k);
  }
  // back substitution
  for (int k = s.n - 1; k >= 0; k--) {
    const double* pivot = s.column(k);
    s.rhs[k] /= pivot[k];
    for (int i = 0; i < k; i++) s.rhs[i] -= pivot[i] * s.rhs[k];
  }
  return true;
}

bool is_frictionless(const FrictionalContactProblem& p, int site) {
  return p.friction[std::size_t(site)] <= 0;
}

/// Numbers the unknowns and returns their count.
int number_unknowns(FrictionalContactProblem& p) {
  int count = 0;
  for (int i = p.held; i < p.count; i++) {
    const bool open = p.state[std::size_t(i)] == SiteState::kOpen;
    p.newton_row[std::size_t(i)] = open ? -1 : count;
    if (!open) count += is_frictionless(p, i) ? 1 : 3;
  }
  return count;
}

/// Coefficients of a sliding site's tangential equations, scaled to separations.
struct Slip {
  double d[2] = {0, 0};  // direction
  double turn = 0;       // μ λ_n / |c_t|
  double friction = 0, unit = 0;
};

Slip slip_of(const FrictionalContactProblem& p, int site) {
  const Vec3d c = read_site(p.separation, site), f = read_site(p.force, site);
  Slip slip{.friction = p.friction[std::size_t(site)], .unit = p.laws[std::size_t(site)].d.column[0].x};
  const double length = std::sqrt(c.y * c.y + c.z * c.z);
  TURGOR_CHECK(slip.unit > 0, "the compliance of a contact site is positive");
  if (length > 0) {
    slip.d[0] = c.y / length, slip.d[1] = c.z / length;
    slip.turn = slip.friction * f.x / length;
  }
  return slip;
}

/// Replaces the tangential rows of C at a sliding site by those of its slip equations.
void turn_rows(const System& s, int row, const Slip& slip) {
  const double scale = slip.unit * slip.turn;
  // μ λ_n δd
  for (int j = 0; j < s.n; j++) {
    double* c = s.column(j) + row;
    const double across = slip.d[0] * c[2] - slip.d[1] * c[1];
    c[1] = -scale * slip.d[1] * across;
    c[2] = scale * slip.d[0] * across;
  }
  // δλ_t + μ δλ_n d
  for (int axis = 0; axis < 2; axis++) {
    s.column(row)[row + 1 + axis] += slip.unit * slip.friction * slip.d[axis];
    s.column(row + 1 + axis)[row + 1 + axis] += slip.unit;
  }
}

/// Copies the columns of a site from C.
void fill_columns(const FrictionalContactProblem& p, int site, const System& s) {
  // unknowns of the site: normal only, or normal and tangents
  const int first = p.newton_row[std::size_t(site)], columns = is_frictionless(p, site) ? 1 : 3;
  TURGOR_CHECK(first >= 0 && first + columns <= s.n, "the unknowns of a site belong to the Newton system");
  for (int k = 0; k < columns; k++) {
    double* target = s.column(first + k);
    const double* c = column(p, 3 * site + k);
    // copy the rows of the free sites
    for (int i = p.held; i < p.count; i++) {
      const int row = p.newton_row[std::size_t(i)];
      if (row < 0) continue;
      target[row] = c[3 * i];
      if (!is_frictionless(p, i)) target[row + 1] = c[3 * i + 1], target[row + 2] = c[3 * i + 2];
    }
    // zero padding
    std::fill(target + s.n, target + padded(s.n), 0.0);
  }
}

/// Residual of a site's equations, with the rows of a sliding one.
void fill_rhs(const FrictionalContactProblem& p, int site, const System& s) {
  const int row = p.newton_row[std::size_t(site)];
  const Vec3d c = read_site(p.separation, site), f = read_site(p.force, site);
  s.rhs[row] = -c.x;
  if (is_frictionless(p, site)) return;
  s.rhs[row + 1] = -c.y, s.rhs[row + 2] = -c.z;
  if (p.state[std::size_t(site)] != SiteState::kSlip) return;
  const Slip slip = slip_of(p, site);
  s.rhs[row + 1] = -slip.unit * (f.y + slip.friction * f.x * slip.d[0]);
  s.rhs[row + 2] = -slip.unit * (f.z + slip.friction * f.x * slip.d[1]);
  turn_rows(s, row, slip);
}

}  // namespace

bool newton_step(FrictionalContactProblem& p) {
  // matrix and right-hand side
  const System s{p.newton_matrix.data(), p.newton_rhs.data(), p.newton_column.data(), number_unknowns(p),
                 p.stride};
  for (int i = p.held; i < p.count; i++)
    if (p.newton_row[std::size_t(i)] >= 0) fill_columns(p, i, s);
  for (int i = p.held; i < p.count; i++)
    if (p.newton_row[std::size_t(i)] >= 0) fill_rhs(p, i, s);
  // solve and add the change of the forces
  if (!solve_in_place(s)) return false;
  for (int j = p.held; j < p.count; j++) {
    const int row = p.newton_row[std::size_t(j)];
    if (row < 0) continue;
    const bool one = is_frictionless(p, j);
    add_force(p, j, {s.rhs[row], one ? 0 : s.rhs[row + 1], one ? 0 : s.rhs[row + 2]});
  }
  return true;
}

}  // namespace turgor::contact
