#include <algorithm>
#include <cmath>
#include <span>

#include "turgor/contact/coulomb_steps.hpp"
#include "turgor/contact/dense_system.hpp"
#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"

namespace turgor::contact {

namespace {

/// Columns of an elimination that are subtracted at once, each times a factor: an entry is loaded and stored
/// once for all of them. The result has the bits of one after the other.
struct Panel {
  static constexpr int kColumns = 4;
  const double* column[kColumns];
  double factor[kColumns];
  int count = 0;

  void add(const double* values, double times) { column[count] = values, factor[count++] = times; }

  /// target −= Σ factor · column in the rows [begin, end); end is a multiple of kLanes.
  void subtract(int begin, int end, double* target) const {
    TURGOR_CHECK(count > 0 && count <= kColumns && end % kLanes == 0, "a panel has one to four columns");
    if (count < kColumns) {
      for (int k = 0; k < count; k++)
        for (int i = begin; i < end; i++) target[i] -= column[k][i] * factor[k];
      return;
    }
    const double *a = column[0], *b = column[1], *c = column[2], *d = column[3];
    const double fa = factor[0], fb = factor[1], fc = factor[2], fd = factor[3];
    const int whole = std::min(padded(begin), end);
    for (int i = begin; i < whole; i++) target[i] = target[i] - a[i] * fa - b[i] * fb - c[i] * fc - d[i] * fd;
    for (int i = whole; i < end; i += kLanes) {
      TURGOR_LANES
      for (int q = i; q < i + kLanes; q++)
        target[q] = target[q] - a[q] * fa - b[q] * fb - c[q] * fc - d[q] * fd;
    }
  }
};

/// Cholesky elimination, stopped after the held unknowns. The remaining system has the compliance C_cc − C_ch
/// C_hh⁻¹ C_hc and the separations b_c − C_ch C_hh⁻¹ b_h. Columns of the held unknowns keep their rows below
/// the diagonal for solve_held. A pivot that is lost to rounding (two sites at the same position) bears no
/// force.
void eliminate_held(FrictionalContactProblem& p) {
  const int n = 3 * p.count, h = 3 * p.held;
  constexpr double kSingular = 1e-12;
  double largest = 0;
  for (int i = 0; i < h; i++) largest = std::max(largest, column(p, i)[i]);
  // eliminate a panel of columns at a time: from the columns of the panel one by one, then from all others
  for (int first = 0; first < h; first += Panel::kColumns) {
    const int last = std::min(first + Panel::kColumns, h);
    for (int i = first; i < last; i++) {
      double* pivot = column(p, i);
      if (!(pivot[i] > kSingular * largest)) pivot[i] = HUGE_VAL;
      for (int j = i + 1; j < n; j++)
        p.separation[std::size_t(j)] -= pivot[j] / pivot[i] * p.separation[std::size_t(i)];
      for (int j = i + 1; j < last; j++) {
        const double factor = pivot[j] / pivot[i];
        double* target = column(p, j);
        for (int row = j; row < n; row++) target[row] -= pivot[row] * factor;
      }
    }
    for (int j = last; j < n; j++) {
      Panel panel;
      for (int i = first; i < last; i++) panel.add(column(p, i), column(p, i)[j] / column(p, i)[i]);
      panel.subtract(j, padded(n), column(p, j));
    }
  }
  for (int j = h; j < n; j++)  // blocks on the diagonal are read in full
    for (int row = j / 3 * 3; row < j; row++) column(p, j)[row] = column(p, row)[j];
  // Held sites receive no further updates.
  for (int j = h; j < n; j++) std::fill_n(column(p, j), h, 0.0);
}

/// Back substitution: forces of the held sites from those of the others.
void solve_held(FrictionalContactProblem& p) {
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

/// Orthonormal axes whose first one is n.
Mat3d frame_around(Vec3d n) {
  const Vec3d other = std::abs(n.x) < 0.6 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0};
  const Vec3d t = normalized(cross(n, other));
  return {{n, t, cross(n, t)}};
}

Mat3d block(const FrictionalContactProblem& p, int row, int col) {
  Mat3d b;
  for (int axis = 0; axis < 3; axis++) {
    const double* c = column(p, 3 * col + axis) + 3 * row;
    b.column[axis] = {c[0], c[1], c[2]};
  }
  return b;
}
void write_block(const Mat3d& b, int row, int col, FrictionalContactProblem& p) {
  for (int axis = 0; axis < 3; axis++) {
    double* c = column(p, 3 * col + axis) + 3 * row;
    c[0] = b.column[axis].x, c[1] = b.column[axis].y, c[2] = b.column[axis].z;
  }
}

/// Transforms all quantities of the free sites into their frames, and fills both triangles of C from the
/// lower one.
void enter_frames(FrictionalContactProblem& p) {
  TURGOR_CHECK(
      std::all_of(p.normal.begin() + p.held, p.normal.begin() + p.count, [](Vec3d n) { return is_unit(n); }),
      "normals of contact sites are unit vectors");
  // frame of each site
  for (int i = p.held; i < p.count; i++) p.laws[std::size_t(i)].axes = frame_around(p.normal[std::size_t(i)]);
  for (int j = p.held; j < p.count; j++) {
    const Mat3d axes = p.laws[std::size_t(j)].axes;
    // blocks below the diagonal and their transposes
    for (int i = j; i < p.count; i++) {
      const Mat3d b = transposed(p.laws[std::size_t(i)].axes) * (block(p, i, j) * axes);
      write_block(b, i, j, p);
      write_block(transposed(b), j, i, p);
    }
    // separations and forces
    const Mat3d to_frame = transposed(axes);
    write_site(to_frame * read_site(p.separation, j), j, p.separation);
    write_site(to_frame * read_site(p.force, j), j, p.force);
    p.laws[std::size_t(j)] = make_law(axes, block(p, j, j));
  }
}

void leave_frames(FrictionalContactProblem& p) {
  for (int i = p.held; i < p.count; i++) {
    const Mat3d& axes = p.laws[std::size_t(i)].axes;
    write_site(axes * read_site(p.separation, i), i, p.separation);
    write_site(axes * read_site(p.force, i), i, p.force);
  }
}

/// One sweep; returns the largest change of a force.
double sweep(FrictionalContactProblem& p) {
  double largest = 0;
  for (int i = p.held; i < p.count; i++) {
    SiteCompliance& law = p.laws[std::size_t(i)];
    // exact solution of the site
    const Vec3d force = read_site(p.force, i);
    const SiteSolution solution =
        solve_site(law, read_site(p.separation, i) - law.d * force, p.friction[std::size_t(i)]);
    p.state[std::size_t(i)] = solution.state;
    // update the separations of all sites
    const Vec3d change = solution.force - force;
    if (change == Vec3d{}) continue;
    write_site(solution.force, i, p.force);
    add_separation(p, i, change);
    largest = std::max(largest, dot(change, change));
  }
  return std::sqrt(largest);
}

/// The largest force that one site alone would need to close its own gap.
double force_scale(const FrictionalContactProblem& p) {
  double largest = 0;
  for (int i = p.held; i < p.count; i++)
    largest = std::max(largest, norm(read_site(p.separation, i)) / p.laws[std::size_t(i)].d.column[0].x);
  return largest;
}

/// Restores the saved forces and the separations that belong to them.
void restore(FrictionalContactProblem& p) {
  for (int i = p.held; i < p.count; i++) add_force(p, i, read_site(p.saved_force, i) - read_site(p.force, i));
}

void save(FrictionalContactProblem& p) { std::copy_n(p.force.begin(), 3 * p.count, p.saved_force.begin()); }

/// Gauss–Seidel finds the states of the sites: open, sticking or sliding. Newton steps, each followed by a
/// sweep that updates the states, finish the solution. When several steps in a row have not halved the
/// residual, they are undone, and the next ones wait for more sweeps.
FrictionalContactReport solve_contacts(FrictionalContactProblem& p, const FrictionalContactParams& params,
                                       double scale) {
  constexpr int kRun = 5;
  FrictionalContactReport report;
  int wait = 3, run = 0;   // sweeps before the next steps, steps in a row
  double best = HUGE_VAL;  // residual that the steps must halve
  while (report.sweeps < params.sweeps) {
    const double change = sweep(p);
    report.sweeps++;
    report.residual = change > 0 ? change / scale : 0;
    report.converged = report.residual <= params.tolerance;
    if (report.converged) break;
    if (--wait > 0) continue;
    // start of a run of Newton steps, or progress within it
    if (run == 0 || report.residual < best / 2) {
      save(p);
      best = report.residual;
      run = 0;
    }
    const bool stuck = run == kRun;
    // Newton step
    if (!stuck && report.newton_steps < params.newton_steps && newton_step(p)) {
      run++, report.newton_steps++;
      continue;
    }
    // no progress: undo the run and wait
    if (run > 0) restore(p);
    run = 0;
    wait = report.sweeps;
  }
  // keep the better of the last two results
  if (run > 0 && report.residual > best) {
    restore(p);
    report.residual = best;
  }
  return report;
}

}  // namespace

FrictionalContactProblem make_frictional_contact_problem(int capacity) {
  TURGOR_ASSERT(capacity >= 0, "the capacity of a contact problem is not negative");
  // leading dimension padded to whole vector lanes
  const auto sites = std::size_t(capacity), unknowns = 3 * sites;
  FrictionalContactProblem p;
  p.stride = padded(3 * capacity);
  const auto stride = std::size_t(p.stride);
  // matrices and padded columns
  p.compliance.resize(unknowns * stride);
  p.newton_matrix.resize(unknowns * stride);
  p.separation.resize(stride);
  p.newton_rhs.resize(stride);
  p.newton_columns.resize(DenseSystem::kPanel * stride);
  // one entry per unknown
  for (auto* numbers : {&p.force, &p.saved_force}) numbers->resize(unknowns);
  // one entry per site
  p.normal.resize(sites);
  p.friction.resize(sites);
  p.state.resize(sites);
  p.laws.resize(sites);
  p.newton_sites.resize(sites);
  return p;
}

FrictionalContactReport solve(FrictionalContactProblem& p, const FrictionalContactParams& params) {
  TURGOR_ASSERT(3 * p.count <= p.stride && p.held <= p.count, "contact sites fit the allocated capacity");
  // zero padding of the columns
  const int end = padded(3 * p.count);
  for (int j = 0; j < 3 * p.count; j++) std::fill(column(p, j) + 3 * p.count, column(p, j) + end, 0.0);
  // reduce to the free sites, in their frames
  if (p.held > 0) eliminate_held(p);
  enter_frames(p);
  // separations of the initial forces, then iterate
  const double scale = force_scale(p);
  for (int i = p.held; i < p.count; i++) add_separation(p, i, read_site(p.force, i));
  const FrictionalContactReport report = solve_contacts(p, params, scale);
  // back to the world frame, then the held sites
  leave_frames(p);
  if (p.held > 0) solve_held(p);
  return report;
}

}  // namespace turgor::contact
