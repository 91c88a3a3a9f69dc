// Pictures and meshes of lattice bodies: skin, and the walls of wounds.
#include <fmt/format.h>

#include "app/outputs.hpp"

namespace turgor {

namespace {

constexpr Rgb kSkin{224, 172, 145}, kWall{166, 58, 50};

lattice::Shown shown_scalar(SkinColor color) {
  switch (color) {
    case SkinColor::kDisplacement:
      return lattice::Shown::kDisplacement;
    case SkinColor::kStretch:
      return lattice::Shown::kStretch;
    case SkinColor::kPressure:
    case SkinColor::kNone:
      break;
  }
  return lattice::Shown::kNothing;
}

/// The skin and the walls of wounds as two meshes that share vertices.
struct DrawnMeshes {
  TriMesh skin, walls;
};
DrawnMeshes drawn_meshes(const LatticeBody& body, DrawnBody& drawn, SkinColor color) {
  if (!drawn.made || drawn.cut_edges != body.state.cut_edges.size()) {
    drawn.surface = lattice::build_surface(body.model, body.state);
    drawn.cut_edges = body.state.cut_edges.size();
    drawn.made = true;
  }
  DrawnMeshes meshes;
  meshes.skin = lattice::deformed_surface(body.model, body.state, drawn.surface, shown_scalar(color));
  meshes.walls = meshes.skin;
  const auto split = std::ptrdiff_t(drawn.surface.skin_triangles);
  meshes.walls.triangles.erase(meshes.walls.triangles.begin(), meshes.walls.triangles.begin() + split);
  meshes.skin.triangles.resize(std::size_t(split));
  return meshes;
}

Vec3d to_patient(const Grid& grid, Vec3d local) { return grid.origin + grid.axes * local; }

}  // namespace

void add_skin(const World& world, Outputs& outputs, SkinColor color, const ColorScale* scale,
              PictureParts& parts) {
  const bool known = shown_scalar(color) != lattice::Shown::kNothing;
  for (std::size_t b = 0; b < world.lattice_bodies.size(); b++) {
    DrawnMeshes meshes = drawn_meshes(world.lattice_bodies[b], outputs.bodies[b], color);
    parts.add(std::move(meshes.skin), kSkin, known ? scale : nullptr);
    if (!meshes.walls.triangles.empty()) parts.add(std::move(meshes.walls), kWall);
  }
}

Status write_skin_meshes(const World& world, Outputs& outputs) {
  for (std::size_t b = 0; b < world.lattice_bodies.size(); b++) {
    const LatticeBody& body = world.lattice_bodies[b];
    const TriMesh moved = lattice::deformed_surface(body.model, body.state, outputs.bodies[b].surface,
                                                    lattice::Shown::kStretch);
    std::vector<Vec3> displacement(moved.vertices.size());
    for (std::size_t v = 0; v < displacement.size(); v++) {
      const Vec3d rest = to_patient(body.model.grid, Vec3d(outputs.bodies[b].surface.rest[v]));
      displacement[v] = moved.vertices[v] - Vec3(rest);
    }
    const std::string file = fmt::format("meshes/{}-{:04}.vtu", body.name, world.frame);
    const Status status = write_vtu(
        outputs.folder / file, moved,
        {length_field("displacement", displacement), vertex_field("area strain [1]", moved.scalars)},
        outputs.scene->output.mesh_space);
    if (!status) return status;
    outputs.series.push_back({time_of(world), file, body.name});
  }
  return Done{};
}

Status write_skin_objs(const World& world, Outputs& outputs) {
  for (std::size_t b = 0; b < world.lattice_bodies.size(); b++) {
    const LatticeBody& body = world.lattice_bodies[b];
    const std::string file = body.name + ".obj";
    const TriMesh mesh = lattice::deformed_surface(body.model, body.state, outputs.bodies[b].surface,
                                                   lattice::Shown::kNothing);
    if (const Status s = write_obj(outputs.folder / file, mesh, outputs.scene->output.mesh_space); !s)
      return s;
    outputs.facts.files.push_back(file);
  }
  return Done{};
}

}  // namespace turgor
