// What is seen of a lattice: its skin and the walls of its wounds.
#include "turgor/models/lattice/surface_parts.hpp"
#include "turgor/sim/bodies/lattice/lattice_body.hpp"

namespace turgor {

namespace {

/// A surface that the body does not keep itself, since nothing touches it.
struct KeptSkin {
  lattice::BodySurface surface;
  std::vector<Vec3d> rest;  // patient frame [m]
  lattice::detail::KnownSlabs slabs;
  const lattice::Model* model = nullptr;
  std::size_t cuts = 0;  // cut_version when it was made
};

struct Skin {
  const lattice::BodySurface& surface;
  const std::vector<Vec3d>& rest;
};

/// With the cuts that the body has now.
Skin skin_of(const Exec& exec, const LatticeBody& body, std::any& kept) {
  const std::size_t cuts = body.state.cuts();
  if (!body.rest.empty() && body.surface_cuts == cuts) return {body.surface, body.rest};
  if (!std::any_cast<KeptSkin>(&kept)) kept = KeptSkin();
  KeptSkin& skin = *std::any_cast<KeptSkin>(&kept);
  if (skin.model != &body.model || skin.cuts != cuts) {
    if (skin.model != &body.model) skin.slabs = {};
    skin.surface =
        lattice::build_surface(body.model, body.state, &body.ct, lattice::Extent::kAll, exec, &skin.slabs);
    skin.rest = lattice::rest_points(body.model, skin.surface);
    skin.model = &body.model, skin.cuts = cuts;
  }
  return {skin.surface, skin.rest};
}

}  // namespace

void show(const Exec& exec, const LatticeBody& body, ShownBody& out) {
  const Skin skin = skin_of(exec, body, out.kept);
  const TriMesh now =
      lattice::deformed_surface(body.model, body.state, skin.surface, lattice::Shown::kStretch);
  out.x = now.vertices, out.normals = now.normals;
  out.stretch = now.scalars, out.triangles = now.triangles;
  out.wall_begin = std::size_t(skin.surface.skin_triangles);
  out.rest.resize(out.x.size()), out.displacement.resize(out.x.size());
  for (std::size_t v = 0; v < out.x.size(); v++) {
    out.rest[v] = Vec3(skin.rest[v]);
    out.displacement[v] = out.x[v] - out.rest[v];
  }
  out.box = body.box;
}

}  // namespace turgor
