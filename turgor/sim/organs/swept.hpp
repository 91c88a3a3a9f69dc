// Contacts and attachments of a lattice with another lattice, chains, a fixed rigid body or the ground. Their
// forces are solved in the sweeps of one of the two bodies, the swept one. Its surface nodes stay beyond
// planes with Coulomb friction (lattice::NodeContact), and its springs act at nodes (lattice::PointSpring).
// In a body with partial cells both act in the cells that carry the surface (lattice::ContactPoints). The
// other body is where its velocity takes it in the frame. It bears the opposite forces from the next frame
// on, relaxed like those of cloth (sim/bodies/cloth/cloth_load.hpp).
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "turgor/models/lattice/mechanics/contact_points.hpp"
#include "turgor/models/lattice/mechanics/point_springs.hpp"
#include "turgor/models/lattice/model/inputs.hpp"
#include "turgor/sim/organs/coupling.hpp"
#include "turgor/sim/organs/swept_start.hpp"

namespace turgor {

struct LatticeBody;

/// Side of the body whose step solves for the forces between two bodies: cloth, else a lattice without fixed
/// nodes before one with fixed nodes, the lighter of two such lattices, and the first before the second. -1:
/// all bodies are solved together. A body that feels forces late is driven by them the more the lighter it
/// is.
int swept_side(const World& world, BodyId body, const std::optional<BodyId>& other);

/// Surface nodes of a lattice that can touch.
SweptNodes swept_nodes(const LatticeBody& body, const CoupledSupport& support);
/// Mass of a lattice that nothing fixes; 0 if something does [kg].
double free_mass(const LatticeBody& body);
/// Bound for the motion of the points of a body in the next frame [m].
double farthest_ahead(const World& world, const CoupledSupport& support);
/// Distances of the nodes of a swept contact from the other body at rest.
std::vector<double> swept_rest_heights(const Exec& exec, const World& world, const BodyContact& contact);

/// Springs of attachments in one step of a lattice, after those of its sutures.
class SweptSprings {
 public:
  /// `stitches` may be null.
  SweptSprings(const LatticeBody& body, World& world, lattice::PointSprings* stitches);
  SweptSprings(const SweptSprings&) = delete;
  SweptSprings& operator=(const SweptSprings&) = delete;
  /// Springs for lattice::Inputs.
  lattice::PointSprings* input() { return ties_.empty() ? stitches_ : &springs_; }
  /// Forces of the last step, if nothing fixes the lattice.
  const SweptForces& before() const { return before_; }
  /// Reads the forces after a step. The most overloaded spring of each attachment breaks.
  void finish(const lattice::Motion& motion);

 private:
  void refresh(const lattice::Motion& motion);

  const LatticeBody& body_;
  lattice::PointSprings* stitches_;
  lattice::PointSprings springs_;
  std::vector<Attachment*> attachments_;
  std::vector<contact::Tie*> ties_;  // one for each spring after those of the sutures
  std::vector<double> signs_;        // of the force on the lattice in Tie::force
  std::vector<Vec3d> ends_;          // displacement of the other point of each tie, lattice frame [m]
  SweptForces before_;
};

/// Contacts with other bodies in one step of a lattice, joined with those of its tools.
class SweptContacts {
 public:
  /// `springs` are the forces of the attachments in the last step.
  SweptContacts(const LatticeBody& body, World& world, const SweptForces& springs);
  SweptContacts(const SweptContacts&) = delete;
  SweptContacts& operator=(const SweptContacts&) = delete;
  /// Adds the contacts to those of the tools before a step of `dt` [s]. They are valid until the next call. A
  /// free body starts with the acceleration under the forces of the last step, unless forceps hold it: if it
  /// rests on the contacts or hangs at rest, it starts where it is.
  void join(lattice::Inputs& inputs, double dt);
  /// Returns the forces of the step to the contacts of the tools, and to the sites.
  void finish();

 private:
  Vec3d start(const lattice::Inputs& inputs, double dt) const;

  struct Site {
    int slot = 0;
    contact::PairSite* site = nullptr;
  };

  const LatticeBody& body_;
  SweptForces springs_;
  std::vector<lattice::NodeContact> own_, joined_;  // slots ascend
  std::vector<lattice::NodeContact*> origins_;      // of `joined_`
  lattice::ContactPoints own_points_, points_;      // of `own_` and `joined_`, in a body with partial cells
  std::vector<Site> sites_;                         // of `own_`
};

/// Finds the sites and the other ends of springs for the next frame.
void find_swept(const Exec& exec, World& world);
/// Forces of swept contacts and attachments on the other body, by vertex of its surface, unordered.
std::vector<contact::VertexForce> swept_forces_on(const World& world, int index);
/// Stiffness of the swept bodies that touch and hold another one [N/m].
double swept_stiffness_on(const World& world, int index);

}  // namespace turgor
