#include "turgor/io/mesh/surface_files.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/folders.hpp"
#include "tests/io/bytes.hpp"
#include "tests/io/damage.hpp"
#include "tests/io/mesh/meshlab.hpp"
#include "tests/refused.hpp"
#include "turgor/geometry/surface_edges.hpp"
#include "turgor/io/mesh/mesh_files.hpp"
#include "turgor/io/mesh/polygon.hpp"
#include "turgor/io/mesh/solid_files.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;
using namespace turgor::test;

const std::vector<Vec3> kCorners = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
const std::vector<Int3> kFaces = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};

/// The tetrahedron of these faces in every format.
std::string obj() {
  return "# by hand\nmtllib none.mtl\no tetrahedron\nv 0 0 0\nv 1 0 0 1.0\nv 0 1 0\nv 0 0 1 0.5 0.5 0.5\n"
         "vt 0 0\nvn 0 0 1\ns off\nusemtl none\nf 1/1/1 3/1/1 2/1/1\nf 1//1 2//1 4//1 # the front\n"
         "f -3 -2 \\\n-1\nf 3/1 1/1 4/1\n";
}
std::string stl() {
  std::string text = "solid a tetrahedron\n";
  for (const auto [a, b, c] : kFaces) {
    text += "  facet normal 0 0 nan\n    outer loop\n";
    for (const int v : {a, b, c}) {
      const Vec3 x = kCorners[std::size_t(v)];
      text += "      vertex " + std::to_string(x.x) + " " + std::to_string(x.y) + " " +
              std::to_string(-x.z * -1) + "\n";
    }
    text += "    endloop\n  endfacet\n";
  }
  return text + "endsolid a tetrahedron\n";
}
std::string stl_binary() {
  Bytes out(false);
  out.raw("solid, say some" + std::string(65, ' ')).ints({4});
  for (const auto [a, b, c] : kFaces) {
    for (int i = 0; i < 3; i++) out.add(0.f);
    for (const int v : {a, b, c})
      for (int axis = 0; axis < 3; axis++) out.add(kCorners[std::size_t(v)][axis]);
    out.add(std::uint16_t(0));
  }
  return out.text;
}
std::string ply_header(const std::string& format) {
  return "ply\nformat " + format +
         " 1.0\ncomment by hand\nelement vertex 4\nproperty uchar red\nproperty float x\nproperty double y\n"
         "property float z\nelement edge 1\nproperty list uchar ushort ends\nelement face 4\n"
         "property list uchar int vertex_indices\nproperty short flags\nend_header\n";
}
std::string ply() {
  std::string text = ply_header("ascii");
  for (const Vec3 x : kCorners)
    text += "255 " + std::to_string(x.x) + " " + std::to_string(x.y) + " " + std::to_string(x.z) + "\n";
  text += "2 0 1\n";
  for (const auto [a, b, c] : kFaces)
    text += "3 " + std::to_string(a) + " " + std::to_string(b) + " " + std::to_string(c) + " -1\n";
  return text;
}
std::string ply_binary(bool is_big_endian) {
  Bytes out(is_big_endian);
  out.raw(ply_header(is_big_endian ? "binary_big_endian" : "binary_little_endian"));
  for (const Vec3 x : kCorners) out.add(std::uint8_t(255)).add(x.x).add(double(x.y)).add(x.z);
  out.add(std::uint8_t(2)).add(std::uint16_t(0)).add(std::uint16_t(1));
  for (const auto [a, b, c] : kFaces) out.add(std::uint8_t(3)).ints({a, b, c}).add(std::int16_t(-1));
  return out.text;
}

