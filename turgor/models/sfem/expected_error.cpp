#include "turgor/models/sfem/expected_error.hpp"

#include <array>
#include <cmath>

#include "turgor/core/assert.hpp"
#include "turgor/geometry/quadratic.hpp"

namespace turgor::sfem {

namespace {

constexpr std::array<std::array<int, 2>, 12> kHexEdges{
    {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {4, 5}, {5, 6}, {6, 7}, {7, 4}, {0, 4}, {1, 5}, {2, 6}, {3, 7}}};

/// Error by few nodes below the tool, whose positions relative to the deepest point are random. `size` =
/// distance / contact.
double few_nodes(int corners, double size) {
  return 0.25 * std::pow(size, size < 1 ? 3 : corners == 10 ? 1 : 2);
}

/// Error by elements that are large compared with the bending of the body around the tool. `size` = edge /
/// reach.
double stiffening(int corners, double size) {
  if (corners == 10) return 0.04 * std::pow(size, 4);
  return (corners == 8 ? 0.06 : 0.21) * size * size;
}

/// Factor of both errors for standard elements, which lock near ν = 0.5.
double locking(const TouchedElements& touched) {
  const bool locks = touched.corners != 10 && touched.formulation == Formulation::kStandard;
  return locks ? 1 + 0.11 / (1 - 2 * touched.poisson) : 1;
}

}  // namespace

double mean_edge(const SolidMesh& mesh, std::span<const int> elements) {
  TURGOR_ASSERT(!elements.empty(), "the mean is over at least one element");
  const std::span<const std::array<int, 2>> edges =
      mesh.corners == 8 ? std::span<const std::array<int, 2>>(kHexEdges) : kTetEdges;
  double sum = 0;
  for (const int e : elements)
    for (const auto& [a, b] : edges) {
      const std::span<const int> corners = element(mesh, std::size_t(e));
      const Vec3d along = mesh.vertices[std::size_t(corners[std::size_t(b)])] -
                          mesh.vertices[std::size_t(corners[std::size_t(a)])];
      sum += dot(along, along);
    }
  return std::sqrt(sum / double(edges.size() * elements.size()));
}

TouchedElements touched_elements(const Model& model, std::span<const int> elements, int refinement,
                                 double patch, double contact) {
  TURGOR_ASSERT(!elements.empty(), "a touched patch has elements");
  const std::vector<int>& material = model.body.material;
  const std::size_t kind = material.empty() ? 0 : std::size_t(material[std::size_t(elements.front())]);
  return {.corners = model.body.mesh.corners,
          .formulation = model.params.formulation,
          .poisson = model.body.materials[kind].poisson,
          .edge = mean_edge(model.body.mesh, elements),
          .refinement = refinement,
          .patch = patch,
          .contact = contact};
}

double expected_error(const TouchedElements& touched) {
  TURGOR_CHECK(touched.refinement >= 1, "an edge has at least one part");
  const double nodes = touched.edge / ((touched.corners == 10 ? 2 : 1) * touched.refinement);
  // Coarse elements everywhere, or outside of the patch.
  const double reach = touched.refinement > 1 ? touched.patch : 2 * touched.contact;
  return 0.01 + locking(touched) * (few_nodes(touched.corners, nodes / touched.contact) +
                                    stiffening(touched.corners, touched.edge / reach));
}

}  // namespace turgor::sfem
