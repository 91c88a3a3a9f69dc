// Newton steps on the equations of the sites that bear force. With d the direction of slip, a sliding site
// obeys c_n = 0 and λ_t + μ λ_n d = 0, d = c_t/|c_t|, so that δd = (I − d dᵀ) δc_t/|c_t|; a sticking one
// obeys c = 0. Unknowns are forces in the frames of their sites.
#include <algorithm>
#include <cmath>

#include "turgor/contact/coulomb_steps.hpp"

namespace turgor::contact {

namespace {

/// The linear system of one step, in place of Coulomb's scratch.
struct System {
  double* a;  // column-major
  double* rhs;
  int n = 0, stride = 0;

  double* column(int j) const { return a + std::size_t(j) * std::size_t(stride); }
};

/// Gaussian elimination with row exchanges. False when a pivot is lost.
bool solve_in_place(const System& s) {
  constexpr double kLost = 1e-13;
  double largest = 0;
  for (int j = 0; j < s.n; j++)
    for (int i = 0; i < s.n; i++) largest = std::max(largest, std::abs(s.column(j)[i]));
  for (int k = 0; k < s.n; k++) {
    double* pivot = s.column(k);
    const auto best = int(std::max_element(pivot + k, pivot + s.n,
                                           [](double x, double y) { return std::abs(x) < std::abs(y); }) -
                          pivot);
    if (!(std::abs(pivot[best]) > kLost * largest)) return false;
    if (best != k) {
      for (int j = k; j < s.n; j++) std::swap(s.column(j)[k], s.column(j)[best]);
      std::swap(s.rhs[k], s.rhs[best]);
    }
    const double inverse = 1 / pivot[k];
    for (int i = k + 1; i < s.n; i++) pivot[i] *= inverse;
    for (int j = k + 1; j < s.n; j++) {
      double* target = s.column(j);
      const double factor = target[k];
      if (factor == 0) continue;
      TURGOR_LANES
      for (int i = k + 1; i < s.n; i++) target[i] -= pivot[i] * factor;
    }
    for (int i = k + 1; i < s.n; i++) s.rhs[i] -= pivot[i] * s.rhs[k];
  }
  for (int k = s.n - 1; k >= 0; k--) {
    const double* pivot = s.column(k);
    s.rhs[k] /= pivot[k];
    for (int i = 0; i < k; i++) s.rhs[i] -= pivot[i] * s.rhs[k];
  }
  return true;
}

bool is_frictionless(const Coulomb& p, int site) { return p.friction[std::size_t(site)] <= 0; }

/// Numbers the unknowns; returns how many there are.
int number_unknowns(Coulomb& p) {
  int count = 0;
  for (int i = p.held; i < p.count; i++) {
    const bool open = p.state[std::size_t(i)] == SiteState::kOpen;
    p.newton_row[std::size_t(i)] = open ? -1 : count;
    if (!open) count += is_frictionless(p, i) ? 1 : 3;
  }
  return count;
}

/// C_ij in the frames of its two sites.
Mat3d block(const Coulomb& p, int i, int j) {
  Mat3d b;
  for (int axis = 0; axis < 3; axis++) {
    const double* c = column(p, 3 * j + axis) + 3 * i;
    b.column[axis] = {c[0], c[1], c[2]};
  }
  return transposed(p.frames[std::size_t(i)].axes) * (b * p.frames[std::size_t(j)].axes);
}

Vec3d in_frame(const Coulomb& p, int site, const std::vector<double>& v) {
  return transposed(p.frames[std::size_t(site)].axes) * read_site(v, site);
}

/// How a sliding site's second and third equation depend on its slip.
struct Slip {
  double d[2];      // direction
  double turn = 0;  // μ λ_n / |c_t|
};

/// Rows of one site against the columns of another (or the same) one.
void fill_block(const Coulomb& p, int i, int j, const Slip& slip, const System& s) {
  const Mat3d c = block(p, i, j);
  const int row = p.newton_row[std::size_t(i)], first = p.newton_row[std::size_t(j)];
  const int columns = is_frictionless(p, j) ? 1 : 3;
  const bool slides = p.state[std::size_t(i)] == SiteState::kSlip;
  const double mu = p.friction[std::size_t(i)], unit = p.frames[std::size_t(i)].d[0];
  for (int k = 0; k < columns; k++) {
    double* target = s.column(first + k) + row;
    const Vec3d v = c.column[k];
    target[0] = v.x;
    if (is_frictionless(p, i)) continue;
    target[1] = v.y, target[2] = v.z;
    if (!slides) continue;
    const double along = slip.d[0] * v.y + slip.d[1] * v.z;
    const double own[2] = {i == j ? (k == 1) + mu * slip.d[0] * (k == 0) : 0,
                           i == j ? (k == 2) + mu * slip.d[1] * (k == 0) : 0};
    target[1] = unit * (own[0] + slip.turn * (v.y - slip.d[0] * along));
    target[2] = unit * (own[1] + slip.turn * (v.z - slip.d[1] * along));
  }
}

/// All rows of one site.
void fill_rows(const Coulomb& p, int i, const System& s) {
  const int row = p.newton_row[std::size_t(i)];
  const Vec3d c = in_frame(p, i, p.separation), f = in_frame(p, i, p.force);
  const double mu = p.friction[std::size_t(i)], unit = p.frames[std::size_t(i)].d[0];
  const double length = std::hypot(c.y, c.z);
  Slip slip{{0, 0}, 0};
  if (length > 0) slip = {{c.y / length, c.z / length}, mu * f.x / length};
  s.rhs[row] = -c.x;
  if (!is_frictionless(p, i)) {
    const bool slides = p.state[std::size_t(i)] == SiteState::kSlip;
    s.rhs[row + 1] = slides ? -unit * (f.y + mu * f.x * slip.d[0]) : -c.y;
    s.rhs[row + 2] = slides ? -unit * (f.z + mu * f.x * slip.d[1]) : -c.z;
  }
  for (int j = p.held; j < p.count; j++)
    if (p.newton_row[std::size_t(j)] >= 0) fill_block(p, i, j, slip, s);
}

}  // namespace

bool newton_step(Coulomb& p) {
  const System s{p.newton_matrix.data(), p.newton_rhs.data(), number_unknowns(p), p.stride};
  for (int i = p.held; i < p.count; i++)
    if (p.newton_row[std::size_t(i)] >= 0) fill_rows(p, i, s);
  if (!solve_in_place(s)) return false;
  for (int j = p.held; j < p.count; j++) {
    const int row = p.newton_row[std::size_t(j)];
    if (row < 0) continue;
    const Vec3d local{s.rhs[row], is_frictionless(p, j) ? 0 : s.rhs[row + 1],
                      is_frictionless(p, j) ? 0 : s.rhs[row + 2]};
    add_force(p, j, p.frames[std::size_t(j)].axes * local);
  }
  return true;
}

}  // namespace turgor::contact
