#include "turgor/io/mesh_files.hpp"

#include <cstring>

#include <gtest/gtest.h>

#include "folders.hpp"
#include "turgor/io/file.hpp"
#include "turgor/io/surface_files.hpp"

namespace turgor {
namespace {

TriMesh two_triangles() {
  TriMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0.5f}};
  mesh.triangles = {{0, 1, 2}, {2, 1, 3}};
  return mesh;
}

std::string written(const std::string& name, const auto& write) {
  const std::string path = test::fresh_folder() / name;
  const Status status = write(path);
  EXPECT_TRUE(status);
  return read_file(path).value();
}

/// What an attribute of the first element that holds `anchor` says.
std::string attribute(const std::string& text, const std::string& anchor, const std::string& name) {
  const std::size_t begin = text.find(name + "=\"", text.find(anchor)) + name.size() + 2;
  return text.substr(begin, text.find('"', begin) - begin);
}

/// The numbers of an appended array.
template <class T>
std::vector<T> appended(const std::string& text, const std::string& name) {
  const std::size_t data = text.find("encoding=\"raw\">\n_") + 17;
  const char* block = text.data() + data + std::stoul(attribute(text, "Name=\"" + name + "\"", "offset"));
  std::uint64_t size = 0;
  std::memcpy(&size, block, sizeof size);
  std::vector<T> values(size / sizeof(T));
  if (size > 0) std::memcpy(values.data(), block + sizeof size, size);
  return values;
}

TEST(MeshFiles, ObjCountsFromOneAndRefersToNormals) {
  TriMesh mesh = two_triangles();
  const std::string plain = written("plain.obj", [&](const auto& path) { return write_obj(path, mesh); });
  EXPECT_NE(plain.find("\nf 1 2 3\nf 3 2 4\n"), std::string::npos);
  EXPECT_NE(plain.find("v 1.000000 1.000000 0.500000\n"), std::string::npos);
  mesh.normals = vertex_normals(mesh);
  const std::string smooth = written("smooth.obj", [&](const auto& path) { return write_obj(path, mesh); });
  EXPECT_NE(smooth.find("\nf 3//3 2//2 4//4\n"), std::string::npos);
}

TEST(MeshFiles, ObjNamesItsGroupsWhereTheyBegin) {
  const std::vector<MeshGroup> groups{{"skin", 0}, {"wound", 1}};
  const std::string text =
      written("groups.obj", [&](const auto& path) { return write_obj(path, two_triangles(), {}, groups); });
  EXPECT_NE(text.find("\ng skin\nf 1 2 3\ng wound\nf 3 2 4\n"), std::string::npos) << text;
}

TEST(MeshFiles, VtuHoldsPointsCellsAndFieldsInItsBinaryEnd) {
  const TriMesh mesh = two_triangles();
  const std::vector<float> stretch = {0, 1, 2, 3};
  const std::string text = written("mesh.vtu", [&](const auto& path) {
    return write_vtu(path, mesh, {vertex_field("stretch <1>", stretch)});
  });
  EXPECT_EQ(attribute(text, "<Piece", "NumberOfPoints"), "4");
  EXPECT_EQ(attribute(text, "<Piece", "NumberOfCells"), "2");
  EXPECT_EQ(appended<float>(text, "stretch &lt;1&gt;"), stretch);
  EXPECT_EQ(appended<float>(text, "points"), (std::vector<float>{0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0.5f}));
  EXPECT_EQ(appended<std::int32_t>(text, "connectivity"), (std::vector<std::int32_t>{0, 1, 2, 2, 1, 3}));
  EXPECT_EQ(appended<std::int64_t>(text, "offsets"), (std::vector<std::int64_t>{3, 6}));
  EXPECT_EQ(appended<std::uint8_t>(text, "types"), (std::vector<std::uint8_t>{5, 5}));
}

TEST(MeshFiles, AnObjOfMillimetresAndRasIsReadBackAsHalfATurnOfTheSame) {
  TriMesh mesh = two_triangles();
  mesh.vertices[3] = {0.0123456f, -0.25f, 0.5f};
  mesh.normals = vertex_normals(mesh);
  const std::string path = test::fresh_folder() / "a.obj";
  ASSERT_TRUE(write_obj(path, mesh, {.is_mm = true, .is_ras = true}));
  const std::string text = read_file(path).value();
  EXPECT_TRUE(
      text.starts_with("# Turgor: millimetres, patient frame RAS (x to the right, y to the front, z "
                       "to the head)\n# SPACE=RAS\n"))
      << text;
  EXPECT_EQ(text.find("-0.0000 "), std::string::npos) << "zero has no sign";
  const Result<ReadSurface> read = read_surface(path, 0.001);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->mesh.triangles, mesh.triangles) << "a turn keeps the winding";
  ASSERT_EQ(read->mesh.vertices.size(), 4u);
  for (std::size_t v = 0; v < 4; v++) {
    const Vec3 x = mesh.vertices[v];
    EXPECT_NEAR(norm(read->mesh.vertices[v] - Vec3{-x.x, -x.y, x.z}), 0, 1e-7) << v;
  }
}

