#include "turgor/models/sfem/nonlinear_patch.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/core/sort_unique.hpp"
#include "turgor/models/sfem/dissection.hpp"
#include "turgor/models/sfem/green.hpp"
#include "turgor/models/sfem/nonlinear_elements.hpp"
#include "turgor/models/sfem/patch_assembly.hpp"

namespace turgor::sfem {

namespace {

using DenseMatrix = Eigen::MatrixXd;
using DenseView = Eigen::Map<const Eigen::MatrixXd>;

/// Numbers the nodes: free ones are unknown, those on the border depend on coarse vertices, fixed ones are
/// zero.
void number_nodes(const Model& model, const FineMesh& fine, NonlinearPatch& patch) {
  std::vector<int> of_vertex(model.body.mesh.vertices.size(), -1), unknown(fine.nodes.size(), -1);
  int count = 0;
  for (std::size_t n = 0; n < fine.nodes.size(); n++) {
    const FineNode& node = fine.nodes[n];
    const bool is_coarse = node.at_vertex && node.supports == 1;
    if (!is_coarse && (node.at_vertex || node.on_border || node.fixed)) continue;
    unknown[n] = count++;
    if (is_coarse) of_vertex[std::size_t(node.coarse[0])] = unknown[n];
  }
  for (std::size_t n = 0; n < fine.nodes.size(); n++) {
    const FineNode& node = fine.nodes[n];
    patch.begin.push_back(patch.weighted.size());
    if (unknown[n] >= 0)
      patch.weighted.push_back({unknown[n], 1});
    else if (!node.at_vertex)
      for (std::size_t s = 0; s < std::size_t(node.supports); s++)
        patch.weighted.push_back({of_vertex[std::size_t(node.coarse[s])], node.weight[s]});
  }
  patch.begin.push_back(patch.weighted.size());
  for (const int v : patch.patch.coarse) patch.coarse_node.push_back(of_vertex[std::size_t(v)]);
  patch.u.assign(3 * std::size_t(count), 0);
  TURGOR_CHECK(all_indices(patch.coarse_node, std::size_t(count)), "every coarse vertex is a fine node");
}

/// Fine elements with their Gauss points and moduli.
void list_elements(const Model& model, const FineMesh& fine, NonlinearPatch& patch) {
  const auto nodes = std::size_t(model.body.mesh.corners);
  patch.element_nodes = int(nodes), patch.corners = fine.corners;
  std::vector<Vec3d> x(nodes);
  for (const int material : fine_materials(model, fine))
    patch.moduli.push_back(moduli(model.body.materials[std::size_t(material)]));
  for (std::size_t e = 0; e < fine.parent.size(); e++) {
    std::uint8_t beside = 0;
    for (std::size_t c = 0; c < nodes; c++) {
      const FineNode& node = fine.nodes[std::size_t(fine.corners[e * nodes + c])];
      x[c] = node.x, beside |= std::uint8_t(node.on_border);
    }
    append_gauss_points(x, patch.gradient, patch.volume);
    patch.at_border.push_back(beside);
  }
}

/// Points of the linear patch as nodes of this one.
void find_points(const FineMesh& fine, NonlinearPatch& patch) {
  std::vector<std::pair<std::uint64_t, int>> by_key;
  for (std::size_t n = 0; n < fine.nodes.size(); n++) by_key.emplace_back(fine.nodes[n].key, int(n));
  std::sort(by_key.begin(), by_key.end());
  for (PatchPoint& point : patch.patch.points) {
    const auto found = std::lower_bound(by_key.begin(), by_key.end(), std::pair(point.key, 0));
    TURGOR_ASSERT(found != by_key.end() && found->first == point.key, "points of a patch are its fine nodes");
    const auto n = std::size_t(found->second);
    patch.point.emplace_back(patch.weighted.begin() + std::ptrdiff_t(patch.begin[n]),
                             patch.weighted.begin() + std::ptrdiff_t(patch.begin[n + 1]));
    const FineNode& node = fine.nodes[n];
    point.local = -1, point.supports = 0;
    for (std::size_t s = 0; s < std::size_t(node.supports); s++) {
      const auto at = std::lower_bound(patch.patch.coarse.begin(), patch.patch.coarse.end(), node.coarse[s]);
      point.coarse[s] = int(at - patch.patch.coarse.begin()), point.weight[s] = node.weight[s];
      point.supports++;
    }
  }
}

/// Coarse vertices of the patch, and those on its border.
void list_coarse(const Model& model, NonlinearPatch& patch) {
  const SolidMesh& mesh = model.body.mesh;
  std::vector<std::uint8_t> outside(mesh.vertices.size());
  std::vector<int>& coarse = patch.patch.coarse;
  coarse.clear();
  for (std::size_t e = 0; e < element_count(mesh); e++) {
    const bool inside = std::binary_search(patch.patch.elements.begin(), patch.patch.elements.end(), int(e));
    for (const int v : element(mesh, e)) {
      if (!inside)
        outside[std::size_t(v)] = 1;
      else if (model.free_node[std::size_t(v)] >= 0)
        coarse.push_back(v);
    }
  }
  sort_unique(coarse);
  for (std::size_t i = 0; i < coarse.size(); i++)
    if (outside[std::size_t(coarse[i])]) patch.rim.push_back(int(i));
}

/// Linear stiffness of the patch's coarse elements between its coarse vertices.
DenseMatrix stiffness_of_elements(const Model& model, const NonlinearPatch& patch) {
  const SolidMesh& mesh = model.body.mesh;
  const std::vector<int>& coarse = patch.patch.coarse;
  // mesh of these elements
  SolidMesh submesh{mesh.vertices, mesh.corners, {}, {}};
  std::vector<int> material;
  const std::vector<int> of_element = element_materials(model.body);
  for (const int e : patch.patch.elements) {
    const auto corners = element(mesh, std::size_t(e));
    submesh.elements.insert(submesh.elements.end(), corners.begin(), corners.end());
    material.push_back(of_element[std::size_t(e)]);
  }
  const BlockMatrix k = assemble(Exec(1), submesh, model.body.materials, material, model.params.formulation);
  // blocks between the coarse vertices
  std::vector<int> index(mesh.vertices.size(), -1);
  for (std::size_t i = 0; i < coarse.size(); i++) index[std::size_t(coarse[i])] = int(i);
  DenseMatrix dense = DenseMatrix::Zero(3 * Eigen::Index(coarse.size()), 3 * Eigen::Index(coarse.size()));
  for (std::size_t i = 0; i < coarse.size(); i++) {
    const auto row = std::size_t(coarse[i]);
    for (std::size_t at = k.row_begin[row]; at < k.row_begin[row + 1]; at++)
      if (const int column = index[std::size_t(k.column[at])]; column >= 0)
        for (int b = 0; b < 9; b++)
          dense(3 * Eigen::Index(i) + b / 3, 3 * column + b % 3) = k.value[9 * at + std::size_t(b)];
  }
  return dense;
}

/// Ξ_tt⁻¹, and the exterior between the vertices of the border.
Status condense_exterior(const Model& model, NonlinearPatch& patch) {
  const Eigen::Index n = 3 * Eigen::Index(patch.patch.coarse.size());
  std::vector<double> values(std::size_t(n * n));
  gather_green(model, patch.patch.coarse, values.data());
  const DenseMatrix green = DenseView(values.data(), n, n);
  const Eigen::LLT<DenseMatrix> factor((green + green.transpose()) / 2);
  if (factor.info() != Eigen::Success)
    return Error{
        "the Green's functions of the patch are lost to rounding: expected precision = \"double\", "
        "or Poisson's ratios farther below 0.5"};
  const DenseMatrix inverse = factor.solve(DenseMatrix::Identity(n, n));
  const DenseMatrix stiffness = (inverse + inverse.transpose()) / 2;
  patch.coarse_stiffness.assign(stiffness.data(), stiffness.data() + n * n);
  // exterior
  const DenseMatrix of_patch = stiffness_of_elements(model, patch);
  const std::size_t rim = 3 * patch.rim.size();
  patch.exterior.resize(rim * rim);
  for (std::size_t b = 0; b < rim; b++)
    for (std::size_t a = 0; a < rim; a++) {
      const Eigen::Index row = 3 * patch.rim[a / 3] + Eigen::Index(a % 3),
                         column = 3 * patch.rim[b / 3] + Eigen::Index(b % 3);
      patch.exterior[b * rim + a] = stiffness(row, column) - of_patch(row, column);
    }
  return Done{};
}

/// Pattern of the tangent, and the elimination order.
void plan_tangent(NonlinearPatch& patch) {
  const std::size_t rows = patch.u.size() / 3, nodes = std::size_t(patch.element_nodes);
  std::vector<std::vector<int>> columns(rows);
  const auto couple = [&](std::vector<int>& group) {
    sort_unique(group);
    for (const int row : group) {
      auto& list = columns[std::size_t(row)];
      list.insert(list.end(), group.begin(), group.end());
    }
  };
  std::vector<int> group;
  for (std::size_t e = 0; e < patch.moduli.size(); e++) {
    group.clear();
    for (std::size_t c = 0; c < nodes; c++) {
      const auto n = std::size_t(patch.corners[e * nodes + c]);
      for (std::size_t w = patch.begin[n]; w < patch.begin[n + 1]; w++)
        group.push_back(patch.weighted[w].node);
    }
    couple(group);
  }
  group.clear();
  for (const int i : patch.rim) group.push_back(patch.coarse_node[std::size_t(i)]);
  couple(group);
  patch.tangent.row_begin.assign(1, 0);
  for (auto& list : columns) {
    sort_unique(list);
    patch.tangent.column.insert(patch.tangent.column.end(), list.begin(), list.end());
    patch.tangent.row_begin.push_back(patch.tangent.column.size());
  }
  patch.tangent.value.assign(9 * patch.tangent.column.size(), 0);
  patch.plan = plan_elimination(patch.tangent, nested_dissection(patch.tangent));
}

/// Forces on the unknown nodes that are equivalent to those on the points.
std::vector<double> nodal_forces(const NonlinearPatch& patch, std::span<const double> forces) {
  std::vector<double> f(patch.u.size());
  for (std::size_t p = 0; p < patch.point.size(); p++)
    for (const WeightedNode& w : patch.point[p])
      for (std::size_t i = 0; i < 3; i++) f[3 * std::size_t(w.node) + i] += w.weight * forces[3 * p + i];
  return f;
}

double norm_of(const std::vector<double>& v) {
  double sum = 0;
  for (const double x : v) sum += x * x;
  return std::sqrt(sum);
}

/// Factor of the tangent; of the tangent and a multiple of the stiffness at rest where it is not positive
/// definite.
std::optional<Cholesky> factor_tangent(NonlinearPatch& patch) {
  constexpr double kShares[] = {0, 0.1, 1, 10};
  for (const double share : kShares) {
    BlockMatrix k = patch.tangent;
    if (share > 0)
      for (std::size_t i = 0; i < k.value.size(); i++) k.value[i] += share * patch.lifted[i];
    Result<Cholesky> factor = factorize(Exec(1), k, patch.plan, patch.plan.order);
    if (factor) return std::move(*factor);
  }
  return {};
}

/// Moves the solution by the largest of the step's halves that lowers the energy enough. Returns the length.
double line_search(NonlinearPatch& patch, const std::vector<double>& step, const std::vector<double>& f,
                   double slope) {
  constexpr int kHalvings = 12;
  constexpr double kEnough = 1e-4;
  const std::vector<double> start = patch.u;
  const double before = nonlinear_energy(patch, f);
  double length = 1;
  for (int i = 0; i < kHalvings; i++, length /= 2) {
    for (std::size_t k = 0; k < start.size(); k++) patch.u[k] = start[k] + length * step[k];
    const double now = nonlinear_energy(patch, f);
    if (now <= before + kEnough * length * slope + 1e-13 * std::abs(before)) return length;
  }
  patch.u = start;
  return 0;
}

/// Compliance between the points, and the response of the coarse vertices, from the factor.
struct Compliance {
  DenseMatrix points, response;
};
Compliance compliance_of(const NonlinearPatch& patch, const Cholesky& factor) {
  constexpr std::size_t kUnits = 16;
  // rows that move the points or the coarse vertices
  std::vector<int> of_points, kept;
  for (const auto& nodes : patch.point)
    for (const WeightedNode& w : nodes) of_points.push_back(w.node);
  sort_unique(of_points);
  kept = of_points;
  kept.insert(kept.end(), patch.coarse_node.begin(), patch.coarse_node.end());
  sort_unique(kept);
  std::vector<int> index(patch.u.size() / 3, -1), column(patch.u.size() / 3, -1);
  for (std::size_t i = 0; i < kept.size(); i++) index[std::size_t(kept[i])] = int(i);
  for (std::size_t i = 0; i < of_points.size(); i++) column[std::size_t(of_points[i])] = int(i);
  // columns of the inverse
  const std::vector<unsigned char> wanted = with_ancestors(factor.plan, kept);
  DenseMatrix green(3 * Eigen::Index(kept.size()), 3 * Eigen::Index(of_points.size()));
  UnitSolutions solved;
  for (std::size_t first = 0; first < of_points.size(); first += kUnits) {
    const std::size_t units = std::min(kUnits, of_points.size() - first);
    solve_units(factor, std::span(of_points).subspan(first, units), wanted, 0, solved);
    for (std::size_t r = 0; r < kept.size(); r++) {
      const double* row = solved.row(factor.plan.position[std::size_t(kept[r])]);
      for (std::size_t i = 0; i < 3; i++)
        for (std::size_t c = 0; c < 3 * units; c++)
          green(Eigen::Index(3 * r + i), Eigen::Index(3 * first + c)) = row[i * solved.columns + c];
    }
  }
  // from unknown nodes to points
  const auto points = Eigen::Index(patch.point.size());
  DenseMatrix by_points = DenseMatrix::Zero(green.rows(), 3 * points);
  for (Eigen::Index p = 0; p < points; p++)
    for (const WeightedNode& w : patch.point[std::size_t(p)])
      by_points.middleCols<3>(3 * p) += w.weight * green.middleCols<3>(3 * column[std::size_t(w.node)]);
  Compliance result{DenseMatrix::Zero(3 * points, 3 * points),
                    DenseMatrix(3 * Eigen::Index(patch.coarse_node.size()), 3 * points)};
  for (Eigen::Index p = 0; p < points; p++)
    for (const WeightedNode& w : patch.point[std::size_t(p)])
      result.points.middleRows<3>(3 * p) +=
          w.weight * by_points.middleRows<3>(3 * index[std::size_t(w.node)]);
  for (std::size_t i = 0; i < patch.coarse_node.size(); i++)
    result.response.middleRows<3>(3 * Eigen::Index(i)) =
        by_points.middleRows<3>(3 * index[std::size_t(patch.coarse_node[i])]);
  return result;
}

/// The patch linearized where `u` is the solution for these forces.
Patch linearized(const NonlinearPatch& nonlinear, const Cholesky& factor, std::span<const double> forces) {
  Patch patch = nonlinear.patch;
  const Compliance found = compliance_of(nonlinear, factor);
  const Eigen::Index n = found.points.rows();
  const DenseMatrix symmetric = (found.points + found.points.transpose()) / 2;
  patch.compliance.assign(symmetric.data(), symmetric.data() + n * n);
  // displacement without forces
  const Eigen::Map<const Eigen::VectorXd> f(forces.data(), n);
  const Eigen::VectorXd by_forces = symmetric * f;
  patch.shift = point_displacements(nonlinear);
  for (std::size_t p = 0; p < patch.shift.size(); p++)
    for (int i = 0; i < 3; i++) patch.shift[p][i] -= by_forces[Eigen::Index(3 * p) + i];
  // coarse vertices
  LinearizedSystem system{
      {}, {found.response.data(), found.response.data() + found.response.size()}, nonlinear.coarse_stiffness};
  const Eigen::VectorXd of_forces = found.response * f;
  for (std::size_t i = 0; i < nonlinear.coarse_node.size(); i++)
    for (std::size_t k = 0; k < 3; k++)
      system.motion.push_back(nonlinear.u[3 * std::size_t(nonlinear.coarse_node[i]) + k] -
                              of_forces[Eigen::Index(3 * i + k)]);
  patch.system = std::move(system);
  add_levels(patch);
  return patch;
}

}  // namespace

Result<NonlinearPatch> make_nonlinear_patch(const Model& model, const Patch& linear, int refinement,
                                            const Law& law) {
  if (model.params.formulation == Formulation::kAveraged && model.body.mesh.corners != 10)
    return Error{
        "a law is computed for standard elements: expected quadratic tetrahedra or formulation = "
        "\"standard\", found \"averaged\""};
  if (model.params.density > 0) return Error{"a law is computed for a body that fixed vertices hold"};
  TURGOR_ASSERT(law.stiffening >= 0, "a law stiffens");
  NonlinearPatch patch;
  patch.law = law, patch.patch.elements = linear.elements, patch.patch.points = linear.points;
  patch.patch.triangles = linear.triangles;
  patch.patch.local_nodes = linear.local_nodes;
  // unknowns, elements and exterior
  const FineMesh fine = refine(model, linear.elements, refinement);
  list_coarse(model, patch);
  number_nodes(model, fine, patch);
  list_elements(model, fine, patch);
  find_points(fine, patch);
  if (const Status status = condense_exterior(model, patch); !status) return status.error();
  // tangent at rest
  plan_tangent(patch);
  assemble_nonlinear(patch, nullptr);
  patch.lifted = patch.tangent.value;
  return patch;
}

Result<Patch> solve_nonlinear(NonlinearPatch& patch, std::span<const double> forces, int most_steps,
                              NonlinearReport* report) {
  TURGOR_ASSERT(forces.size() == 3 * patch.point.size(), "three numbers a point");
  constexpr double kBalanced = 1e-6, kSettled = 1e-2;  // of the largest forces
  const std::vector<double> f = nodal_forces(patch, forces);
  const double scale = patch.largest_force = std::max(patch.largest_force, norm_of(f));
  NonlinearReport found;
  std::optional<Cholesky> factor;
  for (int i = 0; i < std::max(1, most_steps); i++) {
    // residual and tangent
    std::vector<double> step(f.size());
    found = assemble_nonlinear(patch, &step);
    for (std::size_t k = 0; k < f.size(); k++) step[k] = f[k] - step[k];
    found.steps = i, found.residual = norm_of(step), found.converged = found.residual <= kSettled * scale;
    const bool is_balanced = found.residual <= kBalanced * scale;
    if (factor && is_balanced) break;
    factor = factor_tangent(patch);
    if (!factor) return Error{"the tangent of the patch is not positive definite"};
    // Newton step
    const std::vector<double> residual = step;
    solve(*factor, step);
    double slope = 0;
    for (std::size_t k = 0; k < step.size(); k++) slope -= residual[k] * step[k];
    found.steps = i + 1;
    if (line_search(patch, step, f, slope) == 0) break;
    if (is_balanced) break;
  }
  if (report) *report = found;
  return linearized(patch, *factor, forces);
}

std::vector<Vec3d> point_displacements(const NonlinearPatch& patch) {
  std::vector<Vec3d> of_points;
  for (const auto& nodes : patch.point) {
    Vec3d sum;
    for (const WeightedNode& w : nodes) {
      const double* u = &patch.u[3 * std::size_t(w.node)];
      sum += w.weight * Vec3d{u[0], u[1], u[2]};
    }
    of_points.push_back(sum);
  }
  return of_points;
}

}  // namespace turgor::sfem
