#include <algorithm>
#include <cmath>

#include "turgor/contact/coulomb_steps.hpp"
#include "turgor/core/assert.hpp"

namespace turgor::contact {

namespace {

/// Cholesky's elimination, stopped after the held unknowns: what is left is the compliance of the others
/// with the held ones in place, C_cc − C_ch C_hh⁻¹ C_hc, and their separations b_c − C_ch C_hh⁻¹ b_h. Columns
/// of the held unknowns keep their rows below the diagonal for place_held. A pivot that is lost to rounding
/// (a site on top of another one) bears no force.
void eliminate_held(Coulomb& p) {
  const int n = 3 * p.count, h = 3 * p.held;
  constexpr double kLost = 1e-12;
  double largest = 0;
  for (int i = 0; i < h; i++) largest = std::max(largest, column(p, i)[i]);
  for (int i = 0; i < h; i++) {
    double* pivot = column(p, i);
    if (!(pivot[i] > kLost * largest)) pivot[i] = HUGE_VAL;
    for (int j = i + 1; j < n; j++) {
      const double factor = pivot[j] / pivot[i];
      if (factor == 0) continue;
      double* target = column(p, j);
      for (int row = j; row < n; row++) target[row] -= pivot[row] * factor;
      p.separation[std::size_t(j)] -= factor * p.separation[std::size_t(i)];
    }
  }
  for (int j = h; j < n; j++)
    for (int row = h; row < j; row++) column(p, j)[row] = column(p, row)[j];
}

/// The forces of the held sites, once the others are known.
void place_held(Coulomb& p) {
  const int n = 3 * p.count;
  for (int i = 3 * p.held - 1; i >= 0; i--) {
    const double* pivot = column(p, i);
    double sum = p.separation[std::size_t(i)];
    for (int j = i + 1; j < n; j++) sum += pivot[j] * p.force[std::size_t(j)];
    p.force[std::size_t(i)] = -sum / pivot[i];
    p.separation[std::size_t(i)] = 0;
  }
  std::fill_n(p.state.begin(), p.held, SiteState::kHeld);
}

/// An axis, and two more that are orthogonal to it.
Mat3d frame_around(Vec3d n) {
  const Vec3d other = std::abs(n.x) < 0.6 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0};
  const Vec3d t = normalized(cross(n, other));
  return {{n, t, cross(n, t)}};
}

void make_frame(Coulomb& p, int site) {
  SiteFrame& frame = p.frames[std::size_t(site)];
  frame.axes = frame_around(p.normal[std::size_t(site)]);
  Mat3d block;
  for (int j = 0; j < 3; j++) {
    const double* c = column(p, 3 * site + j) + 3 * site;
    block.column[j] = {c[0], c[1], c[2]};
  }
  const Mat3d d = transposed(frame.axes) * (block * frame.axes);
  for (int row = 0; row < 3; row++)
    for (int j = 0; j < 3; j++) frame.d[3 * row + j] = (d.column[j][row] + d.column[row][j]) / 2;
}

/// One sweep; returns the largest change of a force.
double sweep(Coulomb& p) {
  double largest = 0;
  for (int i = p.held; i < p.count; i++) {
    const SiteFrame& frame = p.frames[std::size_t(i)];
    const Mat3d to_frame = transposed(frame.axes);
    const Vec3d f = to_frame * read_site(p.force, i);
    const double(&d)[9] = frame.d;
    const Vec3d d_f{d[0] * f.x + d[1] * f.y + d[2] * f.z, d[3] * f.x + d[4] * f.y + d[5] * f.z,
                    d[6] * f.x + d[7] * f.y + d[8] * f.z};
    const Vec3d alone = to_frame * read_site(p.separation, i) - d_f;
    const SiteSolution solution = solve_site(d, alone, p.friction[std::size_t(i)]);
    p.state[std::size_t(i)] = solution.state;
    const bool open = solution.state == SiteState::kOpen;  // then no force is left to rounding
    const Vec3d change = open ? -read_site(p.force, i) : frame.axes * (solution.force - f);
    if (change == Vec3d{}) continue;
    add_force(p, i, change);
    largest = std::max(largest, norm(change));
  }
  return largest;
}

/// The largest force that one site alone would need to close its own gap.
double force_scale(const Coulomb& p) {
  double largest = 0;
  for (int i = p.held; i < p.count; i++)
    largest = std::max(largest, norm(read_site(p.separation, i)) / p.frames[std::size_t(i)].d[0]);
  return largest;
}

/// Puts forces back, with the separations that belong to them.
void restore(Coulomb& p) {
  for (int i = p.held; i < p.count; i++)
    add_force(p, i, read_site(p.force_before, i) - read_site(p.force, i));
}

void save(Coulomb& p) { std::copy_n(p.force.begin(), 3 * p.count, p.force_before.begin()); }

/// Gauss–Seidel finds who touches, sticks and slides; Newton steps, each followed by a sweep that looks at
/// those states again, finish. When a few of them in a row have not halved the residual, they are taken back,
/// and the next ones wait for more sweeps.
CoulombReport solve_contacts(Coulomb& p, const CoulombParams& params, double scale) {
  constexpr int kRun = 5;
  CoulombReport report;
  int wait = 3, run = 0;   // sweeps before the next steps, steps in a row
  double best = HUGE_VAL;  // residual that the steps must halve
  while (report.sweeps < params.sweeps) {
    const double change = sweep(p);
    report.sweeps++;
    report.residual = change > 0 ? change / scale : 0;
    report.converged = report.residual <= params.tolerance;
    if (report.converged) break;
    if (--wait > 0) continue;
    if (run == 0 || report.residual < best / 2) {
      save(p);
      best = report.residual;
      run = 0;
    }
    const bool stuck = run == kRun;
    if (!stuck && report.newton_steps < params.newton_steps && newton_step(p)) {
      run++, report.newton_steps++;
      continue;
    }
    if (run > 0) restore(p);
    run = 0;
    wait = report.sweeps;
  }
  if (run > 0 && report.residual > best) {
    restore(p);
    report.residual = best;
  }
  return report;
}

}  // namespace

Coulomb make_coulomb(int capacity) {
  const auto sites = std::size_t(capacity), unknowns = 3 * sites;
  Coulomb p;
  p.stride = (3 * capacity + 7) / 8 * 8;  // columns begin on cache lines
  p.compliance.resize(unknowns * std::size_t(p.stride));
  p.newton_matrix.resize(unknowns * std::size_t(p.stride));
  for (auto* numbers : {&p.separation, &p.force, &p.force_before, &p.newton_rhs}) numbers->resize(unknowns);
  p.normal.resize(sites);
  p.friction.resize(sites);
  p.state.resize(sites);
  p.frames.resize(sites);
  p.newton_row.resize(sites);
  return p;
}

CoulombReport solve(Coulomb& p, const CoulombParams& params) {
  TURGOR_ASSERT(3 * p.count <= p.stride && p.held <= p.count, "contact sites fit what was allocated");
  if (p.held > 0) eliminate_held(p);
  for (int i = p.held; i < p.count; i++) make_frame(p, i);
  const double scale = force_scale(p);
  for (int i = p.held; i < p.count; i++) add_separation(p, i, read_site(p.force, i));
  const CoulombReport report = solve_contacts(p, params, scale);
  if (p.held > 0) place_held(p);
  return report;
}

}  // namespace turgor::contact
