// Large rotations of a body, beside its haptic ticks: the free displacement that turned elements add is
// solved once a frame, and reached tick by tick in the next one, so that no force jumps.
#include "turgor/sim/bodies/sfem/sfem_body.hpp"

namespace turgor {

void turn_body(const Exec& exec, SfemBody& body) {
  body.free.before = body.free.now;
  if (!body.turning || (body.tool_indices.empty() && !body.press)) return;
  Turning& turning = *body.turning;
  std::vector<Vec3d> forces(body.model.body.mesh.vertices.size());
  for (const contact::VertexForce& f : coarse_forces_now(body)) forces[std::size_t(f.vertex)] += f.force;
  if (body.press)
    for (const contact::VertexForce& f : body.press->load.force)
      forces[std::size_t(f.vertex)] += f.force / body.stiffer;
  const sfem::RotationReport report =
      sfem::correct_rotations(exec, body.model, turning.corotation, forces, {}, turning.state);
  turning.frames++;
  turning.unconverged += !report.converged;
  turning.largest_residual = std::max(turning.largest_residual, report.residual);
  sum_free_motion(body);
}

}  // namespace turgor
