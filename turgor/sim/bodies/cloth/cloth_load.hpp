// Force of all cloth on one body, in a staggered coupling: the cloth collides with the body's present
// surface, and the body receives the contact forces in the next frame. For a body without inertia this
// oscillates with growing amplitude if the cloth sinks by more than g h²/4 per frame. Changes of the force
// are therefore under-relaxed, the more the softer the body is (docs/models/cloth.md).
#pragma once

#include <span>
#include <vector>

#include "turgor/contact/viscosity.hpp"

namespace turgor {

/// Largest relaxation of a body without inertia. Between a tool and such a body, the force of a sheet of any
/// mass may return up to 1.4 times as large one frame later. A relaxation p is stable for p (1 + 1.4) < 2.
constexpr double kLargestRelaxation = 0.25;

struct ClothLoad {
  std::vector<contact::VertexForce>
      force;  // relaxed force on the body, ascending by vertex (by slot for a lattice)
  double relaxation =
      0.1;  // under-relaxation of changes of the force per frame [1]; small until compliances are known
  Vec3d compliance;   // largest displacement per sum of forces along x, y and z [m/N]
  int next_axis = 0;  // axis whose compliance is measured next
};

/// Forces of all cloth on a body in a frame, and of attachments and bodies on a lattice or chains.
struct ClothForces {
  std::vector<contact::VertexForce> force;   // on its vertices, unordered
  std::vector<contact::VertexForce> solved;  // on chains: forces of attachments and bodies to which they have
                                             // yielded already, not to be relaxed
  double mass = 0;                           // of all cloth in contact with it [kg]
  double stiffness = 0;      // of attachments and touching bodies that push back when it yields [N/m]
  bool moves_whole = false;  // a lattice whose motion as a whole follows `force` at once (free_lattice.hpp)
};

/// Relaxes the load toward the forces of the latest frame.
void relax_toward(const ClothForces& forces, ClothLoad& load);
/// Forces of the same magnitudes along an axis.
std::vector<contact::VertexForce> forces_along(const ClothLoad& load, int axis);
/// Sets the relaxation for the next frame, once all three compliances are known.
void choose_relaxation(double mass, double dt, ClothLoad& load);

/// Sum of all forces, and of their magnitudes [N].
Vec3d total_force(const ClothLoad& load);
double sum_of_norms(const ClothLoad& load);

}  // namespace turgor
