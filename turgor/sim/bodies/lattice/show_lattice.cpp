// What is seen of a lattice: its skin and the walls of its wounds.
#include "turgor/models/lattice/surface/surface_assembly.hpp"
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
/// Of a body that is elsewhere, what its surface goes with.
struct KeptNodes {
  std::vector<int> nodes;
  const lattice::Model* model = nullptr;
  std::size_t cuts = 0;
};
struct KeptForShow {
  KeptSkin skin;
  KeptNodes behind;
};

struct Skin {
  const lattice::BodySurface& surface;
  const std::vector<Vec3d>& rest;
};

/// With the cuts that the body has now.
Skin skin_of(const Exec& exec, const LatticeBody& body, KeptSkin& skin) {
  const std::size_t cuts = body.state.cuts();
  if (!body.rest.empty() && body.surface_cuts == cuts) return {body.surface, body.rest};
  if (skin.model != &body.model || skin.cuts != cuts) {
    if (skin.model != &body.model) skin.slabs = {};
    skin.surface = lattice::build_surface(body.model, body.state.without_places(), &body.ct,
                                          lattice::Extent::kAll, exec, &skin.slabs);
    skin.rest = lattice::rest_points(body.model, skin.surface);
    skin.model = &body.model, skin.cuts = cuts;
  }
  return {skin.surface, skin.rest};
}

std::span<const int> nodes_behind(const LatticeBody& body, const lattice::BodySurface& surface,
                                  KeptNodes& behind) {
  if (!body.state.is_on_device()) return {};
  const std::size_t cuts = body.state.cuts();
  if (behind.model != &body.model || behind.cuts != cuts || behind.nodes.empty())
    behind = {lattice::nodes_behind(body.model, body.state.without_places(), surface), &body.model, cuts};
  return behind.nodes;
}

}  // namespace

void show(const Exec& exec, const LatticeBody& body, BodySnapshot& out) {
  if (!std::any_cast<KeptForShow>(&out.kept)) out.kept = KeptForShow();
  KeptForShow& kept = *std::any_cast<KeptForShow>(&out.kept);
  const Skin skin = skin_of(exec, body, kept.skin);
  const TriMesh now = body.state.read_wound_nodes(
      nodes_behind(body, skin.surface, kept.behind), [&](const lattice::State& state) {
        return lattice::deformed_surface(body.model, state, skin.surface, lattice::Shown::kStretch);
      });
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