/// Two polygons and a strip, plus one line and two isolated points.
std::string vtk(const std::string& version = "3.0") {
  return "# vtk DataFile Version " + version +
         "\nv 1 2 3 DATASET STRUCTURED_POINTS\nASCII\nDATASET POLYDATA\n"
         "POINTS 4 float\n0 0 0 1 0 0\n0 1 0 0 0 1\nVERTICES 2 4\n1 0\n1 1\nLINES 1 4\n3 0 1 2\n"
         "POLYGONS 2 8\n3 0 2 1\n3 2 0 3\nTRIANGLE_STRIPS 1 5\n4 0 1 3 2\n"
         "POINT_DATA 4\nNORMALS n float\n0 0 1 0 0 1 0 0 1 0 0 1\n";
}
std::string vtp() {
  return "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"0.1\" byte_order=\"LittleEndian\">\n"
         "<PolyData>\n<Piece NumberOfPoints=\"4\" NumberOfPolys=\"2\" NumberOfStrips=\"1\">\n<Points>\n"
         "<DataArray type=\"Float32\" NumberOfComponents=\"3\" format=\"ascii\">\n"
         "0 0 0 1 0 0 0 1 0 0 0 1</DataArray>\n</Points>\n<Polys>\n"
         "<DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">0 2 1 2 0 3</DataArray>\n"
         "<DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">3 6</DataArray>\n</Polys>\n<Strips>\n"
         "<DataArray type=\"Int32\" Name=\"connectivity\" format=\"ascii\">0 1 3 2</DataArray>\n"
         "<DataArray type=\"Int32\" Name=\"offsets\" format=\"ascii\">4</DataArray>\n</Strips>\n"
         "</Piece>\n</PolyData>\n</VTKFile>\n";
}

Result<ReadSurface> read_text(const std::string& text, const std::string& name = "mesh") {
  static const fs::path folder = fresh_folder();
  write(folder / name, text);
  return read_surface(folder / name);
}

double enclosed(const TriMesh& mesh) {
  double sum = 0;
  for (const auto [a, b, c] : mesh.triangles)
    sum += double(dot(mesh.vertices[std::size_t(a)],
                      cross(mesh.vertices[std::size_t(b)], mesh.vertices[std::size_t(c)]))) /
           6;
  return sum;
}

double area(const TriMesh& mesh) {
  double sum = 0;
  for (const auto [a, b, c] : mesh.triangles) {
    const Vec3 x = mesh.vertices[std::size_t(a)];
    sum += double(norm(cross(mesh.vertices[std::size_t(b)] - x, mesh.vertices[std::size_t(c)] - x))) / 2;
  }
  return sum;
}

struct Sample {
  const char* format;
  std::string text;
};
const std::vector<Sample>& samples() {
  static const std::vector<Sample> all = {{"OBJ", obj()},
                                          {"STL", stl()},
                                          {"STL (binary)", stl_binary()},
                                          {"PLY", ply()},
                                          {"PLY (binary)", ply_binary(false)},
                                          {"PLY (binary)", ply_binary(true)},
                                          {"OBJ", meshlab_obj({kCorners, kFaces})},
                                          {"PLY (binary)", meshlab_ply({kCorners, kFaces})},
                                          {"VTP", vtp()}};
  return all;
}

void expect_tetrahedron(const Result<ReadSurface>& read, const std::string& format) {
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->format, format);
  EXPECT_EQ(read->mesh.vertices.size(), 4u);
  EXPECT_EQ(read->mesh.triangles.size(), 4u);
  EXPECT_NEAR(enclosed(read->mesh), 1 / 6.0, 1e-7);
  for_each_edge(sorted_edges(read->mesh.triangles), [](std::span<const EdgeUse> uses) {
    ASSERT_EQ(uses.size(), 2u);
    EXPECT_NE(uses[0].forward, uses[1].forward);
  });
}

// Every format gives the same closed tetrahedron.
TEST(SurfaceFiles, FormatsGiveSameTetrahedron) {
  for (const Sample& sample : samples()) {
    SCOPED_TRACE(sample.format);
    const Result<ReadSurface> read = read_text(sample.text);
    expect_tetrahedron(read, sample.format);
    EXPECT_TRUE(read && read->notes.empty());
  }
}

const std::vector<std::string> kLeftOut = {"ignored: 2 single points", "ignored: 1 line"};

// Lines and points of a VTK file are skipped with notes.
TEST(SurfaceFiles, VtkLinesAndPointsAreSkipped) {
  const Result<ReadSurface> read = read_text(vtk(), "mesh.vtk");
  expect_tetrahedron(read, "VTK 3.0");
  EXPECT_EQ(read->notes, kLeftOut);
}

