// Green's functions between all vertices of some elements, also deep inside of a body, where the store of
// Green (sfem.hpp) has none. Forces on points inside of these elements displace points inside of them: a
// needle is coupled to the body with it. Solved from the factor, outside of a haptic tick; reading does not
// allocate.
//
//     C(p, q) = Σ_a Σ_b N_a(p) Ξ_ab N_b(q)        (N: shape functions of the elements of p and q)
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/core/progress.hpp"
#include "turgor/core/vec.hpp"
#include "turgor/models/sfem/sfem.hpp"

namespace turgor::sfem {

/// Some elements of a body and Ξ between their vertices. Indices refer to the lists here, not to the mesh.
struct InnerGreen {
  int corners = 4;            // vertices of an element: 4, 8 or 10
  std::vector<int> elements;  // of the mesh, ascending
  std::vector<int> vertices;  // of the mesh, ascending
  std::vector<int> corner;    // `corners` indices into `vertices` per element
  std::vector<Vec3d> x;       // rest position of each vertex [m]
  std::vector<float> green;  // 3×3 blocks of Ξ, column-major, block (row, column) at row·count + column [m/N]
  std::vector<Int3> surface;  // triangles of the body's surface, of `vertices`
  std::vector<int> behind;    // index into `elements` of the element behind each of them
  std::vector<int> material;  // of each element, index into Body::materials
  std::vector<double>
      toughness;              // of each element, set by the caller; negative or empty: a needle's own [J/m²]
  std::vector<double> shear;  // modulus of each element [Pa]
  std::vector<double> poisson;  // ratio of each element [1]
  std::vector<double> size;     // of each element: edge of the cube of the same volume [m]
};

/// Point inside of an element.
struct InnerPoint {
  int element = -1;                 // index into InnerGreen::elements
  std::array<double, 10> weight{};  // of the element's vertices
};

/// 3×3 block: displacement of one point under unit forces on another, column-major [m/N].
using ComplianceBlock = std::array<double, 9>;

/// Memory of Ξ between this many vertices [bytes].
std::size_t inner_green_bytes(std::size_t vertices);

/// Solves Ξ between the vertices of these elements of the mesh (ascending). The model has a factor.
InnerGreen make_inner_green(const Exec& exec, const Model& model, std::vector<int> elements,
                            const Progress& progress = {});

/// Point at a rest position: in the element `first` if it contains it, else in the element that contains it,
/// else extrapolated from the element that nearly does. `outside` is how far the position is outside of that
/// element, relative to its size; 0 = inside.
InnerPoint inner_point(const InnerGreen& inner, Vec3d rest, int first, double& outside);

/// Displacement of `p` under unit forces on `q`.
ComplianceBlock compliance_between(const InnerGreen& inner, const InnerPoint& p, const InnerPoint& q);

/// Displacement of `p` under unit forces on each vertex; 9 numbers a vertex, as in ComplianceBlock.
void compliance_row(const InnerGreen& inner, const InnerPoint& p, std::span<double> row);
/// compliance_between of the row's point and `q`.
ComplianceBlock compliance_in_row(const InnerGreen& inner, std::span<const double> row, const InnerPoint& q);
/// Displacement of the vertices of an element under forces on all vertices [m].
std::array<Vec3d, 10> corner_displacements(const InnerGreen& inner, int element,
                                           std::span<const Vec3d> forces);

/// Interpolation of a quantity at the vertices to a point.
Vec3d at_point(const InnerGreen& inner, const InnerPoint& p, std::span<const Vec3d> of_vertices);
/// Distributes a force on a point to the vertices of its element.
void add_force(const InnerGreen& inner, const InnerPoint& p, Vec3d force, std::span<Vec3d> of_vertices);

}  // namespace turgor::sfem
