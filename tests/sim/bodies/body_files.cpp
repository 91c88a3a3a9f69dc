// Bodies from files of other programs, with any axis up.
#include <filesystem>

#include <gtest/gtest.h>

#include "tests/folders.hpp"
#include "tests/io/mesh/meshlab.hpp"
#include "turgor/geometry/hex_block.hpp"
#include "turgor/geometry/phantom_liver.hpp"
#include "turgor/geometry/up_axis.hpp"
#include "turgor/io/mesh/mesh_files.hpp"
#include "turgor/io/mesh/solid_files.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;
using namespace test;

const Exec kExec(2);

Result<World> load(const fs::path& folder, const std::string& text) {
  const Result<Scene> scene = parse_scene(text, folder / "s.toml");
  if (!scene) return scene.error();
  return load_world(kExec, *scene);
}

/// Positions as a file with the axis `up` up stores them; turned_up inverts this.
template <class T>
std::vector<Vec<T>> rotated_to_up(std::vector<Vec<T>> positions, UpAxis up) {
  for (Vec<T>& x : positions) {
    if (up == UpAxis::kX) x = {x.z, x.y, -x.x};
    if (up == UpAxis::kY) x = {x.x, x.z, -x.y};
  }
  return positions;
}

// A mesh in centimeters is asked about, whatever its model, unless the scene states a scale.
TEST(BodyFiles, UnitIsAskedAboutInEveryModel) {
  const fs::path folder = fresh_folder();
  TriMesh liver = phantom_liver(0.3);
  for (Vec3& x : liver.vertices) x *= 100;
  ASSERT_TRUE(write_obj(folder / "liver.obj", liver));
  const auto scene = [](const std::string& model, const std::string& file) {
    return "[body.b]\nmodel = \"" + model + "\"\n" + file + "\n";
  };
  const std::pair<const char*, const char*> bodies[] = {
      {"sfem", "surface = \"liver.obj\""},
      {"rhombus", "surface = \"liver.obj\""},
      {"rigid", "shape = { mesh = \"liver.obj\" }\nmass = 1"},
      {"cloth", "mesh = \"liver.obj\""}};
  for (const auto& [model, file] : bodies) {
    const Result<World> world = load(folder, scene(model, file));
    ASSERT_FALSE(world) << model;
    EXPECT_NE(world.error().message.find("is it in cm? scale = 0.01"), std::string::npos)
        << model << ": " << world.error().message;
  }
  const Result<World> cloth = load(folder, scene("cloth", "mesh = \"liver.obj\"\nscale = 0.01"));
  EXPECT_TRUE(cloth) << cloth.error().message;
}

// Meshing of a surface or a label is announced with the count of tetrahedra that it makes, to a fifth.
TEST(BodyFiles, MeshingStatesCountOfTetrahedra) {
  const fs::path folder = fresh_folder();
  ASSERT_TRUE(write_obj(folder / "liver.obj", phantom_liver(0.3)));
  for (const char* source : {"surface = \"liver.obj\"",
                             "labels = { phantom = \"torso\", size = [64, 64, 40], spacing_mm = [6.3, 6.3, "
                             "7.5] }\nlabel = \"liver\""}) {
    const Result<Scene> scene =
        parse_scene("[body.organ]\nmodel = \"sfem\"\ncache = false\npatch = false\nresolution = 0.02\n" +
                        std::string(source) + "\n",
                    folder / "s.toml");
    ASSERT_TRUE(scene) << scene.error().message;
    std::string sentence;
    double last = 0;
    const Result<World> world =
        load_world(kExec, *scene, [&](const std::string& label, const std::string& text) -> Progress {
          if (label != "meshing") return {};
          sentence = text;
          return [&last](double fraction) { last = fraction; };
        });
    ASSERT_TRUE(world) << world.error().message;
    double count = 0;
    ASSERT_EQ(std::sscanf(sentence.c_str(), "organ: meshing, about %lf tetrahedra", &count), 1) << sentence;
    const double made = double(element_count(world->sfem_bodies[0].model.body.mesh));
    EXPECT_NEAR(count / made, 1, 0.2) << source;
    EXPECT_GT(last, 0.5);
  }
}

