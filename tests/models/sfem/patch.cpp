#include "turgor/models/sfem/patch.hpp"

#include <algorithm>

#include "tests/models/sfem/dense.hpp"
#include "turgor/models/sfem/elements.hpp"
#include "turgor/models/sfem/refinement.hpp"

namespace turgor::sfem {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// u = C f with the patch's compliance.
MatrixXd compliance(const Patch& patch) {
  const Eigen::Index n = 3 * Eigen::Index(patch.points.size());
  return Eigen::Map<const MatrixXd>(patch.compliance.data(), n, n);
}

int point_at(const Patch& patch, Vec3d x) {
  for (std::size_t p = 0; p < patch.points.size(); p++)
    if (norm(patch.points[p].x - x) < 1e-9) return int(p);
  ADD_FAILURE() << "no point at this position";
  return 0;
}

/// The force that displaces the center of the plate's top by 3 mm downward.
double plate_force(int refinement) {
  const Model model = densely_solved(clamped_plate(4, 1), {.precision = Precision::kDouble});
  const Patch patch = build_patch(model, std::vector<int>{5, 6, 9, 10}, refinement).value();
  const int tip = point_at(patch, {0.05, 0.05, 0.01});
  const Eigen::Matrix3d c = compliance(patch).block<3, 3>(3 * tip, 3 * tip);
  return c.ldlt().solve(Eigen::Vector3d(0, 0, -0.003)).z();
}

// The force on the paper's plate matches that of an independent program for every refinement.
TEST(SfemPatch, PlateForceMatchesIndependentProgram) {
  EXPECT_NEAR(plate_force(1) / -1.04722, 1, 1e-5);
  EXPECT_NEAR(plate_force(2) / -0.729968, 1, 1e-5);
  EXPECT_NEAR(plate_force(3) / -0.599702, 1, 1e-5);
  EXPECT_NEAR(plate_force(4) / -0.522144, 1, 1e-5);
}

/// Reference: the same body as one mesh with coarse elements outside of the patch and fine ones inside. Fine
/// nodes on the border are tied to the coarse edges. It uses neither Green's functions nor condensation.
struct TiedMesh {
  FineMesh fine;
  std::vector<int> own;  // unknown of each fine node beyond the coarse ones; -1 = none
  MatrixXd stiffness;
  Eigen::Index coarse = 0;

