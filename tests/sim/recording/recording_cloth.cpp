// The mesh of cloth in recordings.
#include <algorithm>

#include "tests/folders.hpp"
#include "tests/refused.hpp"
#include "tests/sim/recorded_snapshot.hpp"
#include "tests/sim/renamed_datasets.hpp"
#include "turgor/io/mesh/mesh_files.hpp"
#include "turgor/models/cloth/build/sheet.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;

/// Scene with one piece of cloth from garment.obj in a folder.
Scene garment_scene(const fs::path& folder) {
  return *parse_scene("[body.sheet]\nmodel = \"cloth\"\nmesh = \"garment.obj\"\nscale = 1\n",
                      folder / "cloth.toml");
}

/// World of the scene with this mesh in the file.
World garment_world(const fs::path& folder, const TriMesh& mesh) {
  EXPECT_TRUE(write_obj(folder / "garment.obj", mesh));
  return *load_world(Exec(1), garment_scene(folder));
}

TriMesh square_mesh() { return cloth::make_sheet({{0, 0, 0}, {0.1, 0, 0}, {0, 0.1, 0}, 4, 4}); }

/// Exchanges the numbers of two vertices; the surface stays the same.
TriMesh with_swapped(TriMesh mesh, int a, int b) {
  std::swap(mesh.vertices[std::size_t(a)], mesh.vertices[std::size_t(b)]);
  for (Int3& t : mesh.triangles)
    for (int corner = 0; corner < 3; corner++)
      if (t[corner] == a || t[corner] == b) t[corner] = a + b - t[corner];
  return mesh;
}

// A replay refuses cloth whose file changed since the run: vertices with other numbers or positions, other
// triangles, or fewer. Its positions are stored by vertex, and would be drawn at other vertices.
TEST(RecordingCloth, RejectsChangedMesh) {
  const fs::path folder = test::fresh_folder();
  const TriMesh mesh = square_mesh();
  World world = garment_world(folder, mesh);
  (void)test::record_snapshot(Exec(1), folder / "r.h5", garment_scene(folder), world);
  const Result<Recording> recording = Recording::open(folder / "r.h5");
  ASSERT_TRUE(recording) << recording.error().message;
  EXPECT_TRUE(recording->check_world(garment_world(folder, mesh)));

  const auto refusal = [&](const TriMesh& changed) {
    return recording->check_world(garment_world(folder, changed));
  };
  const std::string other = "r.h5: body.sheet has another mesh than in the recorded run: expected ";
  EXPECT_REFUSED(refusal(with_swapped(mesh, 7, 12)), other + "vertex 7 at ");
  TriMesh moved = mesh;
  moved.vertices[3].z += 1e-5f;
  EXPECT_REFUSED(refusal(moved), other + "vertex 3 at ");
  TriMesh fewer = mesh;
  fewer.triangles.erase(fewer.triangles.begin() + 13);
  EXPECT_REFUSED(refusal(fewer), other + "25 vertices and 32 triangles, found 25 and 31");
  TriMesh turned = mesh;
  std::rotate(turned.triangles.begin(), turned.triangles.begin() + 1, turned.triangles.end());
  EXPECT_REFUSED(refusal(turned), std::string("recorded run: triangle 0 has other vertices"));
}

// Positions that another processor rounds differently are those of the recorded mesh.
TEST(RecordingCloth, AcceptsRounding) {
  const fs::path folder = test::fresh_folder();
  World world = garment_world(folder, square_mesh());
  (void)test::record_snapshot(Exec(1), folder / "r.h5", garment_scene(folder), world);
  for (const auto& [change, accepted] : {std::pair(1 + 1e-7, true), {1 + 1e-4, false}}) {
    test::write_with_number(folder / "r.h5", folder / "other.h5", "/bodies/sheet/rest", 3, 0.025 * change);
    EXPECT_EQ(bool(Recording::open(folder / "other.h5")->check_world(world)), accepted) << change;
  }
}

// Older recordings, which have no mesh of cloth, are replayed as they were.
TEST(RecordingCloth, AcceptsRecordingWithoutMesh) {
  const fs::path folder = test::fresh_folder();
  World world = garment_world(folder, square_mesh());
  (void)test::record_snapshot(Exec(1), folder / "r.h5", garment_scene(folder), world);
  ASSERT_EQ(test::write_with_names(folder / "r.h5", folder / "old.h5",
                                   {{"rest", "unknown"}, {"triangles", "none"}}, "turgor recording 7"),
            2);
  EXPECT_TRUE(Recording::open(folder / "old.h5")->check_world(world));
}

}  // namespace
}  // namespace turgor
