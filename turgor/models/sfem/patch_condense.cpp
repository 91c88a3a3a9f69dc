#include "turgor/models/sfem/patch_condense.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>

#include "turgor/core/assert.hpp"
#include "turgor/models/sfem/green.hpp"
#include "turgor/models/sfem/patch_interior.hpp"

namespace turgor::sfem {

namespace {

template <class T>
using Matrix = Eigen::Matrix<T, Eigen::Dynamic, Eigen::Dynamic>;
template <class T>
using Map = Eigen::Map<Matrix<T>>;
template <class T>
using ConstMap = Eigen::Map<const Matrix<T>>;

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

/// Cholesky factor of the first `n` rows of a, and B L⁻ᵀ for the rows B below. Only the lower half of the
/// square part is read and written. Nearly all of the work is products.
template <class T>
bool factor_with_rows(Matrix<T>& a, Eigen::Index n) {
  constexpr Eigen::Index kBlock = 24;
  Matrix<T> below, inverse;
  for (Eigen::Index k = 0; k < n; k += kBlock) {
    const Eigen::Index b = std::min(kBlock, n - k), rest = a.rows() - k - b;
    // subtract the columns before
    a.block(k, k, a.rows() - k, b).noalias() -=
        a.block(k, 0, a.rows() - k, k) * a.block(k, 0, b, k).transpose();
    // factor the pivot block
    auto pivot = a.block(k, k, b, b);
    Eigen::LLT<Eigen::Ref<Matrix<T>, 0, Eigen::OuterStride<>>> factored(pivot);
    if (factored.info() != Eigen::Success) return false;
    // rows below: multiply by the inverse
    inverse.setIdentity(b, b);
    pivot.template triangularView<Eigen::Lower>().solveInPlace(inverse);
    below.noalias() = a.block(k + b, k, rest, b) * inverse.transpose();
    a.block(k + b, k, rest, b) = below;
  }
  return true;
}

/// S = K_L − K_LG Ξ K_GL and its Cholesky factor; below it Zᵀ = (L⁻¹ Ψ)ᵀ of some coarse vertices, Ψ = K_LG Ξ.
template <class T>
struct Eliminated {
  Matrix<T> green, factor;
  bool definite = true;  // as that of a held body is, unless rounding hides it
};

template <class T>
Eliminated<T> eliminate(const Model& model, const PatchUnknowns& unknowns, const PatchMatrices<T>& matrices,
                        const std::vector<int>& wanted) {
  const Eigen::Index local = 3 * unknowns.local_count, coarse = 3 * Eigen::Index(unknowns.coarse.size());
  Eliminated<T> e;
  e.green = coarse_green(model, unknowns, matrices.change);
  if (local == 0) return e;
  TURGOR_CHECK(matrices.coupling.size() == std::size_t(local * coarse),
               "the coupling has a row for every local function");
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
Matrix<T> function_compliance(const Eliminated<T>& e, const std::vector<int>& coarse,
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

/// One side of P B Pᵀ, transposed: columns of `from` are functions, columns of the result points.
template <class T>
Matrix<T> expand(const Patch& patch, const std::vector<int>& position, int first_touched, Eigen::Index coarse,
                 const Matrix<T>& from) {
  Matrix<T> result(from.rows(), 3 * Eigen::Index(patch.points.size()));
  for (std::size_t p = 0; p < patch.points.size(); p++) {
    const PatchPoint& point = patch.points[p];
    auto columns = result.template middleCols<3>(3 * Eigen::Index(p));
    columns.setZero();
    for (std::size_t s = 0; s < std::size_t(point.supports); s++)
      columns += T(point.weight[s]) * from.template middleCols<3>(3 * position[std::size_t(point.coarse[s])]);
    if (point.local >= 0) columns += from.template middleCols<3>(coarse + 3 * (point.local - first_touched));
  }
  return result;
}

template <class T>
std::vector<double> coarse_forces_of(const Patch& patch, const CondensedSystem<T>& system,
                                     std::span<const double> forces) {
  using Vector = Eigen::Matrix<T, Eigen::Dynamic, 1>;
  const Eigen::Index local = 3 * patch.surface_nodes, coarse = 3 * Eigen::Index(patch.coarse.size());
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

std::vector<double> coarse_forces_of(const Patch& patch, const LinearizedSystem& system,
                                     std::span<const double> forces) {
  const Eigen::Index coarse = 3 * Eigen::Index(patch.coarse.size()),
                     points = 3 * Eigen::Index(patch.points.size());
  const Eigen::Map<const Eigen::VectorXd> motion(system.motion.data(), coarse), f(forces.data(), points);
  const ConstMap<double> response(system.response.data(), coarse, points);
  const ConstMap<double> stiffness(system.stiffness.data(), coarse, coarse);
  const Eigen::VectorXd on_coarse = stiffness * (motion + response * f);
  return {on_coarse.data(), on_coarse.data() + coarse};
}

template <class T>
std::vector<T> rounded(const std::vector<double>& values) {
  return {values.begin(), values.end()};
}

/// Matrices of the local functions. Where possible those below the surface are eliminated, and `unknowns` is
/// numbered without them. None if rounding hides that the matrix is positive definite.
template <class T>
std::optional<PatchMatrices<T>> reduced(const Model& model, std::span<const int> elements,
                                        const FineMesh& fine, bool with_change, PatchUnknowns& unknowns) {
  if (!has_free_interior(model, unknowns))
    return assemble_patch<T>(model, elements, fine, unknowns, with_change);
  const auto matrices = without_interior(model, elements, fine, unknowns, with_change);
  if (!matrices) return {};
  unknowns.local_count -= unknowns.first_touched, unknowns.first_touched = 0;
  return PatchMatrices<T>{rounded<T>(matrices->local), rounded<T>(matrices->coupling),
                          rounded<T>(matrices->change)};
}

}  // namespace

template <class T>
bool condense(const Model& model, std::span<const int> elements, const FineMesh& fine,
              const PatchUnknowns& all_unknowns, bool with_change, Patch& patch) {
  PatchUnknowns unknowns = all_unknowns;
  std::optional<PatchMatrices<T>> found = reduced<T>(model, elements, fine, with_change, unknowns);
  if (!found) return false;
  PatchMatrices<T>& matrices = *found;
  std::vector<int> position(unknowns.coarse.size(), -1), coarse;  // coarse functions that move the points
  for (const PatchPoint& point : patch.points)
    for (std::size_t s = 0; s < std::size_t(point.supports); s++)
      if (int& at = position[std::size_t(point.coarse[s])]; at < 0)
        at = int(coarse.size()), coarse.push_back(point.coarse[s]);
  const Eigen::Index coarse_rows = 3 * Eigen::Index(coarse.size()), n = 3 * Eigen::Index(patch.points.size());
  const Eliminated<T> e = eliminate(model, unknowns, matrices, coarse);
  if (!e.definite) return false;
  const Matrix<T> functions = function_compliance(e, coarse, unknowns);
  const Matrix<T> half = expand(patch, position, unknowns.first_touched, coarse_rows, functions).transpose();
  const Matrix<T> full = expand(patch, position, unknowns.first_touched, coarse_rows, half);
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

template bool condense<float>(const Model&, std::span<const int>, const FineMesh&, const PatchUnknowns&, bool,
                              Patch&);
template bool condense<double>(const Model&, std::span<const int>, const FineMesh&, const PatchUnknowns&,
                               bool, Patch&);

std::vector<double> coarse_forces(const Patch& patch, std::span<const double> forces) {
  TURGOR_ASSERT(forces.size() == 3 * patch.points.size(), "three numbers a point");
  return std::visit([&](const auto& system) { return coarse_forces_of(patch, system, forces); },
                    patch.system);
}

}  // namespace turgor::sfem