  /// Rows: displacement of a fine node as a function of the unknowns.
  MatrixXd motion(const Model& model, int node) const {
    MatrixXd n = MatrixXd::Zero(3, stiffness.rows());
    const FineNode& f = fine.nodes[std::size_t(node)];
    for (std::size_t s = 0; s < std::size_t(f.supports); s++)
      n.middleCols<3>(3 * model.free_node[std::size_t(f.coarse[s])]) +=
          f.weight[s] * Eigen::Matrix3d::Identity();
    if (own[std::size_t(node)] >= 0) n.middleCols<3>(3 * own[std::size_t(node)]).setIdentity();
    return n;
  }
};

SolidMesh without(const SolidMesh& mesh, const std::vector<int>& removed) {
  SolidMesh rest = mesh;
  rest.elements.clear();
  for (std::size_t e = 0; e < element_count(mesh); e++)
    if (!std::binary_search(removed.begin(), removed.end(), int(e)))
      for (const int v : element(mesh, e)) rest.elements.push_back(v);
  return rest;
}

TiedMesh tied_mesh(const Model& model, const std::vector<int>& elements, int refinement) {
  TiedMesh tied;
  tied.fine = refine(model, elements, refinement);
  int unknowns = int(model.vertex.size());
  for (const FineNode& node : tied.fine.nodes)
    tied.own.push_back(node.at_vertex || node.on_border || node.fixed ? -1 : unknowns++);
  tied.coarse = 3 * Eigen::Index(model.vertex.size());
  tied.stiffness = MatrixXd::Zero(3 * unknowns, 3 * unknowns);

  const Body& body = model.body;
  const SolidMesh outside = without(body.mesh, elements);
  std::vector<int> material;
  const std::vector<int> all = element_materials(body);
  for (std::size_t e = 0; e < all.size(); e++)
    if (!std::binary_search(elements.begin(), elements.end(), int(e))) material.push_back(all[e]);
  const MatrixXd k_out =
      dense(assemble(Exec(1), outside, body.materials, material, model.params.formulation));
  for (Eigen::Index i = 0; i < k_out.rows() / 3; i++)
    for (Eigen::Index j = 0; j < k_out.cols() / 3; j++) {
      const int row = model.free_node[std::size_t(i)], column = model.free_node[std::size_t(j)];
      if (row >= 0 && column >= 0)
        tied.stiffness.block<3, 3>(3 * row, 3 * column) += k_out.block<3, 3>(3 * i, 3 * j);
    }

  Body inside;
  inside.mesh.corners = body.mesh.corners;
  for (const FineNode& node : tied.fine.nodes) inside.mesh.vertices.push_back(node.x);
  inside.mesh.elements = tied.fine.corners;
  inside.materials = body.materials, inside.inclusions = body.inclusions;
  const MatrixXd k_in = dense(
      assemble(Exec(1), inside.mesh, inside.materials, element_materials(inside), model.params.formulation));
  MatrixXd n(k_in.rows(), tied.stiffness.rows());
  for (int f = 0; f < int(tied.fine.nodes.size()); f++) n.middleRows<3>(3 * f) = tied.motion(model, f);
  tied.stiffness += n.transpose() * k_in * n;
  return tied;
}

struct PatchCase {
  const char* name;
  int corners;
  Formulation formulation;
  bool nodule;
};

Model case_model(const PatchCase& c, Precision precision) {
  const Vec3d size{0.3, 0.3, 0.2};
  SolidMesh mesh = hex_block(size, {3, 3, 2});
  distort(mesh, size, 0.02);
  mesh = with_corners(mesh, c.corners);
  Body body = block_of(std::move(mesh), {4e3, 0.45}, [](Vec3d x) { return x.z < 1e-9 || x.x < 1e-9; });
  body.materials.push_back({4e4, 0.3});
  if (c.nodule) body.inclusions = {{{0.2, 0.15, 0.15}, 0.06, 1}};
  return densely_solved(std::move(body), {c.formulation, precision, 1.0});
}

std::vector<int> upper_elements(const Model& model) {
  std::vector<int> found;
  for (std::size_t e = 0; e < element_count(model.body.mesh); e++)
    if (const Vec3d x = centroid(model.body.mesh, e); x.z > 0.1 && x.x > 0.1) found.push_back(int(e));
  return found;
}

constexpr PatchCase kPatchCases[] = {{"tetrahedra", 4, Formulation::kStandard, false},
                                     {"tetrahedra, nodule", 4, Formulation::kStandard, true},
                                     {"averaged tetrahedra", 4, Formulation::kAveraged, false},
                                     {"averaged tetrahedra, nodule", 4, Formulation::kAveraged, true},
                                     {"distorted hexahedra", 8, Formulation::kStandard, false},
                                     {"B-bar hexahedra, nodule", 8, Formulation::kAveraged, true},
                                     {"quadratic tetrahedra", 10, Formulation::kStandard, false},
                                     {"quadratic tetrahedra, nodule", 10, Formulation::kStandard, true}};

// The compliance of a patch equals that of one mesh with tied hanging nodes.
TEST(SfemPatch, MatchesMeshWithTiedHangingNodes) {
  for (const PatchCase& c : kPatchCases)
    for (int r = 1; r <= 3; r++) {
      // r = 1 is the coarse body itself: it does not refine a nodule, and its averaging is not separate from
      // its neighbors.
      if (r == 1 && (c.nodule || c.formulation == Formulation::kAveraged)) continue;
      if (r == 3 && c.corners == 10) continue;  // a dense system with thousands of unknowns
      const Model model = case_model(c, Precision::kDouble);
      const std::vector<int> elements = upper_elements(model);
      const Patch patch = build_patch(model, elements, r).value();
      const TiedMesh tied = tied_mesh(model, elements, r);
      MatrixXd motion(3 * Eigen::Index(patch.points.size()), tied.stiffness.rows());
      for (std::size_t p = 0; p < patch.points.size(); p++)
        for (std::size_t f = 0; f < tied.fine.nodes.size(); f++)
          if (tied.fine.nodes[f].key == patch.points[p].key)
            motion.middleRows<3>(3 * Eigen::Index(p)) = tied.motion(model, int(f));
      const MatrixXd expected = motion * tied.stiffness.ldlt().solve(motion.transpose());
      const double error = (compliance(patch) - expected).norm() / expected.norm();
      EXPECT_LT(error, 1e-10) << c.name << ", " << r << " subdivisions, " << patch.local_nodes
                              << " local nodes";
    }
}

// The dense system of a patch has the functions of the touched surface only.
TEST(SfemPatch, DenseSystemHasSurfaceOnly) {
  constexpr Vec3d kSize{0.048, 0.048, 0.024};
  const Body body = block_of(with_corners(hex_block(kSize, {6, 6, 3}), 10), {3e3, 0.45},
                             [](Vec3d x) { return x.z < 1e-9; });
  const Model model = densely_solved(body, {.touch_depth = 0.02});
  const std::vector<Vec3d> touch{{0.025, 0.023, kSize.z}};
  const std::vector<int> elements = patch_elements(model, touch, 0.0125);
  const Patch patch = build_patch(model, elements, 3, touch).value();
  const auto surface = std::size_t(patch.surface_nodes);
  EXPECT_LT(4 * patch.surface_nodes, patch.local_nodes);
  EXPECT_EQ(std::get<0>(patch.system).factor.size(), 9 * surface * surface);
  EXPECT_GT(patch.surface_nodes, 100);
  // work: far below that of a dense factor of all local functions
  const double dense = std::pow(3.0 * patch.local_nodes, 3) / 3;
  EXPECT_LT(patch_cost(model, elements, 3, touch).flops, dense / 4);
}

// The equivalent coarse forces displace the rest of the body as the tied mesh does.
TEST(SfemPatch, CoarseForcesMoveBodyAlike) {
  for (const PatchCase& c : kPatchCases) {
    const Model model = case_model(c, Precision::kDouble);
    const std::vector<int> elements = upper_elements(model);
    const Patch patch = build_patch(model, elements, 2).value();
    const TiedMesh tied = tied_mesh(model, elements, 2);
    // Forces on three points.
    std::vector<double> force(3 * patch.points.size(), 0);
    VectorXd load = VectorXd::Zero(tied.stiffness.rows());
    for (std::size_t p = 0; p < patch.points.size(); p += patch.points.size() / 3) {
      const Eigen::Vector3d f(0.1, -0.2, 0.3 + double(p));
      for (std::size_t i = 0; i < 3; i++) force[3 * p + i] = f[int(i)];
      for (std::size_t n = 0; n < tied.fine.nodes.size(); n++)
        if (tied.fine.nodes[n].key == patch.points[p].key) load += tied.motion(model, int(n)).transpose() * f;
    }
    const VectorXd expected = tied.stiffness.ldlt().solve(load).head(tied.coarse);
    const std::vector<double> equivalent = coarse_forces(patch, force);
    VectorXd on_body = VectorXd::Zero(tied.coarse);
    for (std::size_t i = 0; i < patch.coarse.size(); i++)
      for (int axis = 0; axis < 3; axis++)
        on_body[3 * model.free_node[std::size_t(patch.coarse[i])] + axis] +=
            equivalent[3 * i + std::size_t(axis)];
    const VectorXd moved = dense(model.stiffness).ldlt().solve(on_body);
    EXPECT_LT((moved - expected).norm() / expected.norm(), 1e-10) << c.name;

    std::vector<float> surface(3 * model.green.surface_count);
    surface_displacements(Exec(2), model, patch.coarse, equivalent, surface);
    double largest = 0;
    for (std::size_t i = 0; i < model.green.surface_count; i++)
      for (int axis = 0; axis < 3; axis++) {
        const int row = 3 * model.free_node[std::size_t(model.green.nodes[i])] + axis;
        largest = std::max(largest, std::abs(double(surface[3 * i + std::size_t(axis)]) - expected[row]));
      }
    EXPECT_LT(largest / expected.lpNorm<Eigen::Infinity>(), 1e-6) << c.name;
  }
}

// Prescribed displacements give the forces of a solve with deleted rows.
TEST(SfemPatch, PrescribedDisplacementsMatchDeletedRows) {
  const Model model = case_model(kPatchCases[1], Precision::kDouble);
  const std::vector<int> elements = upper_elements(model);
  const Patch patch = build_patch(model, elements, 2).value();
  const TiedMesh tied = tied_mesh(model, elements, 2);
  // Three points that are vertices of the coarse mesh.
  std::vector<int> points, rows;
  for (std::size_t p = 0; p < patch.points.size() && points.size() < 3; p++)
    for (std::size_t n = 0; n < tied.fine.nodes.size(); n++) {
      const FineNode& node = tied.fine.nodes[n];
      if (node.key != patch.points[p].key || node.supports == 0) continue;
      if (node.at_vertex)
        points.push_back(int(p)), rows.push_back(model.free_node[std::size_t(node.coarse[0])]);
    }
  ASSERT_EQ(points.size(), 3u);
  MatrixXd c(9, 9);
  VectorXd u(9);
  u << 1, 2, 3, -1, 0, 2, 0.5, 0.1, -3;
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      c.block<3, 3>(3 * i, 3 * j) =
          compliance(patch).block<3, 3>(3 * points[std::size_t(i)], 3 * points[std::size_t(j)]);
  const VectorXd force = c.ldlt().solve(u);

  // Delete the touched rows and solve again.
  const Eigen::Index n = tied.stiffness.rows();
  VectorXd full = VectorXd::Zero(n);
  std::vector<Eigen::Index> free_rows, touched_rows;
  for (Eigen::Index i = 0; i < n; i++) {
    const auto at = std::find(rows.begin(), rows.end(), int(i / 3));
    if (at == rows.end()) free_rows.push_back(i);
    if (at != rows.end()) full[i] = u[3 * (at - rows.begin()) + i % 3];
  }
  for (const int r : rows)
    for (int axis = 0; axis < 3; axis++) touched_rows.push_back(3 * r + axis);
  const MatrixXd k_ff = tied.stiffness(free_rows, free_rows), k_ft = tied.stiffness(free_rows, touched_rows);
  full(free_rows) = -k_ff.ldlt().solve(k_ft * u);
  const VectorXd expected = (tied.stiffness * full)(touched_rows);
  EXPECT_LT((force - expected).norm() / expected.norm(), 1e-10);
}

// The compliance in single precision is correct to four digits and positive semidefinite up to rounding.
TEST(SfemPatch, SinglePrecisionHasFourDigits) {
  for (const PatchCase& c : kPatchCases) {
    const int subdivisions = c.corners == 10 ? 2 : 3;
    const std::vector<int> elements = upper_elements(case_model(c, Precision::kDouble));
    const MatrixXd exact =
        compliance(build_patch(case_model(c, Precision::kDouble), elements, subdivisions).value());
    const MatrixXd single =
        compliance(build_patch(case_model(c, Precision::kSingle), elements, subdivisions).value());
    EXPECT_LT((single - exact).norm() / exact.norm(), 1e-4) << c.name;
    // Border points depend on others, so zero is an eigenvalue; none may be negative beyond rounding.
    const VectorXd eigenvalues = Eigen::SelfAdjointEigenSolver<MatrixXd>(single).eigenvalues();
    EXPECT_GT(eigenvalues.minCoeff(), -1e-6 * eigenvalues.maxCoeff()) << c.name;
  }
}

// A touch selects the elements around it, and only the points of its side.
TEST(SfemPatch, TouchSelectsElementsAndSide) {
  const Model model = densely_solved(clamped_plate(4, 1), {.touch_depth = 0.1});
  const Vec3d top{0.05, 0.05, 0.01};
  const std::vector<int> elements = patch_elements(model, std::vector<Vec3d>{top}, 0.02);
  EXPECT_EQ(elements, (std::vector<int>{5, 6, 9, 10}));
  const Patch patch = build_patch(model, elements, 3, std::vector<Vec3d>{top}).value();
  EXPECT_EQ(patch.local_nodes, 98);
  EXPECT_EQ(patch.points.size(), 49u);
  for (const PatchPoint& p : patch.points) EXPECT_NEAR(p.x.z, 0.01, 1e-12);
  const Patch both = build_patch(model, elements, 3).value();
  EXPECT_EQ(both.points.size(), 98u);
  // The compliance of the top does not depend on whether the bottom is included.
  const auto at = [&](const Patch& p) -> Eigen::Matrix3d {
    const int point = point_at(p, top);
    return compliance(p).block(3 * point, 3 * point, 3, 3);
  };
  EXPECT_LT((at(patch) - at(both)).norm(), 1e-4 * at(both).norm());
}

}  // namespace
}  // namespace turgor::sfem
