#include "turgor/io/mesh_files.hpp"

#include <cstring>

#include <gtest/gtest.h>

#include "folders.hpp"
#include "turgor/io/file.hpp"

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

TEST(MeshFiles, EmptyMeshesAreWritten) {
  const std::string text = written("empty.vtu", [](const auto& path) { return write_vtu(path, {}, {}); });
  EXPECT_TRUE(appended<float>(text, "points").empty());
}

TEST(MeshFiles, PvdListsTimesAndFiles) {
  const std::string text = written("series.pvd", [](const auto& path) {
    return write_pvd(path, {{0, "a.vtu", "torso"}, {0.5, "b.vtu", "torso"}});
  });
  EXPECT_NE(text.find("timestep=\"0.5\" part=\"0\" name=\"torso\" file=\"b.vtu\""), std::string::npos);
}

TEST(MeshFiles, AFolderThatIsNotThereIsNamed) {
  const Status status = write_obj("/nowhere/mesh.obj", two_triangles());
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().message, "/nowhere/mesh.obj: the folder /nowhere does not exist");
}

}  // namespace
}  // namespace turgor
