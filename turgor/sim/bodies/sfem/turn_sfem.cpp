// Correction of large rotations, concurrent with haptic ticks. The free displacement of rotated elements is
// solved once per frame and interpolated over the ticks of the next one, so that no force jumps.
#include "turgor/core/assert.hpp"
#include "turgor/sim/bodies/sfem/needle_sfem.hpp"
#include "turgor/sim/bodies/sfem/sfem_body.hpp"

namespace turgor {

void correct_rotations(const Exec& exec, SfemBody& body) {
  body.free.before = body.free.now;
  displace_by_needles(body);
  if (!body.turning && body.needles.inner) sum_free_motion(body);
  if (!body.turning || (body.tool_indices.empty() && !body.press && !body.coupling)) return;
  Turning& turning = *body.turning;

  TURGOR_CHECK(!(body.stiffness_scale <= 0), "a body has a stiffness");
  // present forces: contacts and cloth
  std::vector<Vec3d> forces(body.model.body.mesh.vertices.size());
  for (const contact::VertexForce& f : coarse_forces_now(body)) forces[std::size_t(f.vertex)] += f.force;
  if (const auto& inner = body.now.inner)
    for (const std::vector<Vec3d>& of_needle : body.now.needle_forces)
      for (std::size_t i = 0; i < of_needle.size(); i++)
        forces[std::size_t(inner->vertices[i])] += of_needle[i];
  if (body.press)
    for (const contact::VertexForce& f : body.press->load.force)
      forces[std::size_t(f.vertex)] += f.force / body.stiffness_scale;
  if (body.coupling)
    for (const contact::VertexForce& f : body.coupling->force)
      forces[std::size_t(f.vertex)] += f.force / body.stiffness_scale;

  // rotated elements
  const sfem::RotationReport report =
      sfem::correct_rotations(exec, body.model, turning.corotation, forces, {}, turning.state);

  // statistics
  turning.frames++;
  turning.unconverged += !report.converged;
  turning.largest_residual = std::max(turning.largest_residual, report.residual);
  sum_free_motion(body);
}

}  // namespace turgor
