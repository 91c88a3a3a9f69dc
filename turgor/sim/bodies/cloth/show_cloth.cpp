// Snapshot and hash of a cloth body.
#include "turgor/core/assert.hpp"
#include "turgor/core/hash.hpp"
#include "turgor/sim/bodies/cloth/cloth_body.hpp"

namespace turgor {

std::uint64_t state_hash(const ClothBody& body, std::uint64_t seed) {
  const std::uint64_t one = cloth::state_hash(body.model, body.state);
  return hash_bytes(&one, sizeof one, seed);
}

void show(const Exec&, const ClothBody& body, BodySnapshot& out) {
  const TriMesh now = cloth::surface(body.model, body.state, body.triangles);
  out.x = now.vertices, out.normals = now.normals, out.triangles = now.triangles;
  out.wall_begin = out.triangles.size();
  out.displacement = cloth::displacements(body.model, body.state);
  TURGOR_CHECK(out.displacement.size() == out.x.size(), "every vertex has a displacement");
  out.rest.resize(out.x.size());
  for (std::size_t v = 0; v < out.x.size(); v++) {
    out.rest[v] = body.model.x_rest[std::size_t(body.model.model_vertex[v])];
    const Vec3d rest(out.rest[v]);
    out.box = v == 0 ? Box{rest, rest} : Box{min(out.box.low, rest), max(out.box.high, rest)};
  }
}

}  // namespace turgor
