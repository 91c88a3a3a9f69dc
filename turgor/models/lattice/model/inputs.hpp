// Inputs and report of one step: gravity, loads and contacts; residual, largest speed and sleeping rows.
#pragma once

#include <span>

#include "turgor/models/lattice/model/state.hpp"

namespace turgor::lattice {

/// External force on one node during a step. Fixed and removed nodes ignore it.
struct NodeLoad {
  int slot = 0;
  Vec3 force;  // along the lattice's axes [N]
};

/// Rigid contact at a node during a step. The node stays beyond a plane with Coulomb friction, or is held at
/// a target. With `other`, the contact is at the midpoint between the node and a neighbor that has the same
/// contact.
struct NodeContact {
  int slot = 0;
  int other = -1;        // slot of that neighbor; -1 = none
  Vec3 normal;           // unit, from the plane to the node, along the axes of the lattice
  Vec3 target;           // displacement at which the node sticks to the plane [m]
  Real friction = 0;     // Coulomb's μ [1]
  bool is_held = false;  // bilateral: held at `target`
  Vec3 force;            // on the node: initial guess before a step, result after it [N]
  Real stiffness = 0;    // penalty stiffness of the last sweep [N/m]
};

struct ContactPoints;
struct HaloExchange;
struct PointSprings;
struct Inputs {
  Vec3d gravity;                          // patient frame [m/s²]
  bool measure_residual = false;          // VBD only; costs about two sweeps
  std::span<const NodeLoad> loads;        // loads of one node add up
  std::span<NodeContact> contacts;        // VBD only; slots ascend, unless they have points
  const ContactPoints* points = nullptr;  // of the contacts, VBD on the host only; null = they act on nodes
  PointSprings* springs = nullptr;        // VBD of a whole body on the host only; null = none
  const HaloExchange* halo = nullptr;     // exchange with other processes; null = the whole body
  // VBD of a body that nothing fixes, on the host only: acceleration of its center besides gravity with which
  // the sweeps start, lattice frame [m/s²]. Sweeps move a whole body slowly.
  Vec3d start_acceleration = {};
  // VBD of a body that nothing fixes, on the host only: balances its momentum after the sweeps
  // (solver/balance_momentum.hpp). Only where nothing but loads and other free bodies acts on it.
  bool balances_momentum = false;
  bool measures_balance = false;  // of such a body: StepReport::unbalanced instead
};

/// Distance of a step from the minimum of its energy: residual forces at the free nodes [N].
struct Residual {
  double largest = 0, rms = 0;
  double before = 0;  // rms before the first sweep; rms/before is the reduction by one step [N]
};

struct StepReport {
  bool finite = true;      // false: the step was undone
  Real largest_speed = 0;  // [m/s]
  Residual residual;       // if requested; PBD has none, since it minimizes no energy
  Vec3d unbalanced;        // if requested: see unbalanced_force (solver/balance_momentum.hpp) [N]
  int rows = 0;            // rows with a free node; 0 if sleep is disabled
  int rows_asleep = 0;     // sleeping rows of these
};

}  // namespace turgor::lattice
