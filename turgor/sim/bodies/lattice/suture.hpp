// Sutures of a running world: rows of stitches that are laid on a wound when they start, pulled and knotted.
#pragma once

#include <map>
#include <optional>
#include <span>
#include <vector>

#include "turgor/core/result.hpp"
#include "turgor/geometry/tri_mesh.hpp"
#include "turgor/sim/bodies/lattice/cut.hpp"

namespace turgor {

/// Suture in progress.
struct Suture {
  SutureScene scene;
  std::optional<lattice::WoundClosure> closure;  // laid when the suture starts; one of a wound has its walls
};

/// Tests the stitches on the body at rest. Errors, with the source location: a stitch beside the wound or
/// through air, or a thread that is shorter than its stitches.
Result<Suture> load_suture(const SutureScene& scene, const LatticeBody& body, const Cut& cut);
/// Suture of a wound that is cut already, tested on the present body. Error: a stitch beside the wound, or
/// through air.
Result<Suture> suture_of_wound(const SutureScene& scene, const LatticeBody& body, const Cut& cut);
/// Distance of a single stitch from the line of a wound [m]. Empty: it does not cross the wound, because its
/// points are on one side, or nearer to each other than to the line.
std::optional<double> distance_of_stitch(const SutureScene& scene, const lattice::Model& model,
                                         const lattice::BladePath& path);
/// Points of a single stitch in the frame of the lattice [m].
std::vector<Vec3d> points_of_stitch(const SutureScene& scene, const lattice::Model& model);
/// Lays, embeds and pulls the stitches before the frame that ends at a time [s]. Error: a point of a stitch
/// is not in tissue.
Status advance_suture(const LatticeBody& body, const Cut& cut, double time, Suture& suture);

/// Springs of the sutures of one body during its step.
struct SutureSprings {
  lattice::PointSprings springs;
  std::vector<lattice::WoundClosure*> closures;
  std::map<int, std::vector<lattice::WoundClosure*>> of_wounds;  // the same by index of the wound

  SutureSprings(const LatticeBody& body, int index, std::span<Suture> sutures);
  SutureSprings(const SutureSprings&) = delete;
  SutureSprings& operator=(const SutureSprings&) = delete;
  lattice::PointSprings* input() { return springs.all.empty() ? nullptr : &springs; }
  /// After the frame that ends at a time [s]: multipliers, pull-outs and breaks.
  void finish(const lattice::Model& model, const lattice::Motion& motion, double time);
};

/// Takes a suture out of the world. Its wound keeps the contact of its walls if another suture bears.
void remove_suture(const LatticeBody& body, std::size_t number, std::vector<Suture>& sutures);

/// Closing force of a suture: that of its stitches, less its share of the pressure of the wound's walls,
/// which all sutures of the wound bear in proportion to their forces [N].
double closing_force(const LatticeBody& body, const Suture& suture, std::span<const Suture> sutures);

/// Threads that bear, patient frame.
TriMesh thread_mesh(const LatticeBody& body, const Suture& suture);

}  // namespace turgor