// Files from the writers of VTK are read in every encoding and byte order.
TEST(SurfaceFiles, ReadsVtkWriterOutput) {
  const fs::path corpus = fs::path(TURGOR_SOURCE_DIR) / "tests" / "fuzz" / "corpus" / "surface";
  const struct {
    const char *name, *format;
    bool has_more;  // a line and two points
  } files[] = {{"text.vtp", "VTP", true},
               {"inline-big.vtp", "VTP", false},
               {"inline-zlib.vtp", "VTP (compressed)", false},
               {"raw.vtp", "VTP", false},
               {"raw-zlib-big.vtp", "VTP (compressed)", false},
               {"base64-zlib.vtp", "VTP (compressed)", false},
               {"vtk4.vtk", "VTK 4.2", true},
               {"vtk4-binary.vtk", "VTK 4.2 (binary)", false},
               {"vtk4-binary-ids.vtk", "VTK 4.2 (binary)", false},
               {"vtk5.vtk", "VTK 5.1", false},
               {"vtk5-binary.vtk", "VTK 5.1 (binary)", true}};
  for (const auto& file : files) {
    SCOPED_TRACE(file.name);
    const Result<ReadSurface> read = read_surface(corpus / file.name);
    expect_tetrahedron(read, file.format);
    EXPECT_EQ(read->notes, file.has_more ? kLeftOut : std::vector<std::string>());
    EXPECT_TRUE(is_surface_file(corpus / file.name));
    EXPECT_FALSE(is_solid_file(corpus / file.name)) << "otherwise turgor info would read it as a solid mesh";
  }
}

// A file that declares the RAS frame gives a note.
TEST(SurfaceFiles, RasFrameIsNoted) {
  const fs::path folder = fresh_folder();
  const auto notes = [&](const std::string& text) {
    const Result<ReadSurface> read = read_text(text);
    EXPECT_TRUE(read) << text;
    return read ? read->notes.size() : 0;
  };
  ASSERT_TRUE(write_obj(folder / "ras.obj", {kCorners, kFaces}, {.is_ras = true}));
  ASSERT_TRUE(write_obj(folder / "lps.obj", {kCorners, kFaces}));
  EXPECT_EQ(read_surface(folder / "ras.obj")->notes.size(), 1u);
  EXPECT_EQ(read_surface(folder / "lps.obj")->notes.size(), 0u);
  std::string text = vtp();
  const std::string fields =
      "<FieldData><Array type=\"String\" Name=\"SPACE\" format=\"ascii\">\n 82 65 83 0</Array></FieldData>";
  EXPECT_EQ(notes(text.insert(text.find("<Piece"), fields)), 1u);
  EXPECT_EQ(notes(text.replace(text.find("82 65"), 5, "76 80")), 0u);
  text = ply();
  EXPECT_EQ(notes(text.insert(text.find("comment"), "comment SPACE=RAS\n")), 1u);
}

// Pieces of a VTP file are welded at common vertices.
TEST(SurfaceFiles, VtpPiecesAreWelded) {
  std::string text = vtp();
  const std::size_t begin = text.find("<Piece"), end = text.find("</PolyData>");
  std::string second = text.substr(begin, end - begin);
  second.replace(second.find("0 0 0 1 0 0 0 1 0 0 0 1"), 23, "0 0 0 0 1 0 1 0 0 0 0 -1");
  const Result<ReadSurface> read = read_text(text.insert(end, second), "mesh.vtp");
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->mesh.triangles.size(), 8u);
  EXPECT_EQ(read->mesh.vertices.size(), 5u);
}

// Coincident vertices are merged; positive and negative zero are equal.
TEST(SurfaceFiles, CoincidentVerticesAreMerged) {
  const Result<ReadSurface> read =
      read_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv -0 0 -0\nv 0 1 0\nv 0 0 1\nv 5 5 5\nf 1 2 3\nf 4 5 6\n");
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->mesh.triangles, (std::vector<Int3>{{0, 1, 2}, {0, 2, 3}}));
  EXPECT_EQ(read->mesh.vertices.size(), 4u);
}

// Triangles with coincident corners are dropped and counted.
TEST(SurfaceFiles, DegenerateTrianglesAreDropped) {
  const Result<ReadSurface> read = read_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 0 0\nf 1 2 3\nf 1 2 4\n");
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->mesh.triangles.size(), 1u);
  EXPECT_EQ(read->notes, std::vector<std::string>{"dropped: 1 triangle with coincident corners"});
}

