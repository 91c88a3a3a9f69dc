#include "turgor/io/mesh/mesh_files.hpp"

#include <cmath>
#include <cstring>

#include <gtest/gtest.h>

#include "tests/folders.hpp"
#include "turgor/io/files/file.hpp"
#include "turgor/io/mesh/surface_files.hpp"
#include "turgor/io/mesh/vtkhdf.hpp"

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

TEST(MeshFiles, AnObjOfMillimetersAndRasIsReadBackAsHalfATurnOfTheSame) {
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

TEST(MeshFiles, AVtuOfMillimetersAndRasHasItsLengthsInThemAndSaysSo) {
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

TEST(MeshFiles, WithoutAWishAVtuIsInMetersAndLps) {
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

// ------------------------------------------------------------ VTKHDF

/// What VTK's reader makes of a step, as the format's description says.
struct ReadStep {
  std::vector<float> points;
  std::vector<std::int64_t> corners;
};
ReadStep read_step(const Hdf5File& file, std::size_t step) {
  const auto all = [&file]<class T>(const std::string& name, T) {
    const std::string path = "/VTKHDF/" + name;
    return file.read<T>(path, file.count(path, 1000).value()).value();
  };
  const auto number = [&](const std::string& name, std::int64_t at) {
    return all(name, std::int64_t()).at(std::size_t(at));
  };
  const auto of_step = [&](const std::string& name) { return number("Steps/" + name, std::int64_t(step)); };
  const std::int64_t part = of_step("PartOffsets"), points = number("NumberOfPoints", part),
                     cells = number("NumberOfCells", part), ids = number("NumberOfConnectivityIds", part);
  const auto places = all("Points", float());
  const auto corners = all("Connectivity", std::int64_t()), ends = all("Offsets", std::int64_t());
  const std::int64_t point = 3 * of_step("PointOffsets"), id = of_step("ConnectivityIdOffsets");
  EXPECT_EQ(of_step("NumberOfParts"), 1);
  EXPECT_EQ(ends.at(std::size_t(of_step("CellOffsets") + part)), 0) << "each part begins anew";
  EXPECT_EQ(ends.at(std::size_t(of_step("CellOffsets") + part + cells)), ids);
  return {{places.begin() + point, places.begin() + point + 3 * points},
          {corners.begin() + id, corners.begin() + id + ids}};
}

TEST(VtkHdf, ASeriesOfSurfacesIsOneFileWhoseTrianglesStandThereOnceUntilTheyChange) {
  const std::filesystem::path path = test::fresh_folder() / "sheet.vtkhdf";
  TriMesh mesh = two_triangles(), cut = mesh;
  cut.vertices.push_back({2, 2, 2}), cut.triangles.push_back({1, 3, 4});
  const std::vector<TriMesh> steps{mesh, mesh, cut, cut};
  Result<VtkHdfSeries> series = VtkHdfSeries::create(path, {.is_mm = true, .is_ras = true});
  ASSERT_TRUE(series) << series.error().message;
  for (std::size_t n = 0; n < steps.size(); n++) {
    std::vector<Vec3> moved(steps[n].vertices.size(), Vec3{Real(n), 1, 2});
    std::vector<float> warmth(moved.size(), float(n));
    std::vector<VertexField> fields{length_field("displacement", moved), vertex_field("rub [1/s]", warmth)};
    if (n == 3) fields.pop_back();
    ASSERT_TRUE(series->add(0.25 * double(n), steps[n], fields));
  }
  ASSERT_TRUE(series->close());

  const Result<Hdf5File> file = Hdf5File::open(path);
  ASSERT_TRUE(file) << file.error().message;
  EXPECT_EQ(file->read_attribute("/VTKHDF", "Type"), "UnstructuredGrid");
  EXPECT_EQ(file->read_attribute("/VTKHDF", "SPACE"), "RAS");
  EXPECT_EQ(file->read_numbers("/VTKHDF", "Version"), (std::vector<std::int64_t>{2, 0}));
  EXPECT_EQ(file->read_numbers("/VTKHDF/Steps", "NSteps"), std::vector<std::int64_t>{4});
  EXPECT_EQ(file->read<double>("/VTKHDF/Steps/Values", 4).value(), (std::vector<double>{0, 0.25, 0.5, 0.75}));
  EXPECT_EQ(file->count("/VTKHDF/NumberOfCells", 9).value(), 2u) << "two meshes in four steps";
  EXPECT_EQ(file->count("/VTKHDF/Types", 9).value(), 5u);
  for (std::size_t n = 0; n < steps.size(); n++) {
    const ReadStep step = read_step(*file, n);
    ASSERT_EQ(step.points.size(), 3 * steps[n].vertices.size());
    EXPECT_EQ(step.points[3], -1000) << "mm, RAS";
    EXPECT_EQ(step.points.back(), 1000 * steps[n].vertices.back().z);
    std::vector<std::int64_t> corners;
    for (const Int3 t : steps[n].triangles) corners.insert(corners.end(), {t.x, t.y, t.z});
    EXPECT_EQ(step.corners, corners) << n;
  }
  const auto moved = file->read<float>("/VTKHDF/PointData/displacement [mm]", 3 * 18).value();
  EXPECT_EQ(std::vector<float>(moved.end() - 3, moved.end()), (std::vector<float>{-3000, -1000, 2000}));
  const auto warmth = file->read<float>("/VTKHDF/PointData/rub [1|s]", 18).value();
  EXPECT_EQ(warmth[8], 2);
  EXPECT_TRUE(std::isnan(warmth.back())) << "the last step has none";
  EXPECT_EQ(file->read<std::int64_t>("/VTKHDF/Steps/PointDataOffsets/rub [1|s]", 4).value(),
            (std::vector<std::int64_t>{0, 4, 8, 13}));
}

TEST(VtkHdf, PointsWithForcesAreStepsOfVertexCells) {
  const std::filesystem::path path = test::fresh_folder() / "forces.vtkhdf";
  Result<VtkHdfSeries> series = VtkHdfSeries::create(path);
  ASSERT_TRUE(series);
  const std::vector<Vec3> places{{1, 2, 3}, {4, 5, 6}};
  for (const double time : {0.0, 0.5})
    ASSERT_TRUE(series->add_points(time, places, {vertex_field("force [N]", places)}));
  ASSERT_TRUE(series->close());
  const Result<Hdf5File> file = Hdf5File::open(path);
  ASSERT_TRUE(file);
  EXPECT_EQ(file->read<std::uint8_t>("/VTKHDF/Types", 2).value(), (std::vector<std::uint8_t>{1, 1}));
  EXPECT_EQ(read_step(*file, 1).corners, (std::vector<std::int64_t>{0, 1}));
  EXPECT_EQ(read_step(*file, 1).points, (std::vector<float>{1, 2, 3, 4, 5, 6}));
  const auto nowhere = VtkHdfSeries::create("/nowhere/forces.vtkhdf");
  EXPECT_EQ(nowhere.error().message, "/nowhere/forces.vtkhdf: cannot make the file");
}

TEST(MeshFiles, AFolderThatIsNotThereIsNamed) {
  const Status status = write_obj("/nowhere/mesh.obj", two_triangles());
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().message, "/nowhere/mesh.obj: the folder /nowhere does not exist");
}

}  // namespace
}  // namespace turgor
