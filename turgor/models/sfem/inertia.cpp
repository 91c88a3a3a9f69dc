#include "turgor/models/sfem/inertia.hpp"

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"

namespace turgor::sfem {

std::vector<double> lumped_masses(const SolidMesh& mesh, double density) {
  std::vector<double> mass(mesh.vertices.size(), 0.0);
  const bool quadratic = mesh.corners == 10;
  for (std::size_t e = 0; e < element_count(mesh); e++) {
    const double whole = density * volume(mesh, e);
    const std::span<const int> nodes = element(mesh, e);
    for (std::size_t n = 0; n < nodes.size(); n++) {
      const double share = quadratic ? (n < 4 ? 1.0 / 36 : 4.0 / 27) : 1.0 / double(nodes.size());
      mass[std::size_t(nodes[n])] += share * whole;
    }
  }
  return mass;
}

void add_inertia(Model& model) {
  TURGOR_ASSERT(model.mass.size() == model.body.mesh.vertices.size(), "every vertex has a mass");
  TURGOR_ASSERT(model.params.time_step > 0, "inertia acts over a time step");
  const double rate = 1 / (model.params.time_step * model.params.time_step);
  BlockMatrix& k = model.stiffness;
  for (std::size_t row = 0; row < model.vertex.size(); row++)
    for (std::size_t b = k.row_begin[row]; b < k.row_begin[row + 1]; b++) {
      if (std::size_t(k.column[b]) != row) continue;
      const double m = model.mass[std::size_t(model.vertex[row])] * rate;
      for (std::size_t axis = 0; axis < 3; axis++) k.value[9 * b + 4 * axis] += m;
    }
}

}  // namespace turgor::sfem