struct Up {
  UpAxis axis;
  std::string name;
};
const Up kUps[] = {{UpAxis::kX, "x"}, {UpAxis::kY, "y"}, {UpAxis::kZ, "z"}};

const char* kSfem = "[body.b]\nmodel = \"sfem\"\ncache = false\npatch = false\nresolution = 0.03\n";

// Surfaces with x, y or z up yield the same body in every model.
TEST(BodyFiles, SurfaceUpAxisIsApplied) {
  const fs::path folder = fresh_folder();
  const TriMesh liver = phantom_liver(0.3);
  std::vector<std::vector<Vec3d>> organs, chains;
  std::vector<std::vector<Vec3>> clothes;
  for (const Up& up : kUps) {
    TriMesh mesh = liver;
    mesh.vertices = rotated_to_up(liver.vertices, up.axis);
    mesh.normals.clear();
    ASSERT_TRUE(write_obj(folder / "liver.obj", mesh));
    const std::string file = "\"liver.obj\"\nup = \"" + up.name + "\"\n";
    const Result<World> world =
        load(folder, kSfem + ("surface = " + file) +
                         "seen = \"liver.obj\"\n[body.c]\nmodel = \"rhombus\"\nsurface = " + file +
                         "[body.d]\nmodel = \"cloth\"\nmesh = " + file);
    ASSERT_TRUE(world) << world.error().message;
    organs.push_back(world->sfem_bodies[0].model.body.mesh.vertices);
    chains.push_back(world->rhombus_bodies[0].model.surface.vertices);
    const cloth::Model& cloth = world->cloth_bodies[0].model;
    clothes.emplace_back();
    for (std::size_t v = 0; v < std::size_t(cloth.count); v++) clothes.back().push_back(cloth.x_rest[v]);
    EXPECT_LT(world->sfem_bodies[0].seen->embedding.farthest_outside, 0.02)
        << "the embedded surface has the same up axis";
  }
  for (const std::size_t other : {0, 1}) {
    EXPECT_EQ(organs[other], organs[2]);
    EXPECT_EQ(chains[other], chains[2]);
    EXPECT_EQ(clothes[other], clothes[2]);
  }
}

// Solid meshes with x, y or z up yield the same body.
TEST(BodyFiles, SolidMeshUpAxisIsApplied) {
  const fs::path folder = fresh_folder();
  const SolidMesh block = hex_block({0.05, 0.03, 0.02}, {5, 3, 2});
  for (const Up& up : kUps) {
    SolidMesh mesh = block;
    mesh.vertices = rotated_to_up(block.vertices, up.axis);
    ASSERT_TRUE(write_msh(folder / "block.msh", mesh));
    const Result<World> world = load(
        folder, "[body.b]\nmodel = \"sfem\"\ncache = false\npatch = false\nmesh = \"block.msh\"\nup = \"" +
                    up.name + "\"\n");
    ASSERT_TRUE(world) << world.error().message;
    EXPECT_EQ(world->sfem_bodies[0].model.body.mesh.vertices, block.vertices) << up.name;
  }
}

