// Ties between bodies, compared with a finite-element solution of both bodies at once, and with the
// conditions that define slack and strength.
#include "turgor/contact/coupling.hpp"

#include <Eigen/Dense>
#include <random>

#include <gtest/gtest.h>

#include "turgor/core/hash.hpp"
#include "turgor/geometry/hex_block.hpp"

namespace turgor::contact {
namespace {

/// A block with its low corner at `corner`, fixed where `is_fixed`, with a dense store in double precision.
sfem::Model block(Vec3d corner, Vec3d size, Int3 count, sfem::Material material,
                  const std::function<bool(Vec3d)>& is_fixed) {
  sfem::Body body{.mesh = hex_block(size, count), .materials = {material}};
  for (Vec3d& x : body.mesh.vertices) x += corner, body.fixed.push_back(is_fixed(x));
  sfem::Model model = sfem::build(Exec(1), std::move(body), {.precision = sfem::Precision::kDouble}).value();
  EXPECT_TRUE(sfem::compute_green(Exec(1), model, std::size_t(1) << 30));
  EXPECT_TRUE(sfem::factorize(Exec(1), model));
  return model;
}

/// Two blocks with 1 mm between them, fixed at the far ends, of different material and mesh.
struct Pair {
  sfem::Model left = block({}, {0.04, 0.03, 0.02}, {4, 3, 2}, {5e3, 0.3}, [](Vec3d x) { return x.x < 1e-9; });
  sfem::Model right = block({0.041, 0, 0}, {0.05, 0.03, 0.02}, {5, 4, 3}, {2e4, 0.42},
                            [](Vec3d x) { return x.x > 0.091 - 1e-9; });

  const sfem::Model& model(int body) const { return body == 0 ? left : right; }
};

std::vector<Vec3d> solved(const sfem::Model& model, const std::vector<VertexForce>& forces) {
  std::vector<double> u(3 * model.vertex.size());
  for (const auto& [vertex, force] : forces)
    if (const int row = model.free_node[std::size_t(vertex)]; row >= 0)
      for (int axis = 0; axis < 3; axis++) u[3 * std::size_t(row) + std::size_t(axis)] += force[axis];
  sfem::solve(*model.factor, u);
  std::vector<Vec3d> displacement(model.body.mesh.vertices.size());
  for (std::size_t row = 0; row < model.vertex.size(); row++)
    displacement[std::size_t(model.vertex[row])] = {u[3 * row], u[3 * row + 1], u[3 * row + 2]};
  return displacement;
}

/// Random forces on all vertices.
std::vector<VertexForce> random_load(const sfem::Model& model, unsigned seed, double size) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> of(-size, size);
  std::vector<VertexForce> forces;
  for (std::size_t v = 0; v < model.body.mesh.vertices.size(); v++)
    forces.push_back({int(v), {of(random), of(random), of(random)}});
  return forces;
}

/// Ties from vertices of the left block's end face to points in triangles of the right one's.
std::vector<Tie> end_ties(const Pair& pair, double stiffness, double slack) {
  std::vector<Tie> ties;
  const std::vector<Vec3d>& x = pair.left.body.mesh.vertices;
  int next = 0;
  for (std::size_t v = 0; v < x.size(); v++) {
    if (x[v].x < 0.04 - 1e-9) continue;
    // any triangle of the other end face
    Int3 triangle{-1, -1, -1};
    int seen = 0;
    for (const Int3 t : pair.right.surface.triangles) {
      bool on_end = true;
      for (const int corner : {t.x, t.y, t.z})
        on_end = on_end && pair.right.body.mesh.vertices[std::size_t(corner)].x < 0.041 + 1e-9;
      if (on_end && seen++ == next % 24) triangle = t;
    }
    next += 5;
    ties.push_back({.a = {0, {int(v), -1, -1}, {1, 0, 0}, x[v]},
                    .b = {1, triangle, {0.2, 0.5, 0.3}, {}},
                    .stiffness = stiffness * (1 + 0.1 * next),
                    .slack = slack,
                    .force = {}});
  }
  return ties;
}

/// Adds K of one body to a dense matrix whose rows begin at `first`.
void add_stiffness(const sfem::Model& model, int first, Eigen::MatrixXd& k) {
  const sfem::BlockMatrix& m = model.stiffness;
  for (std::size_t row = 0; row + 1 < m.row_begin.size(); row++)
    for (std::size_t b = m.row_begin[row]; b < m.row_begin[row + 1]; b++)
      for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
          k(first + 3 * int(row) + i, first + 3 * m.column[b] + j) += m.value[9 * b + std::size_t(3 * i + j)];
}

/// Both bodies under loads of their own.
struct Loaded {
  Pair pair;
  std::array<std::vector<VertexForce>, 2> load;
  std::vector<CoupledBody> bodies;

