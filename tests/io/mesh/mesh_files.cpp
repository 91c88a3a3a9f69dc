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

/// Value of an attribute of the first element that contains `anchor`.
std::string attribute(const std::string& text, const std::string& anchor, const std::string& name) {
  const std::size_t begin = text.find(name + "=\"", text.find(anchor)) + name.size() + 2;
  return text.substr(begin, text.find('"', begin) - begin);
}

/// Values of an appended array.
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

// OBJ indices start at one, and faces refer to normals if the mesh has them.
TEST(MeshFiles, ObjIndicesStartAtOne) {
  TriMesh mesh = two_triangles();
  const std::string plain = written("plain.obj", [&](const auto& path) { return write_obj(path, mesh); });
  EXPECT_NE(plain.find("\nf 1 2 3\nf 3 2 4\n"), std::string::npos);
  EXPECT_NE(plain.find("\nv 1 1 0.5\n"), std::string::npos);
  mesh.normals = vertex_normals(mesh);
  const std::string smooth = written("smooth.obj", [&](const auto& path) { return write_obj(path, mesh); });
  EXPECT_NE(smooth.find("\nf 3//3 2//2 4//4\n"), std::string::npos);
}

// An OBJ read again has the same bits, whatever the size of the mesh.
TEST(MeshFiles, ObjKeepsBits) {
  for (const float scale : {3e-7f, 0.0123456789f, 12.3456789f}) {
    TriMesh mesh = two_triangles();
    for (Vec3& x : mesh.vertices) x = (x + Vec3{0.1f, 1.0f / 3, 0.7f}) * scale;
    const std::filesystem::path path = test::fresh_folder() / "small.obj";
    ASSERT_TRUE(write_obj(path, mesh));
    const Result<ReadSurface> read = read_surface(path);
    ASSERT_TRUE(read) << read.error().message;
    ASSERT_EQ(read->mesh.vertices.size(), mesh.vertices.size());
    for (std::size_t v = 0; v < mesh.vertices.size(); v++)
      EXPECT_TRUE(read->mesh.vertices[v] == mesh.vertices[v]) << scale << ", vertex " << v;
  }
}

// The name of an OBJ group precedes its first face.
TEST(MeshFiles, ObjWritesGroups) {
  const std::vector<MeshGroup> groups{{"skin", 0}, {"wound", 1}};
  const std::string text =
      written("groups.obj", [&](const auto& path) { return write_obj(path, two_triangles(), {}, groups); });
  EXPECT_NE(text.find("\ng skin\nf 1 2 3\ng wound\nf 3 2 4\n"), std::string::npos) << text;
}

// A VTU file stores points, cells and fields as appended binary arrays.
TEST(MeshFiles, VtuAppendsBinaryArrays) {
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

// An OBJ file in millimeters and RAS is read back rotated by half a turn about z.
TEST(MeshFiles, ObjInRasRoundTrips) {
  TriMesh mesh = two_triangles();
  mesh.vertices[3] = {0.0123456f, -0.25f, 0.5f};
  mesh.normals = vertex_normals(mesh);
  const std::string path = test::fresh_folder() / "a.obj";
  ASSERT_TRUE(write_obj(path, mesh, {.is_mm = true, .is_ras = true}));
  const std::string text = read_file(path).value();
  EXPECT_TRUE(
      text.starts_with("# Turgor: millimeters, patient frame RAS (x to the right, y to the front, z "
                       "to the head)\n# SPACE=RAS\n"))
      << text;
  EXPECT_EQ(text.find("-0 "), std::string::npos) << "zero is written without a sign";
  const Result<ReadSurface> read = read_surface(path, 0.001);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->mesh.triangles, mesh.triangles) << "a rotation keeps the winding";
  ASSERT_EQ(read->mesh.vertices.size(), 4u);
  for (std::size_t v = 0; v < 4; v++) {
    const Vec3 x = mesh.vertices[v];
    EXPECT_NEAR(norm(read->mesh.vertices[v] - Vec3{-x.x, -x.y, x.z}), 0, 1e-7) << v;
  }
}