TEST(MeshFiles, AVtuOfMillimetresAndRasHasItsLengthsInThemAndSaysSo) {
  TriMesh mesh = two_triangles();
  mesh.normals = std::vector<Vec3>(4, {1, 0, 0});
  const std::vector<Vec3> moved = {{0.001f, 0.002f, 0.003f}, {}, {}, {}};
  const std::vector<float> lengths = {0.5f, 0, 0, 0}, pressure = {7, 0, 0, 0};
  const std::string text = written("mesh.vtu", [&](const auto& path) {
    return write_vtu(path, mesh,
                     {length_field("displacement", moved), length_field("way", lengths),
                      vertex_field("pressure [Pa]", pressure)},
                     {.is_mm = true, .is_ras = true});
  });
  EXPECT_EQ(appended<float>(text, "points")[9], -1000);
  EXPECT_EQ(appended<float>(text, "points")[10], -1000);
  EXPECT_EQ(appended<float>(text, "points")[11], 500);
  EXPECT_EQ(appended<float>(text, "normal")[0], -1);
  const std::vector<float> displacement = appended<float>(text, "displacement [mm]");
  EXPECT_FLOAT_EQ(displacement[0], -1);
  EXPECT_FLOAT_EQ(displacement[1], -2);
  EXPECT_FLOAT_EQ(displacement[2], 3);
  EXPECT_EQ(appended<float>(text, "way [mm]")[0], 500);
  EXPECT_EQ(appended<float>(text, "pressure [Pa]")[0], 7);
  EXPECT_NE(text.find("<!-- Turgor: millimetres, patient frame RAS"), std::string::npos);
  EXPECT_NE(text.find("Name=\"SPACE\" NumberOfTuples=\"1\" format=\"ascii\">82 65 83 0<"), std::string::npos);
  EXPECT_NE(text.find("Name=\"unit\" NumberOfTuples=\"1\" format=\"ascii\">109 109 0<"), std::string::npos);
}

TEST(MeshFiles, WithoutAWishAVtuIsInMetresAndLps) {
  const std::vector<Vec3> moved(4, {0.001f, 0.002f, 0.003f});
  const std::string text = written("mesh.vtu", [&](const auto& path) {
    return write_vtu(path, two_triangles(), {length_field("displacement", moved)});
  });
  EXPECT_EQ(appended<float>(text, "displacement [m]")[1], 0.002f);
  EXPECT_NE(text.find("<!-- Turgor: metres, patient frame LPS"), std::string::npos);
  EXPECT_NE(text.find(">76 80 83 0<"), std::string::npos);
}

TEST(MeshFiles, EmptyMeshesAreWritten) {
  const std::string text = written("empty.vtu", [](const auto& path) { return write_vtu(path, {}, {}); });
  EXPECT_TRUE(appended<float>(text, "points").empty());
}

TEST(MeshFiles, PointsAreVertexCellsWithDirectionsAlongTheFilesAxes) {
  const std::filesystem::path file = test::fresh_folder() / "a.vtu";
  const std::vector<Vec3> places{{0.001f, 0.002f, 0.003f}, {0, 0, 0}}, forces{{4, 5, 6}, {0, 0, 1}};
  VertexField force = vertex_field("force [N]", forces);
  force.is_direction = true;
  ASSERT_TRUE(write_points(file, places, {force}, {.is_mm = true, .is_ras = true}));
  const std::string text = test::bytes_of(file);
  EXPECT_NE(text.find("NumberOfPoints=\"2\" NumberOfCells=\"2\""), text.npos);
  const auto holds = [&](std::vector<float> values) {
    return text.find(std::string(reinterpret_cast<const char*>(values.data()), 4 * values.size())) !=
           text.npos;
  };
  EXPECT_TRUE(holds({-4, -5, 6, 0, 0, 1}));  // newtons stay newtons
  EXPECT_TRUE(holds({-1, -2, 3}));           // places in millimetres
}

TEST(MeshFiles, PvdListsTimesAndFiles) {
  const std::string text = written("series.pvd", [](const auto& path) {
    return write_pvd(path, {{0, "a.vtu", "torso"}, {0.5, "b.vtu", "torso"}}, {.is_mm = true});
  });
  EXPECT_NE(text.find("<!-- Turgor: millimetres, patient frame LPS"), std::string::npos);
  EXPECT_NE(text.find("timestep=\"0.5\" part=\"0\" name=\"torso\" file=\"b.vtu\""), std::string::npos);
}

TEST(MeshFiles, AFolderThatIsNotThereIsNamed) {
  const Status status = write_obj("/nowhere/mesh.obj", two_triangles());
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().message, "/nowhere/mesh.obj: the folder /nowhere does not exist");
}

}  // namespace
}  // namespace turgor