// Triangles cover a convex or concave polygon exactly once.
TEST(SurfaceFiles, PolygonsAreTriangulatedExactly) {
  // A square, an L and an arrow, each in a tilted plane.
  const struct {
    std::vector<Vec3d> corners;
    double area;
  } polygons[] = {{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, 1},
                  {{{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {1, 1, 0}, {1, 2, 0}, {0, 2, 0}}, 3},
                  {{{1, 1, 0}, {0, 3, 0}, {0, 0, 0}, {3, 0, 0}}, 3}};
  for (const auto& polygon : polygons) {
    std::string text, face = "f";
    for (std::size_t c = 0; c < polygon.corners.size(); c++) {
      const Vec3d x = polygon.corners[c];
      text += "v " + std::to_string(x.x * 0.6) + " " + std::to_string(x.y) + " " + std::to_string(x.x * 0.8) +
              "\n";
      face += " " + std::to_string(c + 1);
    }
    const Result<ReadSurface> read = read_text(text + face + "\n");
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_EQ(read->mesh.triangles.size(), polygon.corners.size() - 2);
    EXPECT_NEAR(area(read->mesh), polygon.area, 1e-6);
  }
}

// A written OBJ file is read back, scaled by the given factor.
TEST(SurfaceFiles, ObjRoundTrips) {
  const fs::path folder = fresh_folder();
  ASSERT_TRUE(write_obj(folder / "a.obj", {kCorners, kFaces}));
  const Result<ReadSurface> read = read_surface(folder / "a.obj", 2);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->mesh.triangles, kFaces);
  EXPECT_EQ(read->mesh.vertices[3], (Vec3{0, 0, 2}));
}

// Errors for damaged files state file, position, expected and found values.
TEST(SurfaceFiles, DamageIsLocated) {
  const Damage table[] = {
      {obj(), "v 0 1 0", "v 0 nan 0", "vertex 3: expected finite coordinates"},
      {obj(), "v 0 1 0", "v 0 1", ":6: expected a coordinate, found the end of the line"},
      {obj(), "v 0 1 0", "v 0 1 zero", ":6: expected a coordinate, found \"zero\""},
      {obj(), "f 1/1/1", "f 9/1/1", "polygon 1: expected vertices from 1 to 4, found 9"},
      {obj(), "f 1/1/1", "f 0/1/1", ":12: expected the number of a vertex, found \"0/1/1\""},
      {obj(), "f -3", "f -5", ":15: expected the number of a vertex, found \"-5\""},
      {obj(), "f 3/1 1/1 4/1", "f 3/1 1/1", ":16: expected a face of at least 3 corners, found 2"},
      {stl(), "outer loop", "inner loop", ":3: expected outer, found \"inner\""},
      {stl(), "endsolid a tetrahedron\n", "", "expected endsolid, found the end of the file"},
      {stl_binary(), std::string("\4\0\0\0", 4), std::string("\5\0\0\0", 4),
       "byte 80: expected a number of triangles that the rest of the file can hold, found 5"},
      {ply(), "element vertex 4", "element vertex 4000000", ":4: expected a number of elements that"},
      {ply(), "property float x", "property float u", "expected vertices with x, y and z, found others"},
      {ply(), "property float x", "property string x",
       ":6: expected a type such as float or int, found \"string\""},
      {ply(), "3 0 2 1 -1", "3 0 2 9 -1", "polygon 1: expected vertices from 0 to 3, found 9"},
      {ply(), "3 0 2 1 -1", "3 0 2 -1 -1", "expected the number of a vertex, found -1"},
      {ply(), "3 0 2 1 -1", "300 0 2 1 -1",
       "expected the length of a list that the rest of the file can hold, found 300"},
      {ply(), "ascii", "zip", ":2: expected ascii, binary_little_endian or binary_big_endian, found \"zip\""},
      {ply(), "element face 4", "element face 0", "expected triangles, found none in this PLY file"},
      {vtk(), "3 2 0 3", "3 2 0 4", "polygon 1: expected points from 0 to 3, found 4"},
      {vtk(), "3 2 0 3", "3 2 0 -1", "polygon 1: expected points from 0 to 3, found -1"},
      {vtk(), "4 0 1 3 2", "4 0 1 3 9", "strip 0: expected points from 0 to 3, found 9"},
      {vtk(), "POLYGONS 2 8\n3 0 2 1\n3 2 0 3", "POLYGONS 2 7\n3 0 2 1\n2 2 0",
       "polygon 1: expected at least 3 points, found 2"},
      {vtk(), "POLYGONS 2 8", "POLYGONS 3 8", ":15: expected 3 cells, found 2"},
      {vtk(), "POLYGONS 2 8", "POLYGONS 2 80000000", ":13: expected a number of numbers that"},
      {vtk(), "POINTS 4 float", "POINTS 4 letters", ":5: expected a type of numbers such as float or int"},
      {vtp(), "0 2 1 2 0 3", "0 2 1 2 0 4", ":4: polygon 1: expected points from 0 to 3, found 4"},
      {vtp(), ">3 6<", ">3 9<", ":10: expected a count of numbers that"},
      {vtp(), ">3 6<", ">7 6<", ":4: polygon 0: expected its points to end between 0 and 6, found 7"},
      {vtp(), "NumberOfPolys=\"2\"", "NumberOfPolys=\"99999999\"",
       ":4: expected NumberOfPolys that the file can hold, found 99999999"},
      {vtp(), "<Polys>", "<Pols>", "expected XML, found an error"},
      {vtp(), "Name=\"offsets\"", "Name=\"off\"", "expected points, connectivity, offsets"},
  };
  for (const Damage& damage : table) {
    SCOPED_TRACE(damage.from + " -> " + damage.to);
    EXPECT_REFUSED(read_text(damaged(damage), "mesh.stl"), std::string("/mesh.stl"), damage.message);
  }
}