// A VTU file in millimeters and RAS converts its lengths and states unit and frame.
TEST(MeshFiles, VtuConvertsUnitsAndFrame) {
  TriMesh mesh = two_triangles();
  mesh.normals = std::vector<Vec3>(4, {1, 0, 0});
  const std::vector<Vec3> moved = {{0.001f, 0.002f, 0.003f}, {}, {}, {}};
  const std::vector<float> lengths = {0.5f, 0, 0, 0}, pressure = {7, 0, 0, 0};
  const std::string text = written("mesh.vtu", [&](const auto& path) {
    return write_vtu(path, mesh,
                     {length_field("displacement", moved), length_field("distance", lengths),
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
  EXPECT_EQ(appended<float>(text, "distance [mm]")[0], 500);
  EXPECT_EQ(appended<float>(text, "pressure [Pa]")[0], 7);
  EXPECT_NE(text.find("<!-- Turgor: millimeters, patient frame RAS"), std::string::npos);
  EXPECT_NE(text.find("Name=\"SPACE\" NumberOfTuples=\"1\" format=\"ascii\">82 65 83 0<"), std::string::npos);
  EXPECT_NE(text.find("Name=\"unit\" NumberOfTuples=\"1\" format=\"ascii\">109 109 0<"), std::string::npos);
}

// A VTU file is in meters and LPS by default.
TEST(MeshFiles, VtuDefaultsToMetersAndLps) {
  const std::vector<Vec3> moved(4, {0.001f, 0.002f, 0.003f});
  const std::string text = written("mesh.vtu", [&](const auto& path) {
    return write_vtu(path, two_triangles(), {length_field("displacement", moved)});
  });
  EXPECT_EQ(appended<float>(text, "displacement [m]")[1], 0.002f);
  EXPECT_NE(text.find("<!-- Turgor: meters, patient frame LPS"), std::string::npos);
  EXPECT_NE(text.find(">76 80 83 0<"), std::string::npos);
}

// An empty mesh is written without points.
TEST(MeshFiles, WritesEmptyMesh) {
  const std::string text = written("empty.vtu", [](const auto& path) { return write_vtu(path, {}, {}); });
  EXPECT_TRUE(appended<float>(text, "points").empty());
}

// Points are vertex cells; their directions follow the axes of the file and are not scaled.
TEST(MeshFiles, PointsAreVertexCells) {
  const std::filesystem::path file = test::fresh_folder() / "a.vtu";
  const std::vector<Vec3> positions{{0.001f, 0.002f, 0.003f}, {0, 0, 0}}, forces{{4, 5, 6}, {0, 0, 1}};
  VertexField force = vertex_field("force [N]", forces);
  force.is_direction = true;
  ASSERT_TRUE(write_points(file, positions, {force}, {.is_mm = true, .is_ras = true}));
  const std::string text = test::bytes_of(file);
  EXPECT_NE(text.find("NumberOfPoints=\"2\" NumberOfCells=\"2\""), text.npos);
  const auto holds = [&](std::vector<float> values) {
    return text.find(std::string(reinterpret_cast<const char*>(values.data()), 4 * values.size())) !=
           text.npos;
  };
  EXPECT_TRUE(holds({-4, -5, 6, 0, 0, 1}));  // newtons are not scaled
  EXPECT_TRUE(holds({-1, -2, 3}));           // positions in millimeters
}

// A PVD file lists times, files and names.
TEST(MeshFiles, PvdListsTimesAndFiles) {
  const std::string text = written("series.pvd", [](const auto& path) {
    return write_pvd(path, {{0, "a.vtu", "torso"}, {0.5, "b.vtu", "torso"}}, {.is_mm = true});
  });
  EXPECT_NE(text.find("<!-- Turgor: millimeters, patient frame LPS"), std::string::npos);
  EXPECT_NE(text.find("timestep=\"0.5\" part=\"0\" name=\"torso\" file=\"b.vtu\""), std::string::npos);
}

// VTKHDF

/// One step as VTK's reader assembles it, according to the description of the format.
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
  const std::int64_t partition = of_step("PartOffsets"), points = number("NumberOfPoints", partition),
                     cells = number("NumberOfCells", partition),
                     ids = number("NumberOfConnectivityIds", partition);
  const auto positions = all("Points", float());
  const auto corners = all("Connectivity", std::int64_t()), ends = all("Offsets", std::int64_t());
  const std::int64_t point = 3 * of_step("PointOffsets"), id = of_step("ConnectivityIdOffsets");
  EXPECT_EQ(of_step("NumberOfParts"), 1);
  EXPECT_EQ(ends.at(std::size_t(of_step("CellOffsets") + partition)), 0) << "offsets restart in each part";
  EXPECT_EQ(ends.at(std::size_t(of_step("CellOffsets") + partition + cells)), ids);
  return {{positions.begin() + point, positions.begin() + point + 3 * points},
          {corners.begin() + id, corners.begin() + id + ids}};
}

// A series of surfaces is one VTKHDF file that stores triangles only when they change.
TEST(MeshFiles, VtkHdfSharesUnchangedTriangles) {
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
  EXPECT_EQ(file->count("/VTKHDF/NumberOfCells", 9).value(), 2u) << "two topologies in four steps";
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
  EXPECT_TRUE(std::isnan(warmth.back())) << "the last step has no such field";
  EXPECT_EQ(file->read<std::int64_t>("/VTKHDF/Steps/PointDataOffsets/rub [1|s]", 4).value(),
            (std::vector<std::int64_t>{0, 4, 8, 13}));
}

// Points with forces are stored as vertex cells for every step.
TEST(MeshFiles, VtkHdfStoresPointsPerStep) {
  const std::filesystem::path path = test::fresh_folder() / "forces.vtkhdf";
  Result<VtkHdfSeries> series = VtkHdfSeries::create(path);
  ASSERT_TRUE(series);
  const std::vector<Vec3> positions{{1, 2, 3}, {4, 5, 6}};
  for (const double time : {0.0, 0.5})
    ASSERT_TRUE(series->add_points(time, positions, {vertex_field("force [N]", positions)}));
  ASSERT_TRUE(series->close());
  const Result<Hdf5File> file = Hdf5File::open(path);
  ASSERT_TRUE(file);
  EXPECT_EQ(file->read<std::uint8_t>("/VTKHDF/Types", 2).value(), (std::vector<std::uint8_t>{1, 1}));
  EXPECT_EQ(read_step(*file, 1).corners, (std::vector<std::int64_t>{0, 1}));
  EXPECT_EQ(read_step(*file, 1).points, (std::vector<float>{1, 2, 3, 4, 5, 6}));
  const auto missing = VtkHdfSeries::create("/nowhere/forces.vtkhdf");
  EXPECT_EQ(missing.error().message, "/nowhere/forces.vtkhdf: cannot create the file");
}

// Writing into a missing folder fails, and the error names the folder.
TEST(MeshFiles, MissingFolderIsNamed) {
  const Status status = write_obj("/nowhere/mesh.obj", two_triangles());
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().message, "/nowhere/mesh.obj: the folder /nowhere does not exist");
}

}  // namespace
}  // namespace turgor
