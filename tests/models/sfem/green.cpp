#include "turgor/models/sfem/green.hpp"

#include <Eigen/Dense>

#include <gtest/gtest.h>

#include "tests/models/sfem/dense.hpp"

namespace turgor::sfem {
namespace {

constexpr std::size_t kPlenty = std::size_t(2) << 30;

Model block_model(const Params& params, Material material = {1e4, 0.3}, double height = 0.1) {
  Body body = block_of(hex_block({0.1, 0.1, height}, {6, 5, 4}), material, [](Vec3d x) { return x.z == 0; });
  return build(Exec(1), std::move(body), params).value();
}

Eigen::MatrixXd gathered(const Model& model, const std::vector<int>& vertices) {
  const auto n = Eigen::Index(3 * vertices.size());
  Eigen::MatrixXd result(n, n);
  gather_green(model, vertices, result.data());
  return result;
}

/// The force that displaces one vertex by u: C f = u with C = Ξ_pp.
Vec3d reaction(const Model& model, int vertex, Vec3d u) {
  const Eigen::Matrix3d c = gathered(model, {vertex});
  const Eigen::Vector3d f = c.llt().solve(Eigen::Vector3d(u.x, u.y, u.z));
  return {f[0], f[1], f[2]};
}

// The store is the inverse of K between the stored nodes.
TEST(SfemGreen, StoreIsInverseOfStiffness) {
  for (const Precision precision : {Precision::kSingle, Precision::kDouble}) {
    Model model = block_model({.precision = precision, .touch_depth = 0});
    ASSERT_TRUE(compute_green(Exec(2), model, kPlenty));
    ASSERT_LT(model.green.nodes.size(), model.vertex.size());
    const Eigen::MatrixXd expected = dense(model.stiffness).inverse(),
                          found = gathered(model, model.green.nodes);
    const double precise = precision == Precision::kSingle ? 1e-7 : 1e-13;
    double difference = 0;
    for (std::size_t c = 0; c < model.green.nodes.size(); c++)
      for (std::size_t r = 0; r < model.green.nodes.size(); r++) {
        const auto row = model.free_node[std::size_t(model.green.nodes[r])];
        const auto column = model.free_node[std::size_t(model.green.nodes[c])];
        const auto d = found.block<3, 3>(3 * Eigen::Index(r), 3 * Eigen::Index(c)) -
                       expected.block<3, 3>(3 * row, 3 * column);
        difference = std::max(difference, d.cwiseAbs().maxCoeff());
      }
    EXPECT_LT(difference, precise * expected.cwiseAbs().maxCoeff());
    EXPECT_EQ(found, found.transpose());
  }
}

// One, two and eight threads give the same bits.
TEST(SfemGreen, EqualBitsOnAnyThreads) {
  Model one = block_model({.touch_depth = 1});
  ASSERT_TRUE(compute_green(Exec(1), one, kPlenty));
  for (const int threads : {2, 8}) {
    Model many = block_model({.touch_depth = 1});
    ASSERT_TRUE(compute_green(Exec(threads), many, kPlenty));
    EXPECT_EQ(one.green.single_values, many.green.single_values);
    EXPECT_EQ(one.green.checksum, many.green.checksum);
  }
}

// Fixed vertices have zero rows and columns.
TEST(SfemGreen, FixedVerticesHaveZeroRows) {
  Model model = block_model({});
  ASSERT_TRUE(compute_green(Exec(1), model, kPlenty));
  const Eigen::MatrixXd green = gathered(model, {0, model.green.nodes[0]});
  EXPECT_EQ(green.topRows(3).norm(), 0);
  EXPECT_EQ(green.leftCols(3).norm(), 0);
  EXPECT_GT(green.bottomRightCorner(3, 3).norm(), 0);
}

// Columns on demand equal those of the full store.
TEST(SfemGreen, ColumnsOnDemandMatchStore) {
  Model dense = block_model({.touch_depth = 0}), lazy = dense;
  ASSERT_TRUE(compute_green(Exec(2), dense, kPlenty));
  ASSERT_TRUE(prepare_columns(Exec(2), lazy));
  const std::vector<int> touched{dense.green.nodes[40], dense.green.nodes[3], dense.green.nodes[77]};
  EXPECT_FALSE(has_column(lazy.green, lazy.green.slot[std::size_t(touched[0])]));
  fetch_columns(Exec(2), lazy, touched);
  EXPECT_TRUE(has_column(lazy.green, lazy.green.slot[std::size_t(touched[0])]));
  const Eigen::MatrixXd a = gathered(dense, touched), b = gathered(lazy, touched);
  EXPECT_LT((a - b).cwiseAbs().maxCoeff(), 1e-7 * a.cwiseAbs().maxCoeff());
  EXPECT_EQ(b, b.transpose());
  std::array<double, 9> far{}, expected{};
  green_block(lazy.green, 90, lazy.green.slot[std::size_t(touched[0])], far);
  green_block(dense.green, 90, dense.green.slot[std::size_t(touched[0])], expected);
  for (std::size_t i = 0; i < 9; i++) EXPECT_NEAR(far[i], expected[i], 1e-7 * a.cwiseAbs().maxCoeff());
}

// Columns are computed without a change to the model and added later.
TEST(SfemGreen, ColumnsAreComputedThenAdded) {
  Model model = block_model({});
  ASSERT_TRUE(prepare_columns(Exec(1), model));
  const std::vector<int> vertices{model.green.nodes[5], model.green.nodes[6]};
  FetchedColumns fetched = compute_columns(Exec(2), model, vertices);
  EXPECT_FALSE(has_column(model.green, 5));
  add_columns(model.green, std::move(fetched));
  EXPECT_TRUE(has_column(model.green, 5));
  EXPECT_TRUE(compute_columns(Exec(2), model, vertices).slots.empty());
}

// Many columns are solved in wider blocks. They equal the store, with the same bits on any number of threads.
TEST(SfemGreen, ManyColumns_MatchStoreSameBits) {
  Model dense = block_model({}), one = dense, three = dense;
  ASSERT_TRUE(compute_green(Exec(2), dense, kPlenty));
  ASSERT_TRUE(prepare_columns(Exec(1), one) && prepare_columns(Exec(3), three));
  const std::vector<int> all = dense.green.nodes;
  ASSERT_GT(all.size(), 64U);
  fetch_columns(Exec(1), one, all);
  fetch_columns(Exec(3), three, all);
  EXPECT_EQ(one.green.columns, three.green.columns);
  const Eigen::MatrixXd a = gathered(dense, all), b = gathered(one, all);
  EXPECT_LT((a - b).cwiseAbs().maxCoeff(), 1e-7 * a.cwiseAbs().maxCoeff());
}

// Columns that are not kept return their memory.
TEST(SfemGreen, ForgottenColumnsReturnMemory) {
  Model model = block_model({});
  ASSERT_TRUE(prepare_columns(Exec(1), model));
  std::vector<int> vertices(model.green.nodes.begin(), model.green.nodes.begin() + 6);
  std::sort(vertices.begin(), vertices.end());
  fetch_columns(Exec(1), model, vertices);
  const std::size_t column = 9 * sizeof(float) * model.green.nodes.size();
  EXPECT_EQ(column_bytes(model.green), 6 * column);
  keep_columns(model.green, std::span(vertices).first(2));
  EXPECT_EQ(column_bytes(model.green), 2 * column);
  EXPECT_EQ(model.green.columns[std::size_t(model.green.slot[std::size_t(vertices[5])])].capacity(), 0U);
}

// A request for columns may include fixed vertices.
TEST(SfemGreen, FetchesColumnsNextToFixedVertices) {
  Model model = block_model({});
  ASSERT_TRUE(prepare_columns(Exec(1), model));
  const int held =
      int(std::find(model.body.fixed.begin(), model.body.fixed.end(), 1) - model.body.fixed.begin());
  fetch_columns(Exec(1), model, {held, model.green.nodes[5]});
  EXPECT_TRUE(has_column(model.green, 5));
  EXPECT_EQ(gathered(model, {held, model.green.nodes[5]}).topRows(3).norm(), 0);
}

// A store beyond the memory limit is rejected before any computation.
TEST(SfemGreen, RejectsStoreBeyondMemoryLimit) {
  Model model = block_model({.precision = Precision::kDouble});
  const GreenCost cost = green_cost(model);
  EXPECT_EQ(cost.store_bytes, 72 * model.green.nodes.size() * model.green.nodes.size());
  const Status status = compute_green(Exec(1), model, cost.store_bytes);
  ASSERT_FALSE(status);
  EXPECT_NE(status.error().message.find("coarser mesh"), std::string::npos) << status.error().message;
  EXPECT_FALSE(model.factor);
  EXPECT_TRUE(compute_green(Exec(1), model, cost.store_bytes + cost.factor_bytes + cost.work_bytes));
  EXPECT_EQ(model.factor->values.size() * 8 + model.factor->plan.rows.size() * 4, cost.factor_bytes);
}

// The progress increases to one.
TEST(SfemGreen, ProgressIncreasesToOne) {
  Model model = block_model({});
  double last = 0;
  ASSERT_TRUE(compute_green(Exec(1), model, kPlenty, [&](double done) {
    EXPECT_GE(done, last);
    last = done;
  }));
  EXPECT_DOUBLE_EQ(last, 1);
}

// Verification by random columns accepts the store and detects wrong values.
TEST(SfemGreen, VerificationDetectsWrongValues) {
  Model model = block_model({.formulation = Formulation::kAveraged}, {1e4, 0.49});
  ASSERT_TRUE(compute_green(Exec(1), model, kPlenty));
  EXPECT_TRUE(verify_green(model, 4, 11));
  const std::size_t side = 3 * model.green.nodes.size();
  for (std::size_t i = 0; i < side; i++) model.green.single_values[i * (side + 1)] *= 1.0001f;
  EXPECT_FALSE(verify_green(model, 1, 11));
}

// A store of another body is detected.
TEST(SfemGreen, DetectsStoreOfAnotherBody) {
  Model model = block_model({});
  ASSERT_TRUE(compute_green(Exec(1), model, kPlenty));
  EXPECT_TRUE(check_green(model));
  for (const auto& [material, height] :
       {std::pair{Material{1.001e4, 0.3}, 0.1}, {Material{1e4, 0.301}, 0.1}, {Material{1e4, 0.3}, 0.1001}}) {
    Model other = block_model({}, material, height);
    other.green = model.green;
    const Status status = check_green(other);
    ASSERT_FALSE(status);
    EXPECT_NE(status.error().message.find("not those of this body"), std::string::npos);
  }
  Body body = model.body;
  body.fixed[35 + 17] = 1;  // another vertex is fixed
  Model other = build(Exec(1), std::move(body), {}).value();
  other.green = model.green;
  EXPECT_FALSE(check_green(other));
}

// Flipped bits, NaN and missing values are detected.
TEST(SfemGreen, DetectsFlippedBits) {
  Model model = block_model({});
  ASSERT_TRUE(compute_green(Exec(1), model, kPlenty));
  for (const std::size_t index : {std::size_t(1234), model.green.single_values.size() - 1}) {
    Model damaged = model;
    std::uint32_t bits;
    std::memcpy(&bits, &damaged.green.single_values[index], 4);
    bits ^= 1;
    std::memcpy(&damaged.green.single_values[index], &bits, 4);
    EXPECT_FALSE(check_green(damaged));
  }
  Model damaged = model;
  damaged.green.check.values[7] = NAN;
  EXPECT_FALSE(check_green(damaged));
  damaged = model;
  damaged.green.single_values.pop_back();
  EXPECT_FALSE(check_green(damaged));
}

// The reaction of a clamped plate matches that of an independent program.
TEST(SfemGreen, PlateReactionMatchesIndependentProgram) {
  struct Row {
    int n, layers;
    double force;  // [N]
  };
  for (const auto [n, layers, force] :
       {Row{4, 1, -1.04722}, Row{8, 1, -0.672865}, Row{8, 2, -0.584958}, Row{12, 1, -0.574669},
        Row{12, 3, -0.456165}, Row{16, 4, -0.393929}}) {
    Model model = build(Exec(2), clamped_plate(n, layers), {.precision = Precision::kDouble}).value();
    ASSERT_TRUE(compute_green(Exec(2), model, kPlenty));
    const Vec3d f = reaction(model, vertex_at(model.body.mesh, {0.05, 0.05, 0.01}), {0, 0, -0.003});
    EXPECT_NEAR(f.z, force, 1e-5 * -force) << n << "x" << n << "x" << layers;
  }
}

// The capacitance matrix gives the forces of a solve with deleted rows.
TEST(SfemGreen, CapacitanceMatrixMatchesDeletedRows) {
  Model model = block_model({.precision = Precision::kDouble});
  ASSERT_TRUE(compute_green(Exec(1), model, kPlenty));
  const std::vector<int> touched(model.green.nodes.end() - 5, model.green.nodes.end());
  const Eigen::VectorXd u = Eigen::VectorXd::LinSpaced(15, -0.01, 0.02);
  const Eigen::VectorXd force = gathered(model, touched).llt().solve(u);

  const Eigen::MatrixXd k = dense(model.stiffness).inverse().inverse();
  std::vector<Eigen::Index> held, free;
  for (const int v : touched)
    for (int i = 0; i < 3; i++) held.push_back(3 * model.free_node[std::size_t(v)] + i);
  for (Eigen::Index i = 0; i < k.rows(); i++)
    if (std::find(held.begin(), held.end(), i) == held.end()) free.push_back(i);
  const Eigen::VectorXd rest = k(free, free).llt().solve(-k(free, held) * u);
  const Eigen::VectorXd expected = k(held, free) * rest + k(held, held) * u;
  EXPECT_LT((force - expected).norm(), 1e-10 * expected.norm());
}

}  // namespace
}  // namespace turgor::sfem