// A concave polygon with too many corners is rejected, because ear clipping takes quadratic time.
TEST(SurfaceFiles, RejectsLargeConcavePolygon) {
  std::string text, face = "f";
  for (int c = 0; c < 600; c++) {
    text += "v " + std::to_string(c % 2 ? 1 + c : c) + " " + std::to_string(c * c) + " 0\n";
    face += " " + std::to_string(c + 1);
  }
  EXPECT_REFUSED(read_text(text + face + "\n"),
                 "polygon 1: expected at most 500 corners where it is not convex");
}

// A convex polygon with a million corners becomes a triangle fan in linear time.
TEST(SurfaceFiles, LargeConvexPolygonIsFan) {
  std::vector<Vec3d> corners;
  for (int i = 0; i < 1000000; i++) {
    const double angle = i * 2e-6 * std::numbers::pi;
    corners.push_back({std::cos(angle), std::sin(angle), 0});
  }
  const std::vector<Int3> fan = io::triangulate(corners);  // ear clipping would take minutes
  ASSERT_EQ(fan.size(), corners.size() - 2);
  EXPECT_EQ(fan.front(), (Int3{0, 1, 2}));
  EXPECT_EQ(fan.back(), (Int3{0, 999998, 999999}));
}

// Missing files and files that are no surface are rejected by name.
TEST(SurfaceFiles, RejectsNonSurfaceFiles) {
  const fs::path folder = fresh_folder();
  EXPECT_REFUSED(read_surface(folder / "gone.obj"), "gone.obj: does not exist");
  EXPECT_REFUSED(read_text("$MeshFormat\n2.2 0 8\n"),
                 "expected a surface (OBJ, STL, PLY, VTP, VTK), found \"$MeshFormat\"");
  write(folder / "a.ply", ply());
  EXPECT_TRUE(is_surface_file(folder / "a.ply"));
  EXPECT_FALSE(is_surface_file(folder / "gone.ply"));
}

// A liver in centimeters is read as one closed surface.
TEST(SurfaceFiles, LiverInCentimetersIsClosed) {
  const fs::path path = fs::path(TURGOR_SOURCE_DIR) / ".." / "shared" / "data" / "mesh" / "liver-smooth.obj";
  if (!fs::exists(path)) GTEST_SKIP() << path.string() << " is absent: real data is not part of the project";
  const Result<ReadSurface> read = read_surface(path, 0.01);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->mesh.vertices.size(), 2194u);
  EXPECT_EQ(read->mesh.triangles.size(), 4384u);
  EXPECT_TRUE(read->notes.empty());
  EXPECT_GT(enclosed(read->mesh), 0);
}

}  // namespace
}  // namespace turgor