// A chain body of a file with nested components has a note, as an sfem body has.
TEST(BodyFiles, NestedChainBodyIsNoted) {
  const fs::path folder = fresh_folder();
  TriMesh liver = phantom_liver(0.3);
  liver.normals.clear();
  const auto notes = [&](const TriMesh& mesh) {
    EXPECT_TRUE(write_obj(folder / "liver.obj", mesh));
    const Result<World> world = load(folder, "[body.c]\nmodel = \"rhombus\"\nsurface = \"liver.obj\"\n");
    EXPECT_TRUE(world) << world.error().message;
    return world ? world->rhombus_bodies[0].notes : std::vector<std::string>{};
  };
  EXPECT_TRUE(notes(liver).empty());
  Vec3 center;
  for (const Vec3 x : liver.vertices) center += x * (1.0f / float(liver.vertices.size()));
  TriMesh nested = liver;
  for (const Vec3 x : liver.vertices) nested.vertices.push_back(center + 0.2f * (x - center));
  const int count = int(liver.vertices.size());
  for (const Int3 t : liver.triangles) nested.triangles.push_back({t.x + count, t.y + count, t.z + count});
  const std::vector<std::string> found = notes(nested);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NE(found[0].find("inside another one"), std::string::npos) << found[0];
}

// So has one whose components cross. Components apart have none.
TEST(BodyFiles, CrossingChainBodyIsNoted) {
  const fs::path folder = fresh_folder();
  const TriMesh liver = phantom_liver(0.3);
  const int count = int(liver.vertices.size());
  for (const auto& [shift, crosses] : {std::pair{0.02f, true}, {1.0f, false}}) {
    TriMesh two = liver;
    two.normals.clear();
    for (const Vec3 x : liver.vertices) two.vertices.push_back(x + Vec3{shift, 0, 0});
    for (const Int3 t : liver.triangles) two.triangles.push_back({t.x + count, t.y + count, t.z + count});
    ASSERT_TRUE(write_obj(folder / "liver.obj", two));
    const Result<World> world = load(folder, "[body.c]\nmodel = \"rhombus\"\nsurface = \"liver.obj\"\n");
    ASSERT_TRUE(world) << world.error().message;
    std::string notes;
    for (const std::string& note : world->rhombus_bodies[0].notes) notes += note + "\n";
    EXPECT_EQ(notes.find("the surface crosses itself: ") != notes.npos, crosses) << shift << " m: " << notes;
  }
}

// An up key without a file or with an unknown axis is refused.
TEST(BodyFiles, RejectsInvalidUpAxis) {
  const auto message = [](const std::string& text) {
    const Result<Scene> scene = parse_scene(text, "s.toml");
    return scene ? "no error" : scene.error().message;
  };
  EXPECT_NE(message(kSfem + std::string("surface = \"a.obj\"\nup = \"head\"\n")).find("body.b.up: expected"),
            std::string::npos);
  EXPECT_NE(message("[body.b]\nmodel = \"rhombus\"\nsurface = { phantom = \"liver\" }\nup = \"y\"\n")
                .find("up is not a key"),
            std::string::npos);
}

// OBJ and PLY files as MeshLab writes them run in a scene.
TEST(BodyFiles, MeshLabFilesRunInScene) {
  const fs::path folder = fresh_folder();
  const TriMesh liver = phantom_liver(0.3);
  write(folder / "organ.obj", meshlab_obj(liver));
  write(folder / "organ.ply", meshlab_ply(liver));
  for (const std::string name : {"organ.obj", "organ.ply"}) {
    SCOPED_TRACE(name);
    Result<World> world = load(
        folder, kSfem + ("surface = \"" + name + "\"\n[body.c]\nmodel = \"rhombus\"\nsurface = \"" + name +
                         "\"\n[tool.t]\nbody = \"c\"\nshape = { sphere = 0.006 }\n"
                         "press = { at_fraction = [0.3, 0.5, 1], start = 0, duration = 0.05 }\n"));
    ASSERT_TRUE(world) << world.error().message;
    EXPECT_EQ(world->rhombus_bodies[0].model.surface.vertices.size(), liver.vertices.size());
    for (int frame = 0; frame < 4; frame++) ASSERT_TRUE(step(kExec, *world));
    EXPECT_GT(norm(world->tools[0].samples.back().force), 0);
  }
}

}  // namespace
}  // namespace turgor
