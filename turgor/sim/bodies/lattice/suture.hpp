// Sutures of a running world: rows of stitches that are laid on a wound when they start, pulled and knotted.
#pragma once

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
  bool has_walls = true;  // false: an earlier suture of the same wound has the contact of its walls
  std::optional<lattice::WoundClosure> closure;  // laid when the suture starts
};

/// Tests the stitches on the body at rest. Errors, with the source location: a stitch through air, or a
/// thread that is shorter than its stitches.
Result<Suture> load_suture(const SutureScene& scene, const LatticeBody& body, const Cut& cut,
                           std::span<const Suture> others);
/// Suture of a wound that is cut already, tested on the present body. Error: a point of a stitch is in air.
Result<Suture> suture_of_wound(const SutureScene& scene, const LatticeBody& body, const Cut& cut,
                               std::span<const Suture> others);
/// Points of a single stitch in the frame of the lattice [m].
std::vector<Vec3d> points_of_stitch(const SutureScene& scene, const lattice::Model& model);
/// Lays, embeds and pulls the stitches before the frame that ends at a time [s]. Error: a point of a stitch
/// is not in tissue.
Status advance_suture(const LatticeBody& body, const Cut& cut, double time, Suture& suture);

/// Springs of the sutures of one body during its step.
struct SutureSprings {
  lattice::PointSprings springs;
  std::vector<lattice::WoundClosure*> closures;

  SutureSprings(const lattice::Model& model, int body, std::span<Suture> sutures);
  SutureSprings(const SutureSprings&) = delete;
  SutureSprings& operator=(const SutureSprings&) = delete;
  lattice::PointSprings* input() { return springs.all.empty() ? nullptr : &springs; }
  /// After the frame that ends at a time [s]: multipliers, pull-outs and breaks.
  void finish(const lattice::Model& model, const lattice::Motion& motion, double time);
};

/// Threads that bear, patient frame.
TriMesh thread_mesh(const LatticeBody& body, const Suture& suture);

}  // namespace turgor