  explicit Loaded(double size) {
    for (int b = 0; b < 2; b++) {
      load[std::size_t(b)] = random_load(pair.model(b), 3 + unsigned(b), size);
      bodies.push_back({&pair.model(b), 1, solved(pair.model(b), load[std::size_t(b)])});
    }
  }
};

// Forces of ties and displacements of both bodies are those of one finite-element system that contains both
// bodies and all springs.
TEST(Coupling, Ties_EqualOneSystemOfBothBodies) {
  const Loaded two(0.01);
  std::vector<Tie> ties = end_ties(two.pair, 30, 0);
  const CouplingReport report = solve_coupling(Exec(1), two.bodies, ties, {});
  EXPECT_TRUE(report.converged);

  // dense system with the springs
  const int n0 = 3 * int(two.pair.left.vertex.size()), n1 = 3 * int(two.pair.right.vertex.size());
  Eigen::MatrixXd k = Eigen::MatrixXd::Zero(n0 + n1, n0 + n1);
  Eigen::VectorXd f = Eigen::VectorXd::Zero(n0 + n1);
  add_stiffness(two.pair.left, 0, k), add_stiffness(two.pair.right, n0, k);
  const auto row_of = [&](int body, int v) {
    const int row = two.pair.model(body).free_node[std::size_t(v)];
    return row < 0 ? -1 : (body == 0 ? 0 : n0) + 3 * row;
  };
  for (int b = 0; b < 2; b++)
    for (const auto& [v, force] : two.load[std::size_t(b)])
      if (const int row = row_of(b, v); row >= 0)
        for (int axis = 0; axis < 3; axis++) f(row + axis) += force[axis];
  for (const Tie& tie : ties)
    for (int axis = 0; axis < 3; axis++) {
      Eigen::VectorXd apart = Eigen::VectorXd::Zero(n0 + n1);
      for (const auto& [point, sign] : {std::pair{tie.a, 1.0}, {tie.b, -1.0}})
        for (int corner = 0; corner < 3; corner++)
          if (point.vertex[corner] >= 0)
            if (const int row = row_of(point.body, point.vertex[corner]); row >= 0)
              apart(row + axis) += sign * point.weight[corner];
      k += tie.stiffness * apart * apart.transpose();
    }
  const Eigen::VectorXd u = k.ldlt().solve(f);

  // displacements of both bodies
  for (int b = 0; b < 2; b++) {
    std::vector<Vec3d> mine = solved(two.pair.model(b), forces_on(b, ties, {}));
    double most = 0, error = 0;
    for (std::size_t v = 0; v < mine.size(); v++) {
      const int row = row_of(b, int(v));
      if (row < 0) continue;
      const Vec3d expected{u(row), u(row + 1), u(row + 2)};
      most = std::max(most, norm(expected));
      error = std::max(error, norm(mine[v] + two.bodies[std::size_t(b)].free[v] - expected));
    }
    EXPECT_LT(error, 1e-9 * most);
  }
}

/// Change of a tie's length vector under all forces, by the factors of both bodies.
std::vector<Vec3d> stretches(const Loaded& two, const std::vector<Tie>& ties) {
  std::array<std::vector<Vec3d>, 2> u;
  for (int b = 0; b < 2; b++) {
    u[std::size_t(b)] = solved(two.pair.model(b), forces_on(b, ties, {}));
    for (std::size_t v = 0; v < u[std::size_t(b)].size(); v++)
      u[std::size_t(b)][v] += two.bodies[std::size_t(b)].free[v];
  }
  std::vector<Vec3d> d;
  for (const Tie& tie : ties)
    d.push_back(displacement_of(tie.a, u[std::size_t(tie.a.body)]) -
                displacement_of(tie.b, u[std::size_t(tie.b.body)]));
  return d;
}

// A tie with slack pulls along its stretch d with k (|d| − s), and not at all while |d| < s.
TEST(Coupling, Slack_LawHoldsAtEveryTie) {
  const Loaded two(0.05);
  // stretches without ties
  std::vector<double> apart;
  for (const Tie& tie : end_ties(two.pair, 30, 0)) apart.push_back(norm(free_stretch(two.bodies, tie)));
  std::sort(apart.begin(), apart.end());
  for (const double factor : {0.1, 0.9, 1.2}) {
    const double slack = factor * apart[apart.size() / 2];
    std::vector<Tie> ties = end_ties(two.pair, 30, slack);
    const CouplingReport report = solve_coupling(Exec(1), two.bodies, ties, {});
    EXPECT_TRUE(report.converged);
    const std::vector<Vec3d> d = stretches(two, ties);
    int taut = 0;
    for (std::size_t t = 0; t < ties.size(); t++) {
      const double over = std::max(0.0, norm(d[t]) - slack);
      const Vec3d expected = d[t] * (-ties[t].stiffness * over / norm(d[t]));
      EXPECT_LT(norm(ties[t].force - expected), 1e-6 * (0.01 + norm(expected))) << "tie " << t;
      taut += ties[t].force != Vec3d{};
    }
    if (factor == 0.9) {  // both kinds occur
      EXPECT_GT(taut, 0);
      EXPECT_LT(taut, int(ties.size()));
    }
  }
}

// Ties break where their force exceeds their strength, and no more of them than needed: the most loaded
// breaks first, and those that remain bear less than their strength.
TEST(Coupling, Strength_OnlyOverloadedTiesBreak) {
  const Loaded two(0.05);
  std::vector<Tie> whole = end_ties(two.pair, 30, 0);
  (void)solve_coupling(Exec(1), two.bodies, whole, {});
  double most = 0;
  for (const Tie& tie : whole) most = std::max(most, norm(tie.force));

  for (const double factor : {1.01, 0.95, 0.5}) {
    std::vector<Tie> ties = end_ties(two.pair, 30, 0);
    for (Tie& tie : ties) tie.strength = factor * most;
    const CouplingReport report = solve_coupling(Exec(1), two.bodies, ties, {});
    for (const Tie& tie : ties) {
      EXPECT_LE(norm(tie.force), factor * most);
      if (tie.broken) {
        EXPECT_EQ(norm(tie.force), 0);
      }
    }
    EXPECT_EQ(report.broken > 0, factor < 1);
  }
}

// The forces have the same bits on any number of threads.
TEST(Coupling, Threads_SameBits) {
  const Loaded two(0.05);
  std::uint64_t expected = 0;
  for (const int threads : {1, 2, 8}) {
    std::vector<Tie> ties = end_ties(two.pair, 30, 2e-3);
    (void)solve_coupling(Exec(threads), two.bodies, ties, {});
    std::uint64_t hash = kHashSeed;
    for (const Tie& tie : ties) hash = hash_bytes(&tie.force, sizeof tie.force, hash);
    if (threads == 1) expected = hash;
    EXPECT_EQ(hash, expected) << threads;
  }
}

}  // namespace
}  // namespace turgor::contact
