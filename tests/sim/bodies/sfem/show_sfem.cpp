// A finer surface of the scene (`seen`), embedded in the body and drawn instead of its own.
#include <fstream>

#include "tests/sim/sfem_scene_text.hpp"
#include "turgor/geometry/hex_block.hpp"
#include "turgor/io/mesh/mesh_files.hpp"
#include "turgor/sim/smooth_snapshot.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;
using test::body_scene;

/// Surface of the pad's block with four times the edges of its mesh, lower by `sunk` [m].
TriMesh finer_block(double sunk) {
  const SolidSurface fine = surface(tetrahedralize(hex_block({0.06, 0.06, 0.03}, {32, 32, 16})));
  const SolidMesh block = hex_block({0.06, 0.06, 0.03}, {32, 32, 16});
  TriMesh mesh{.vertices = {}, .triangles = fine.triangles, .normals = {}, .scalars = {}};
  for (const Vec3d x : block.vertices) mesh.vertices.push_back(Vec3(x - Vec3d{0, 0, sunk}));
  return mesh;
}

/// Snapshot of the pad 0.09 s after the start, when the fingertip is near its depth of 3 mm.
BodySnapshot pressed_pad(const Scene& scene) {
  const Exec exec(1);
  World world = test::sfem_world(exec, scene);
  while (time_of(world) < 0.09) EXPECT_TRUE(step(exec, world));
  BodySnapshot shown;
  show(exec, world.sfem_bodies[0], shown);
  return shown;
}

/// Displacement at a position on the surface at rest, that of the nearest vertex.
Vec3 displacement_at(const BodySnapshot& body, Vec3 rest) {
  std::size_t nearest = 0;
  for (std::size_t v = 0; v < body.rest.size(); v++)
    if (norm(body.rest[v] - rest) < norm(body.rest[nearest] - rest)) nearest = v;
  return body.displacement[nearest];
}

// The file's vertices and triangles are drawn, and not smoothed; they move like the surface of the body, with
// the dent of the tool and without motion where the body is fixed.
TEST(SeenSurface, IsDrawnAndMovesWithBody) {
  const fs::path folder = test::fresh_folder();
  const TriMesh fine = finer_block(2e-4);
  ASSERT_TRUE(write_obj(folder / "fine.obj", fine));
  const BodySnapshot plain = pressed_pad(body_scene(folder));
  BodySnapshot shown = pressed_pad(body_scene(folder, "seen = \"fine.obj\""));
  ASSERT_EQ(shown.triangles.size(), fine.triangles.size());
  EXPECT_GT(shown.triangles.size(), 10 * plain.smooth.coarse.size());
  for (const Int3 t : shown.triangles)
    for (const int v : {t.x, t.y, t.z}) ASSERT_LT(std::size_t(v), shown.rest.size());
  // drawn as it is
  show_smooth(shown);
  EXPECT_TRUE(shown.smooth.triangles.empty());
  // dent below the fingertip, its rim, and the fixed bottom
  const Vec3 center{0.018f, 0.03f, 0.03f};
  const Vec3 dent = displacement_at(plain, center);
  ASSERT_LT(dent.z, -1e-3);
  EXPECT_LT(norm(displacement_at(shown, center) - dent), 0.1 * norm(dent));
  for (const Vec3 aside : {Vec3{0.0075f, 0, 0}, Vec3{0.015f, 0, 0}, Vec3{0, 0.0225f, 0}}) {
    const Vec3 u = displacement_at(plain, center + aside);
    EXPECT_LT(norm(displacement_at(shown, center + aside) - u), 0.1 * norm(dent))
        << aside.x << " " << aside.y;
  }
  EXPECT_LT(norm(displacement_at(shown, {0.018f, 0.03f, 0})), 0.02 * norm(dent));
}

// Files that are missing, no surface, or not of this body are refused with the key and the file.
TEST(SeenSurface, BadFilesAreRefused) {
  const fs::path folder = test::fresh_folder();
  std::ofstream(folder / "text.obj") << "no surface\n";
  std::ofstream(folder / "empty.obj");
  std::ofstream(folder / "index.obj") << "v 0 0 0\nv 0 0 1\nv 0 1 0\nf 1 2 9\n";
  std::ofstream(folder / "number.obj") << "v 0 0 nan\nv 0 0 1\nv 0 1 0\nf 1 2 3\n";
  ASSERT_TRUE(write_obj(folder / "fine.obj", finer_block(0)));
  const std::pair<std::string, std::string> bad[] = {
      {"seen = \"missing.obj\"", "missing.obj"},
      {"seen = \"text.obj\"", "text.obj"},
      {"seen = \"empty.obj\"", "empty.obj"},
      {"seen = \"index.obj\"", "index.obj"},
      {"seen = \"number.obj\"", "number.obj"},
      {"seen = \"fine.obj\"\nseen_scale = 1000", "seen_scale"},
      {"seen = \"fine.obj\"\nseen_up = \"y\"", "expected a surface of the same body"}};
  for (const auto& [keys, words] : bad) {
    const Result<World> world = load_world(Exec(1), body_scene(folder, keys));
    ASSERT_FALSE(world) << keys;
    const std::string& message = world.error().message;
    EXPECT_NE(message.find("seen: "), std::string::npos) << message;
    EXPECT_NE(message.find(words), std::string::npos) << message;
  }
}

}  // namespace
}  // namespace turgor
