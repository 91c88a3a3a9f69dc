#include "turgor/models/sfem/patch.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numeric>
#include <string>

#include "turgor/core/assert.hpp"
#include "turgor/models/sfem/elements.hpp"
#include "turgor/models/sfem/green.hpp"
#include "turgor/models/sfem/patch_assembly.hpp"

namespace turgor::sfem {

namespace {

template <class T>
using Matrix = Eigen::Matrix<T, Eigen::Dynamic, Eigen::Dynamic>;
template <class T>
using Map = Eigen::Map<Matrix<T>>;
template <class T>
using ConstMap = Eigen::Map<const Matrix<T>>;

/// The fine triangles that a touch can reach without leaving the patch's outer surface.
std::vector<Int3> touched_triangles(const FineMesh& fine, std::span<const Vec3d> touches) {
  if (touches.empty()) return fine.outer;
  std::vector<int> piece(fine.nodes.size());  // smallest node of the piece each belongs to
  std::iota(piece.begin(), piece.end(), 0);
  for (bool changed = true; changed;) {
    changed = false;
    for (const auto [a, b, c] : fine.outer) {
      const int least = std::min({piece[std::size_t(a)], piece[std::size_t(b)], piece[std::size_t(c)]});
      for (const int node : {a, b, c}) {
        changed = changed || piece[std::size_t(node)] != least;
        piece[std::size_t(node)] = least;
      }
    }
  }
  std::vector<int> wanted;
  for (const Vec3d touch : touches) {
    double nearest = std::numeric_limits<double>::max();
    int found = -1;
    for (const Int3 t : fine.outer)
      for (const int node : {t.x, t.y, t.z})
        if (const Vec3d d = fine.nodes[std::size_t(node)].x - touch; dot(d, d) < nearest)
          nearest = dot(d, d), found = node;
    if (found >= 0) wanted.push_back(piece[std::size_t(found)]);
  }
  std::vector<Int3> triangles;
  for (const Int3 t : fine.outer)
    if (std::find(wanted.begin(), wanted.end(), piece[std::size_t(t.x)]) != wanted.end())
      triangles.push_back(t);
  return triangles;
}

/// Nodes of the triangles, ascending.
std::vector<int> nodes_of(const std::vector<Int3>& triangles) {
  std::vector<int> nodes;
  for (const auto [a, b, c] : triangles) nodes.insert(nodes.end(), {a, b, c});
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  return nodes;
}

PatchUnknowns number_unknowns(const Model& model, std::span<const int> elements, const FineMesh& fine,
                              const std::vector<int>& touched, bool with_change) {
  PatchUnknowns unknowns;
  const SolidMesh& mesh = model.body.mesh;
  const std::vector<int> taking_part =
      with_change ? changed_elements(model, elements) : std::vector<int>(elements.begin(), elements.end());
  for (const int e : taking_part)
    for (const int v : element(mesh, std::size_t(e)))
      if (model.free_node[std::size_t(v)] >= 0) unknowns.coarse.push_back(v);
  std::sort(unknowns.coarse.begin(), unknowns.coarse.end());
  unknowns.coarse.erase(std::unique(unknowns.coarse.begin(), unknowns.coarse.end()), unknowns.coarse.end());

  unknowns.local.assign(fine.nodes.size(), -1);
  const auto has_own = [&](int node) {
    const FineNode& n = fine.nodes[std::size_t(node)];
    return !n.at_vertex && !n.on_border && !n.fixed;
  };
  for (const bool surface : {false, true}) {
    if (surface) unknowns.first_touched = unknowns.local_count;
    for (int node = 0; node < int(fine.nodes.size()); node++)
      if (has_own(node) && std::binary_search(touched.begin(), touched.end(), node) == surface)
        unknowns.local[std::size_t(node)] = unknowns.local_count++;
  }
  return unknowns;
}

/// Ξ between the coarse vertices. With a change Δ of the coarse stiffness: (K + Δ)⁻¹ = (I + Ξ Δ)⁻¹ Ξ.
template <class T>
Matrix<T> coarse_green(const Model& model, const PatchUnknowns& unknowns, const std::vector<T>& change) {
  const Eigen::Index n = 3 * Eigen::Index(unknowns.coarse.size());
  std::vector<double> values(std::size_t(n * n));
  gather_green(model, unknowns.coarse, values.data());
  const Matrix<double> green = ConstMap<double>(values.data(), n, n);
  if (change.empty()) return green.cast<T>();
  const Matrix<double> delta = ConstMap<T>(change.data(), n, n).template cast<double>();
  Matrix<double> system = green * delta;
  system.diagonal().array() += 1;
  const Matrix<double> changed = system.partialPivLu().solve(green);
  return ((changed + changed.transpose()) / 2).cast<T>();
}

/// Cholesky's factor of the first `n` rows of a, and below it what becomes of the rows that follow: B L⁻ᵀ.
/// Only the lower half of the square part is read and written. Products do nearly all of the work.
template <class T>
bool factor_with_rows(Matrix<T>& a, Eigen::Index n) {
  constexpr Eigen::Index kBlock = 24;
  Matrix<T> below, inverse;
  for (Eigen::Index k = 0; k < n; k += kBlock) {
    const Eigen::Index b = std::min(kBlock, n - k), rest = a.rows() - k - b;
    a.block(k, k, a.rows() - k, b).noalias() -=
        a.block(k, 0, a.rows() - k, k) * a.block(k, 0, b, k).transpose();
    auto pivot = a.block(k, k, b, b);
    Eigen::LLT<Eigen::Ref<Matrix<T>, 0, Eigen::OuterStride<>>> factored(pivot);
    if (factored.info() != Eigen::Success) return false;
    inverse.setIdentity(b, b);
    pivot.template triangularView<Eigen::Lower>().solveInPlace(inverse);
    below.noalias() = a.block(k + b, k, rest, b) * inverse.transpose();
    a.block(k + b, k, rest, b) = below;
  }
  return true;
}

/// S = K_L − K_LG Ξ K_GL and its Cholesky factor; below it Zᵀ = (L⁻¹ Ψ)ᵀ of some coarse vertices, Ψ = K_LG Ξ.
template <class T>
struct Elimination {
  Matrix<T> green, factor;
  bool definite = true;  // as that of a held body is, unless rounding hides it
};

template <class T>
Elimination<T> eliminate(const Model& model, const PatchUnknowns& unknowns, const PatchMatrices<T>& matrices,
                         const std::vector<int>& wanted) {
  const Eigen::Index local = 3 * unknowns.local_count, coarse = 3 * Eigen::Index(unknowns.coarse.size());
  Elimination<T> e;
  e.green = coarse_green(model, unknowns, matrices.change);
  if (local == 0) return e;
  const ConstMap<T> coupling(matrices.coupling.data(), local, coarse);
  const Matrix<T> psi = coupling * e.green;
  e.factor.resize(local + 3 * Eigen::Index(wanted.size()), local);
  e.factor.topRows(local) = ConstMap<T>(matrices.local.data(), local, local);
  e.factor.topRows(local).template triangularView<Eigen::Lower>() -= psi * coupling.transpose();
  for (std::size_t i = 0; i < wanted.size(); i++)
    e.factor.template middleRows<3>(local + 3 * Eigen::Index(i)) =
        psi.template middleCols<3>(3 * wanted[i]).transpose();
  e.definite = factor_with_rows(e.factor, local);
  return e;
}

/// Compliance between the functions that move the touched surface: coarse ones first, then local ones. Blocks
/// of the inverse of the coupled system, read from the end of the factor.
template <class T>
Matrix<T> function_compliance(const Elimination<T>& e, const std::vector<int>& coarse,
                              const PatchUnknowns& unknowns) {
  const Eigen::Index local = 3 * unknowns.local_count, c = 3 * Eigen::Index(coarse.size());
  const Eigen::Index s = local - 3 * unknowns.first_touched;  // touched local unknowns are the last
  Matrix<T> compliance(c + s, c + s);
  for (std::size_t i = 0; i < coarse.size(); i++)
    for (std::size_t k = 0; k < coarse.size(); k++)
      compliance.template block<3, 3>(3 * Eigen::Index(k), 3 * Eigen::Index(i)) =
          e.green.template block<3, 3>(3 * coarse[k], 3 * coarse[i]);
  if (local == 0) return compliance;
  const auto z = e.factor.bottomRows(c);                          // transposed
  compliance.topLeftCorner(c, c).noalias() += z * z.transpose();  // Ξ_GG = Ξ + Ψᵀ S⁻¹ Ψ
  Matrix<T> inverse = Matrix<T>::Identity(s, s);
  e.factor.block(local - s, local - s, s, s).template triangularView<Eigen::Lower>().solveInPlace(inverse);
  compliance.topRightCorner(c, s).noalias() = -(z.rightCols(s) * inverse);  // Ξ_GL = −Ψᵀ S⁻¹
  compliance.bottomLeftCorner(s, c) = compliance.topRightCorner(c, s).transpose();
  compliance.bottomRightCorner(s, s).noalias() =  // Ξ_LL = S⁻¹
      inverse.transpose().template triangularView<Eigen::Upper>() * inverse;
  return compliance;
}

/// The points of the patch: touched fine nodes with what they hang on.
void make_points(const FineMesh& fine, const PatchUnknowns& unknowns, const std::vector<int>& touched,
                 const std::vector<Int3>& triangles, Patch& patch) {
  std::vector<int> number(fine.nodes.size(), -1);
  for (const int node : touched) {
    number[std::size_t(node)] = int(patch.points.size());
    const FineNode& from = fine.nodes[std::size_t(node)];
    PatchPoint point{from.x, from.key};
    TURGOR_ASSERT(from.supports <= int(point.coarse.size()), "a surface point hangs on one face");
    point.supports = from.supports, point.local = unknowns.local[std::size_t(node)];
    for (std::size_t s = 0; s < std::size_t(from.supports); s++) {
      const auto at = std::lower_bound(unknowns.coarse.begin(), unknowns.coarse.end(), from.coarse[s]);
      point.coarse[s] = int(at - unknowns.coarse.begin()), point.weight[s] = from.weight[s];
    }
    patch.points.push_back(point);
  }
  for (const auto [a, b, c] : triangles)
    patch.triangles.push_back({number[std::size_t(a)], number[std::size_t(b)], number[std::size_t(c)]});
}

/// One side of P B Pᵀ, transposed: columns of `from` are functions, columns of the result points.
template <class T>
Matrix<T> expand(const Patch& patch, const std::vector<int>& place, int first_touched, Eigen::Index coarse,
                 const Matrix<T>& from) {
  Matrix<T> result(from.rows(), 3 * Eigen::Index(patch.points.size()));
  for (std::size_t p = 0; p < patch.points.size(); p++) {
    const PatchPoint& point = patch.points[p];
    auto columns = result.template middleCols<3>(3 * Eigen::Index(p));
    columns.setZero();
    for (std::size_t s = 0; s < std::size_t(point.supports); s++)
      columns += T(point.weight[s]) * from.template middleCols<3>(3 * place[std::size_t(point.coarse[s])]);
    if (point.local >= 0) columns += from.template middleCols<3>(coarse + 3 * (point.local - first_touched));
  }
  return result;
}

/// False when the numbers of T are too few.
template <class T>
bool condense(const Model& model, std::span<const int> elements, const FineMesh& fine,
              const PatchUnknowns& unknowns, bool with_change, Patch& patch) {
  PatchMatrices<T> matrices = assemble_patch<T>(model, elements, fine, unknowns, with_change);
  std::vector<int> place(unknowns.coarse.size(), -1), coarse;  // coarse functions that move the points
  for (const PatchPoint& point : patch.points)
    for (std::size_t s = 0; s < std::size_t(point.supports); s++)
      if (int& at = place[std::size_t(point.coarse[s])]; at < 0)
        at = int(coarse.size()), coarse.push_back(point.coarse[s]);
  const Eigen::Index coarse_rows = 3 * Eigen::Index(coarse.size()), n = 3 * Eigen::Index(patch.points.size());
  const Elimination<T> e = eliminate(model, unknowns, matrices, coarse);
  if (!e.definite) return false;
  const Matrix<T> functions = function_compliance(e, coarse, unknowns);
  const Matrix<T> half = expand(patch, place, unknowns.first_touched, coarse_rows, functions).transpose();
  const Matrix<T> full = expand(patch, place, unknowns.first_touched, coarse_rows, half);
  patch.compliance.resize(std::size_t(n * n));
  Map<double>(patch.compliance.data(), n, n) = full.template cast<double>();

  const Eigen::Index local = 3 * unknowns.local_count;
  Map<T>(matrices.local.data(), local, local) = e.factor.topRows(local);
  patch.system = CondensedSystem<T>{std::move(matrices.local),
                                    std::move(matrices.coupling),
                                    {e.green.data(), e.green.data() + e.green.size()},
                                    std::move(matrices.change)};
  return std::all_of(patch.compliance.begin(), patch.compliance.end(),
                     [](double c) { return std::isfinite(c); });
}

template <class T>
std::vector<double> coarse_forces_of(const Patch& patch, const CondensedSystem<T>& system,
                                     std::span<const double> forces) {
  using Vector = Eigen::Matrix<T, Eigen::Dynamic, 1>;
  const Eigen::Index local = 3 * patch.local_nodes, coarse = 3 * Eigen::Index(patch.coarse.size());
  Vector on_local = Vector::Zero(local), on_coarse = Vector::Zero(coarse);
  for (std::size_t p = 0; p < patch.points.size(); p++) {
    const PatchPoint& point = patch.points[p];
    const Eigen::Matrix<T, 3, 1> f(static_cast<T>(forces[3 * p]), static_cast<T>(forces[3 * p + 1]),
                                   static_cast<T>(forces[3 * p + 2]));
    for (std::size_t s = 0; s < std::size_t(point.supports); s++)
      on_coarse.template segment<3>(3 * point.coarse[s]) += T(point.weight[s]) * f;
    if (point.local >= 0) on_local.template segment<3>(3 * point.local) += f;
  }
  const ConstMap<T> factor(system.factor.data(), local, local), green(system.green.data(), coarse, coarse);
  const ConstMap<T> coupling(system.coupling.data(), local, coarse);
  if (local > 0) {  // u_L = S⁻¹ (f_L − Ψ f_G); the coarse body feels f_G − K_GL u_L
    on_local -= coupling * (green * on_coarse);
    factor.template triangularView<Eigen::Lower>().solveInPlace(on_local);
    factor.transpose().template triangularView<Eigen::Upper>().solveInPlace(on_local);
    on_coarse -= coupling.transpose() * on_local;
  }
  if (!system.change.empty())  // (K + Δ) u = f as K u = f − Δ u
    on_coarse -= (ConstMap<T>(system.change.data(), coarse, coarse) * (green * on_coarse)).eval();
  return {on_coarse.data(), on_coarse.data() + coarse};
}

/// Elements around the free surface vertex nearest to a place.
void elements_at(const Model& model, Vec3d touch, std::vector<int>& found) {
  const SolidMesh& mesh = model.body.mesh;
  int nearest = -1;
  double least = std::numeric_limits<double>::max();
  for (std::size_t i = 0; i < model.green.surface_count; i++) {
    const Vec3d d = mesh.vertices[std::size_t(model.green.nodes[i])] - touch;
    if (dot(d, d) < least) least = dot(d, d), nearest = model.green.nodes[i];
  }
  for (std::size_t t = 0; t < model.surface.triangles.size(); t++) {
    const Int3 v = model.surface.triangles[t];
    if (v.x == nearest || v.y == nearest || v.z == nearest) found.push_back(model.surface.element[t]);
  }
}

/// Elements that may be in a patch: all vertices whose stiffness the patch changes have Green's functions.
std::vector<char> usable_elements(const Model& model) {
  const SolidMesh& mesh = model.body.mesh;
  const bool by_node = averages_nodes(mesh, model.params.formulation);
  std::vector<char> usable(element_count(mesh)), vertex_usable(mesh.vertices.size(), 1);
  for (std::size_t e = 0; e < usable.size(); e++) {
    const auto corners = element(mesh, e);
    usable[e] = std::all_of(corners.begin(), corners.end(), [&](int v) {
      return model.free_node[std::size_t(v)] < 0 || model.green.slot[std::size_t(v)] >= 0;
    });
    if (by_node && !usable[e])
      for (const int v : corners) vertex_usable[std::size_t(v)] = 0;
  }
  for (std::size_t e = 0; by_node && e < usable.size(); e++)
    for (const int v : element(mesh, e)) usable[e] = usable[e] && vertex_usable[std::size_t(v)];
  return usable;
}

PatchCost cost_of(const PatchUnknowns& unknowns, std::size_t points, Precision precision) {
  const double local = 3.0 * unknowns.local_count, coarse = 3.0 * double(unknowns.coarse.size()),
               n = 3.0 * double(points);
  const double number = precision == Precision::kSingle ? 4 : 8;
  const double system = 2 * local * local + 4 * local * coarse;  // K_L and S, K_LG, Ψ, Z
  const double green = 2 * coarse * coarse, surface = 4 * n * n;
  const double levels = 3 * n * n * 8;  // Ξ of the points, and of their clusters
  return {.local_nodes = std::size_t(unknowns.local_count),
          .points = points,
          .bytes = number * (system + green + surface) + 8 * 3 * coarse * coarse + levels,
          .flops = local * local * local / 3 + 2 * local * coarse * (local + coarse) + 2 * n * n * n};
}

Error too_large(const PatchCost& cost, std::size_t elements, int refinement, std::size_t most_bytes) {
  const auto text = [](double value) {
    char digits[32];
    std::snprintf(digits, sizeof digits, "%.3g", value);
    return std::string(digits);
  };
  return Error{"a patch of " + std::to_string(elements) + " elements, each edge in " +
               std::to_string(refinement) + " parts, has " + std::to_string(cost.local_nodes) +
               " nodes of its own and would take " + text(cost.bytes * 1e-9) + " GB and " +
               text(cost.flops * 1e-9) + " thousand million operations, allowed are " +
               text(double(most_bytes) * 1e-9) +
               " GB: a smaller patch.radius, a lower patch.refinement or more memory"};
}

}  // namespace

std::vector<int> patch_elements(const Model& model, std::span<const Vec3d> touches, double radius) {
  const SolidMesh& mesh = model.body.mesh;
  const std::size_t faces = element_faces(mesh).size();
  std::vector<int> found;
  const std::vector<char> usable = usable_elements(model);
  std::vector<char> seen(element_count(mesh), 0);
  for (const Vec3d touch : touches) elements_at(model, touch, found);
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  for (const int e : found) seen[std::size_t(e)] = 1;
  const auto is_near = [&](int e) {
    const Vec3d x = centroid(mesh, std::size_t(e));
    return std::any_of(touches.begin(), touches.end(), [&](Vec3d touch) { return norm(x - touch) < radius; });
  };
  for (std::size_t i = 0; i < found.size(); i++)
    for (std::size_t f = 0; f < faces; f++) {
      const int across = model.neighbours[std::size_t(found[i]) * faces + f];
      if (across < 0 || seen[std::size_t(across)]) continue;
      seen[std::size_t(across)] = 1;
      if (is_near(across) && usable[std::size_t(across)]) found.push_back(across);
    }
  std::sort(found.begin(), found.end());
  return found;
}

PatchCost patch_cost(const Model& model, std::span<const int> elements, int refinement,
                     std::span<const Vec3d> touches) {
  const FineMesh fine = refine(model, elements, refinement);
  const std::vector<int> touched = nodes_of(touched_triangles(fine, touches));
  const bool with_change = refinement > 1 && changes_stiffness(model, elements, fine);
  const PatchUnknowns unknowns = number_unknowns(model, elements, fine, touched, with_change);
  return cost_of(unknowns, touched.size(), model.params.precision);
}

Result<Patch> build_patch(const Model& model, std::span<const int> elements, int refinement,
                          std::span<const Vec3d> touches, std::size_t most_bytes) {
  const FineMesh fine = refine(model, elements, refinement);
  const std::vector<Int3> triangles = touched_triangles(fine, touches);
  const std::vector<int> touched = nodes_of(triangles);
  const bool with_change = refinement > 1 && changes_stiffness(model, elements, fine);
  const PatchUnknowns unknowns = number_unknowns(model, elements, fine, touched, with_change);
  Patch patch;
  patch.elements.assign(elements.begin(), elements.end());
  patch.coarse = unknowns.coarse;
  patch.local_nodes = unknowns.local_count;
  make_points(fine, unknowns, touched, triangles, patch);
  bool done = false;
  for (const Precision precision : {Precision::kSingle, Precision::kDouble}) {
    if (done || precision < model.params.precision) continue;
    const PatchCost cost = cost_of(unknowns, touched.size(), precision);
    if (cost.bytes > double(most_bytes)) return too_large(cost, elements.size(), refinement, most_bytes);
    done = precision == Precision::kSingle
               ? condense<float>(model, elements, fine, unknowns, with_change, patch)
               : condense<double>(model, elements, fine, unknowns, with_change, patch);
  }
  if (!done)
    return Error{
        "the patch's stiffness is lost to rounding: expected Poisson's ratios farther below 0.5, or "
        "elements that are less flat"};
  add_levels(patch);
  return patch;
}

std::vector<double> coarse_forces(const Patch& patch, std::span<const double> forces) {
  TURGOR_ASSERT(forces.size() == 3 * patch.points.size(), "three numbers a point");
  return std::visit([&](const auto& system) { return coarse_forces_of(patch, system, forces); },
                    patch.system);
}

}  // namespace turgor::sfem
