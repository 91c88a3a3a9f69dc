// Snapshot of a lattice: its skin and wound walls.
#include "turgor/core/assert.hpp"
#include "turgor/models/lattice/surface/deform_surface.hpp"
#include "turgor/models/lattice/surface/surface_cache.hpp"
#include "turgor/sim/bodies/lattice/lattice_body.hpp"
#include "turgor/sim/bodies/lattice/wall_layers.hpp"

namespace turgor {

namespace {

/// Surface of an untouched body, cached between snapshots.
struct KeptSkin {
  lattice::BodySurface surface;
  std::vector<Vec3d> rest;  // patient frame [m]
  lattice::detail::SurfaceCache cells;
  const lattice::Model* model = nullptr;
  std::size_t cuts = 0;  // cut version of the surface
};
/// for states on a device: nodes that the surface depends on
struct KeptNodes {
  std::vector<int> nodes;
  const lattice::Model* model = nullptr;
  std::size_t cuts = 0;
};
/// Layers on walls of the snapshot: what they were made from.
struct KeptLayers {
  std::vector<lattice::TissueLayer> layers;
  const lattice::Model* model = nullptr;
  std::size_t cuts = 0;
};
struct DrawingCache {
  KeptSkin skin;
  KeptNodes behind;
  KeptLayers layers;
};

struct Skin {
  const lattice::BodySurface& surface;
  const std::vector<Vec3d>& rest;
};

/// Updates the surface to the present cuts.
Skin skin_of(const Exec& exec, const LatticeBody& body, KeptSkin& skin) {
  const std::size_t cuts = cut_version(body.state.cuts());
  if (!body.rest.empty() && body.surface_cuts == cuts) return {body.surface, body.rest};
  if (skin.model != &body.model || skin.cuts != cuts) {
    if (skin.model != &body.model) skin.cells = {};
    skin.surface = lattice::build_surface(body.model, body.state.cuts(), &body.ct, lattice::Extent::kAll,
                                          exec, &skin.cells);
    skin.rest = lattice::rest_points(body.model, skin.surface);
    skin.model = &body.model, skin.cuts = cuts;
  }
  return {skin.surface, skin.rest};
}

std::span<const int> support_nodes(const LatticeBody& body, const lattice::BodySurface& surface,
                                   KeptNodes& behind) {
  TURGOR_CHECK(surface.embedding.size() == surface.rest.size(), "every vertex is embedded in a cell");
  if (!body.state.is_on_device()) return {};
  const std::size_t cuts = cut_version(body.state.cuts());
  if (behind.model != &body.model || behind.cuts != cuts || behind.nodes.empty())
    behind = {lattice::support_nodes(body.model, body.state.cuts(), body.state.virtual_u(), surface),
              &body.model, cuts};
  return behind.nodes;
}

/// Updates the layers on walls to the present cuts.
void show_layers(const Exec& exec, const LatticeBody& body, const std::vector<Vec3d>& rest, KeptLayers& kept,
                 BodySnapshot& out) {
  if (!has_layer_colors(body)) return;
  const std::size_t cuts = cut_version(body.state.cuts());
  const std::vector<lattice::TissueLayer>& layers = body.model.params.tissue.layers;
  if (kept.model == &body.model && kept.cuts == cuts && kept.layers == layers) return;
  const std::span<const Int3> triangles = out.triangles;
  out.wall_layers =
      layers_on_walls(exec, body, {rest, triangles.first(out.wall_begin), triangles.subspan(out.wall_begin)});
  kept = {layers, &body.model, cuts};
}

}  // namespace

void show(const Exec& exec, const LatticeBody& body, BodySnapshot& out) {
  // deformed surface
  if (!std::any_cast<DrawingCache>(&out.cache)) out.cache = DrawingCache();
  DrawingCache& cache = *std::any_cast<DrawingCache>(&out.cache);
  const Skin skin = skin_of(exec, body, cache.skin);
  TriMesh now{std::move(out.x), std::move(out.triangles), std::move(out.normals), std::move(out.stretch)};
  body.state.read_wound_nodes(
      support_nodes(body, skin.surface, cache.behind), [&](const lattice::State& state) {
        lattice::deform_surface(body.model, state, skin.surface, lattice::Shown::kStretch, exec, now);
      });
  out.x = std::move(now.vertices), out.normals = std::move(now.normals);
  out.stretch = std::move(now.scalars), out.triangles = std::move(now.triangles);

  // fields that follow from it
  out.wall_begin = std::size_t(skin.surface.skin_triangles);
  out.cap_count = std::size_t(skin.surface.cap_triangles);
  TURGOR_CHECK(skin.rest.size() == out.x.size(), "every vertex of the surface has a rest position");
  out.rest.resize(out.x.size()), out.displacement.resize(out.x.size());
  for (std::size_t v = 0; v < out.x.size(); v++) {
    out.rest[v] = Vec3(skin.rest[v]);
    out.displacement[v] = out.x[v] - out.rest[v];
  }
  show_layers(exec, body, skin.rest, cache.layers, out);
  out.box = body.box;
}

}  // namespace turgor
