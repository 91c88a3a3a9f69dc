// Large rotations of an organ, beside its haptic ticks: the free displacement that turned elements add is
// solved once a frame, and reached tick by tick in the next one, so that no force jumps.
#include "turgor/sim/organ.hpp"

namespace turgor {

void turn_organ(const Exec& exec, Organ& organ) {
  organ.free.before = organ.free.now;
  if (!organ.turning || (organ.tools.empty() && !organ.press)) return;
  Turning& turning = *organ.turning;
  std::vector<Vec3d> forces(organ.model.body.mesh.vertices.size());
  for (const contact::VertexForce& f : coarse_forces_now(organ)) forces[std::size_t(f.vertex)] += f.force;
  if (organ.press)
    for (const contact::VertexForce& f : organ.press->load.force) forces[std::size_t(f.vertex)] += f.force;
  const sfem::RotationReport report =
      sfem::correct_rotations(exec, organ.model, turning.corotation, forces, {}, turning.state);
  turning.frames++;
  turning.unconverged += !report.converged;
  turning.largest_residual = std::max(turning.largest_residual, report.residual);
  sum_free_motion(organ);
}

}  // namespace turgor
