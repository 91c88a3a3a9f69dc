// Pictures and meshes of cloth and of what it lies on.
#include <fmt/format.h>

#include "app/outputs.hpp"

namespace turgor {

namespace {

constexpr Rgb kCloth{92, 134, 176}, kObstacle{188, 180, 168};

std::vector<float> displacements(const ClothBody& body) {
  std::vector<float> lengths;
  for (const Vec3 u : cloth::displacements(body.model, body.state)) lengths.push_back(norm(u));
  return lengths;
}

/// Both sides, for light that only knows one.
TriMesh two_sided(TriMesh mesh) {
  const int count = int(mesh.vertices.size());
  const std::size_t triangles = mesh.triangles.size();
  mesh.vertices.insert(mesh.vertices.end(), mesh.vertices.begin(), mesh.vertices.begin() + count);
  mesh.scalars.insert(mesh.scalars.end(), mesh.scalars.begin(), mesh.scalars.end());
  for (int v = 0; v < count; v++) mesh.normals.push_back(-mesh.normals[std::size_t(v)]);
  for (std::size_t t = 0; t < triangles; t++) {
    const auto [a, b, c] = mesh.triangles[t];
    mesh.triangles.push_back({a + count, c + count, b + count});
  }
  return mesh;
}

}  // namespace

void add_clothes(const World& world, SkinColor color, const ColorScale* scale, PictureParts& parts) {
  // Beside tissue, which moves by millimetres, cloth is drawn as cloth.
  const bool known = color == SkinColor::kDisplacement && world.lattice_bodies.empty() &&
                     world.sfem_bodies.empty() && world.rhombus_bodies.empty();
  for (const ClothBody& body : world.cloth_bodies) {
    TriMesh mesh = cloth::surface(body.model, body.state, body.triangles);
    if (known) mesh.scalars = displacements(body);
    parts.add(two_sided(std::move(mesh)), kCloth, known ? scale : nullptr);
    for (const ClothObstacle& obstacle : body.obstacles)
      if (!obstacle.shown.triangles.empty()) parts.add(obstacle.shown, kObstacle);
  }
}

Status write_cloth_meshes(const World& world, Outputs& outputs) {
  for (const ClothBody& body : world.cloth_bodies) {
    const std::string file = fmt::format("meshes/{}-{:04}.vtu", body.name, world.frame);
    const Status status =
        write_vtu(outputs.folder / file, cloth::surface(body.model, body.state, body.triangles),
                  {length_field("displacement", displacements(body))}, outputs.scene->output.mesh_space);
    if (!status) return status;
    outputs.series.push_back({time_of(world), file, body.name});
  }
  return Done{};
}

Status write_cloth_objs(const World& world, Outputs& outputs) {
  for (const ClothBody& body : world.cloth_bodies) {
    const std::string file = body.name + ".obj";
    const TriMesh mesh = cloth::surface(body.model, body.state, body.triangles);
    if (const Status s = write_obj(outputs.folder / file, mesh, outputs.scene->output.mesh_space); !s)
      return s;
    outputs.facts.files.push_back(file);
  }
  return Done{};
}

}  // namespace turgor
