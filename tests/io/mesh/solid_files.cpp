#include "turgor/io/mesh/solid_files.hpp"

#include <gtest/gtest.h>

#include "tests/folders.hpp"
#include "tests/io/damage.hpp"
#include "tests/io/mesh/solid_samples.hpp"
#include "tests/refused.hpp"
#include "turgor/geometry/hex_block.hpp"
#include "turgor/io/mesh/mesh_files.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;
using namespace turgor::test;

Result<ReadSolid> read_text(const std::string& text) {
  static const fs::path folder = fresh_folder();
  write(folder / "mesh", text);
  return read_solid(folder / "mesh");
}

void expect_same(const Result<ReadSolid>& read, const SolidMesh& mesh) {
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->mesh.vertices, mesh.vertices);
  EXPECT_EQ(read->mesh.corners, mesh.corners);
  EXPECT_EQ(read->mesh.elements, mesh.elements);
  EXPECT_EQ(read->mesh.regions, mesh.regions);
}

struct Sample {
  const char* format;
  std::string text;
};
const std::vector<Sample>& samples() {
  static const std::vector<Sample> all = {
      {"Gmsh 1.0", gmsh_1()},
      {"Gmsh 2.2", gmsh_2()},
      {"Gmsh 2.2 (binary)", gmsh_2_binary(false)},
      {"Gmsh 2.2 (binary)", gmsh_2_binary(true)},
      {"Gmsh 4.1", gmsh_4()},
      {"Gmsh 4.1 (binary)", gmsh_4_binary(false)},
      {"Gmsh 4.1 (binary)", gmsh_4_binary(true)},
      {"VTK 3.0", vtk()},
      {"VTK 4.2 (binary)", vtk_binary()},
      {"VTK 5.1 (binary)", vtk_5_binary()},
      {"VTU", vtu()},
      {"Medit", medit()},
  };
  return all;
}

// Every format gives the same tetrahedra, regions and nodes.
TEST(SolidFiles, FormatsGiveSameMesh) {
  for (const Sample& sample : samples()) {
    SCOPED_TRACE(sample.format);
    const Result<ReadSolid> read = read_text(sample.text);
    expect_same(read, sample_mesh());
    EXPECT_EQ(read->format, sample.format);
    EXPECT_EQ(read->notes, std::vector<std::string>{"dropped: 1 node that no element uses"});
  }
}

// A TetGen pair is read by the name of either file, with indices from 0 or 1.
TEST(SolidFiles, ReadsTetGenPair) {
  for (const int first : {0, 1}) {
    const fs::path folder = fresh_folder();
    write(folder / "organ.1.node", tetgen_node(first));
    write(folder / "organ.1.ele", tetgen_ele(first));
    expect_same(read_solid(folder / "organ.1.node"), sample_mesh());
    expect_same(read_solid(folder / "organ.1.ele"), sample_mesh());
  }
}

// VTU files from the writer of VTK are read in every encoding and byte order.
TEST(SolidFiles, ReadsVtkWriterOutput) {
  const fs::path corpus = fs::path(TURGOR_SOURCE_DIR) / "tests" / "fuzz" / "corpus" / "solid";
  for (const char* name : {"appended-base64.vtu", "appended-base64-zlib.vtu", "appended-raw-zlib-big.vtu",
                           "inline-base64-big.vtu", "inline-zlib.vtu"}) {
    SCOPED_TRACE(name);
    expect_same(read_solid(corpus / name), sample_mesh());
  }
}

// Ids of a binary legacy file, whose type is vtkIdType, have 4 bytes, as VTK writes them. Its region is such
// an id; another field is of type vtktypeuint64.
TEST(SolidFiles, VtkIdsHaveFourBytes) {
  const Result<ReadSolid> read =
      read_solid(fs::path(TURGOR_SOURCE_DIR) / "tests" / "fuzz" / "corpus" / "solid" / "vtk4-binary-ids.vtk");
  expect_same(read, {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, 4, {0, 1, 2, 3}, {5}});
  EXPECT_TRUE(read && read->notes.empty());
}

// A scale of 0.001 converts millimeters to meters.
TEST(SolidFiles, ScaleConvertsMillimeters) {
  const fs::path folder = fresh_folder();
  write(folder / "mesh", gmsh_1());
  const Result<ReadSolid> read = read_solid(folder / "mesh", 1e-3);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->mesh.vertices[4], (Vec3d{0, 0, 0.0015}));
}

// MSH and VTU files are read back exactly.
TEST(SolidFiles, MeshRoundTripsExactly) {
  const fs::path folder = fresh_folder();
  SolidMesh tets = tetrahedralize(hex_block({0.1, 0.2, 0.3}, {2, 3, 4}));
  for (Vec3d& x : tets.vertices) x = x * (1 / 3.0);
  for (std::size_t e = 0; e < element_count(tets); e++) tets.regions.push_back(int(e % 3));
  for (const SolidMesh& mesh : {tets, hex_block({1, 2, 3}, {2, 1, 2})}) {
    ASSERT_TRUE(write_msh(folder / "mesh", mesh));
    expect_same(read_solid(folder / "mesh"), mesh);
    ASSERT_TRUE(write_vtu(folder / "mesh", mesh, {}, {}));
    expect_same(read_solid(folder / "mesh"), mesh);
  }
}

// Fields in a VTU file do not change its mesh.
TEST(SolidFiles, VtuFieldsKeepMesh) {
  const fs::path folder = fresh_folder();
  const SolidMesh mesh = sample_mesh();
  const std::vector<Vec3> displacement(5, {1, 2, 3});
  const std::vector<float> pressure = {4, 5};
  ASSERT_TRUE(write_vtu(folder / "mesh", mesh, {length_field("displacement", displacement)},
                        {vertex_field("pressure [Pa]", pressure)}));
  expect_same(read_solid(folder / "mesh"), mesh);
}

// Inverted tetrahedra are reoriented with a note.
TEST(SolidFiles, ReorientsInvertedTetrahedra) {
  const Result<ReadSolid> read = read_text(
      "MeshVersionFormatted 1 Dimension 3 Vertices 5  0 0 0 0  1 0 0 0  0 1 0 0  0 0 1 0  0 0 -1 0\n"
      "Tetrahedra 2  1 2 3 4 0  1 2 3 5 0");
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->inverted, 1u);
  EXPECT_EQ(read->notes[0], "1 of 2 tetrahedra were inverted and have been reoriented: 2");
  for (std::size_t e = 0; e < 2; e++) EXPECT_NEAR(volume(read->mesh, e), 1 / 6.0, 1e-15);
}

// Inverted hexahedra are reoriented; twisted ones are rejected.
TEST(SolidFiles, ReorientsHexahedraRejectsTwisted) {
  const fs::path folder = fresh_folder();
  SolidMesh block = hex_block({1, 1, 1}, {2, 1, 1});
  for (Vec3d& x : block.vertices) x.x = -x.x;
  ASSERT_TRUE(write_msh(folder / "mesh", block));
  const Result<ReadSolid> read = read_solid(folder / "mesh");
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->inverted, 2u);
  EXPECT_NEAR(volume(read->mesh), 1, 1e-15);
  std::swap(block.elements[4], block.elements[5]);
  ASSERT_TRUE(write_msh(folder / "mesh", block));
  EXPECT_REFUSED(read_solid(folder / "mesh"), "expected convex hexahedra, found 1 inverted at a corner: 1");
}

// A file with mixed elements gives its tetrahedra and a note about the others.
TEST(SolidFiles, MixedElementsKeepTetrahedra) {
  std::string text = gmsh_2();
  text.replace(text.find("$Elements\n3"), 11, "$Elements\n4\n9 5 0 10 20 30 40 70 99 10 20");
  const Result<ReadSolid> read = read_text(text);
  expect_same(read, sample_mesh());
  EXPECT_EQ(read->notes[0], "ignored: 1 solid element other than tetrahedra");
}

// Quadratic tetrahedra are reduced to their corner nodes with a note.
TEST(SolidFiles, QuadraticTetrahedraKeepCorners) {
  const Result<ReadSolid> read = read_text(
      "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n10\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 .5 0 0\n"
      "6 .5 .5 0\n7 0 .5 0\n8 0 0 .5\n9 0 .5 .5\n10 .5 0 .5\n$EndNodes\n"
      "$Elements\n1\n1 11 0 1 2 3 4 5 6 7 8 9 10\n$EndElements\n");
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->mesh.elements, (std::vector<int>{0, 1, 2, 3}));
  EXPECT_EQ(read->mesh.vertices.size(), 4u);
  EXPECT_EQ(read->notes[0], "only the corner nodes of 1 element are used");
}

// A VTK voxel becomes a hexahedron.
TEST(SolidFiles, VtkVoxelIsHexahedron) {
  const Result<ReadSolid> read = read_text(
      "# vtk DataFile Version 3.0\nv\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 8 float\n0 0 0 1 0 0 0 2 0 1 "
      "2 0\n"
      "0 0 3 1 0 3 0 2 3 1 2 3\nCELLS 1 9\n8 0 1 2 3 4 5 6 7\nCELL_TYPES 1\n11\n");
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->mesh.corners, 8);
  EXPECT_NEAR(volume(read->mesh), 6, 1e-12);
  EXPECT_TRUE(read->notes.empty());
}

// A flat tetrahedron is rejected with its number in the file.
TEST(SolidFiles, FlatTetrahedronIsNamed) {
  std::string text = gmsh_2();
  text.replace(text.find("8 4 3 7 1 0 20 70 30 40"), 23, "8 4 3 7 1 0 20 20 30 40");
  EXPECT_REFUSED(read_text(text), "expected tetrahedra with a volume, found 1 flat: 8");
}

// An element listed twice is rejected with both numbers, also if its corners are in another order.
TEST(SolidFiles, RepeatedElementsAreNamed) {
  std::string text = gmsh_2();
  text.replace(text.find("$Elements\n3"), 11, "$Elements\n4\n9 4 3 7 1 0 30 20 70 40");
  EXPECT_REFUSED(read_text(text), "/mesh",
                 "expected every element once, found 1 of 3 tetrahedra with the corners of another: 8 "
                 "repeats 9");
  const fs::path folder = fresh_folder();
  SolidMesh twice = hex_block({1, 1, 1}, {2, 2, 2});
  const std::vector<int> once = twice.elements;
  twice.elements.insert(twice.elements.end(), once.begin(), once.end());
  ASSERT_TRUE(write_msh(folder / "mesh", twice));
  EXPECT_REFUSED(read_solid(folder / "mesh"),
                 "found 8 of 16 hexahedra with the corners of another: 9 repeats 1, 10 repeats 2",
                 "and 3 more");
}

// Errors for damaged files state file, position, expected and found values.
TEST(SolidFiles, DamageIsLocated) {
  const Damage table[] = {
      {gmsh_1(), "20 1 0 0", "20 nan 0 0", "node 20: expected finite coordinates"},
      {gmsh_1(), "20 1 0 0", "20 1e300 0 0", "node 20: expected finite coordinates"},
      {gmsh_1(), "20 1 0 0", "20 one 0 0", ":4: expected a coordinate, found \"one\""},
      {gmsh_1(), "20 1 0 0", "10 1 0 0", "expected every node once, found node 10 twice"},
      {gmsh_1(), "20 70 30 40", "20 71 30 40",
       "element 8: expected the number of a node, found 71, which does not exist"},
      {gmsh_1(), "$NOD\n6", "$NOD\n600000000",
       ":2: expected a number of nodes that the rest of the file can hold, found 600000000"},
      {gmsh_1(), "$NOD\n6", "$NOD\n-6", ":2: expected a number of nodes, found -6"},
      {gmsh_1(), "$NOD\n6", "$NOD\n5", ":8: expected $ENDNOD, found \"40\""},
      {gmsh_1(), "8 4 7 1 4", "8 4 7 1 5", ":14: expected 4 nodes, found \"5\""},
      {gmsh_1(), " 70 30 40\n$ENDELM\n", "", "expected the number of a node, found the end of the file"},
      {gmsh_2(), "2.2 0", "3 0", ":2: expected Gmsh version 2.0, 2.1, 2.2 or 4.1"},
      {gmsh_2(), "8 4 3 7", "8 44 3 7",
       "expected one of Gmsh's element types 1 to 31, found 44, of a higher order"},
      {gmsh_2(), "8 4 3 7", "8 92 3 7",
       "found 92, of a higher order or another shape; gmsh -order 1 writes types"},
      {gmsh_2(), "8 4 3 7", "8 444 3 7", "expected one of Gmsh's element types 1 to 31, found 444"},
      {gmsh_2(), "8 4 3 7", "8 0 3 7", "expected one of Gmsh's element types 1 to 31, found 0"},
      {gmsh_4(), "3 2 4 1", "3 2 36 1",
       "expected one of Gmsh's element types 1 to 31, found 36, of a higher order"},
      {gmsh_2(), "$EndElements", "$EndElms", "expected $EndElements, found \"$EndElms\""},
      {gmsh_2_binary(false), "\n$EndElements\n", "", "expected $EndElements, found the end of the file"},
      {gmsh_2_binary(false), std::string("\n$EndNodes\n"), "\n$EndNods\n", "expected $EndNodes"},
      {gmsh_4(), "2 6 10 99", "2 7 10 99", "expected 7 nodes, found 6"},
      {gmsh_4(), "3 3 1 8", "3 4 1 8", "expected 4 elements, found 3"},
      {gmsh_4(), "3 2 4 1", "4 2 4 1", "expected a dimension from 0 to 3, found 4"},
      {vtk(), "UNSTRUCTURED_GRID", "POLYDATA", ":4: expected UNSTRUCTURED_GRID, found \"POLYDATA\""},
      {vtk(), "4 1 3 4 5", "4 1 3 4 6", "cell 2: expected points from 0 to 5, found 6"},
      {vtk(), "4 1 3 4 5", "3 1 3 4", ":12: expected a whole number, found \"CELL_TYPES\""},
      {vtk(), "CELL_TYPES 3\n5\n10\n10", "CELL_TYPES 3\n5\n10\n12",
       "cell 2: expected 8 nodes for a cell of type 12, found 4"},
      {vtk(), "POINTS 6 float", "POINTS 6 floats",
       ":5: expected a type of numbers such as float or int, found \"floats\""},
      {vtu(), "4 5</DataArray>", "4</DataArray>",
       ":12: expected a count of numbers that the rest of the file can hold, found 11"},
      {vtu(), "3 7 11", "3 7 5", ":12: expected 5 numbers, found more"},
      {vtu(), "\"Float32\"", "\"Real\"", ":6: expected a type such as Float64, found \"Real\""},
      {vtu(), "</Points>", "", "expected XML, found an error"},
      {vtu(), "\"6\"", "\"6000000000000\"",
       "expected NumberOfPoints that the file can hold, found 6000000000000"},
      {medit(), "Dimension\n3", "Dimension\n2", ":4: expected 3 dimensions, found \"2\""},
      {medit(), "2 4 5 6 7", "2 4 0 6 7",
       "element 2: expected the number of a node, found 0, which does not exist"},
      {medit(), "Tetrahedra\n2", "Tetrahedra\n900",
       "expected a number of elements that the rest of the file can hold, found 900"},
      {medit(), "Tetrahedra", "Edges", "expected tetrahedra or hexahedra, found none in this Medit file"},
  };
  for (const Damage& damage : table) {
    SCOPED_TRACE(damage.from + " -> " + damage.to);
    EXPECT_REFUSED(read_text(damaged(damage)), std::string("/mesh"), damage.message);
  }
}

// A truncated file is rejected unless only fields after the elements are missing.
TEST(SolidFiles, RejectsTruncatedElements) {
  for (const Sample& sample : samples())
    for (std::size_t size = 0; size < sample.text.size(); size += 13) {
      const Result<ReadSolid> read = read_text(sample.text.substr(0, size));
      if (!read) continue;
      EXPECT_EQ(read->mesh.elements, sample_mesh().elements) << sample.format << " cut at " << size;
      EXPECT_GT(size, sample.text.size() / 2) << sample.format;
    }
}

// Missing files, folders, empty files and surfaces are rejected by name.
TEST(SolidFiles, RejectsNonMeshFiles) {
  const fs::path folder = fresh_folder();
  EXPECT_REFUSED(read_solid(folder / "gone.msh"), "gone.msh: does not exist");
  EXPECT_REFUSED(read_solid(folder / ""), "expected a mesh file, found a folder");
  EXPECT_REFUSED(read_text(""), "expected a mesh file, found an empty file");
  EXPECT_REFUSED(read_text("solid cube\nfacet"), "expected a mesh of tetrahedra or hexahedra", "solid cube");
  write(folder / "a.node", tetgen_node(0));
  EXPECT_REFUSED(read_solid(folder / "a.node"),
                 "a.ele: does not exist: expected the tetrahedra that belong to");
  EXPECT_TRUE(is_solid_file(folder / "a.node"));
  EXPECT_FALSE(is_solid_file(folder / ""));
}

// A liver in Gmsh 1.0 format is one component of tetrahedra with positive volumes.
TEST(SolidFiles, GmshLiverIsOneComponent) {
  const fs::path path = fs::path(TURGOR_SOURCE_DIR) / ".." / "shared" / "data" / "mesh" / "liver.msh";
  if (!fs::exists(path)) GTEST_SKIP() << path.string() << " is absent: real data is not part of the project";
  const Result<ReadSolid> read = read_solid(path);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->format, "Gmsh 1.0");
  EXPECT_EQ(read->mesh.vertices.size(), 181u);
  EXPECT_EQ(element_count(read->mesh), 596u);
  for (std::size_t e = 0; e < 596; e++) EXPECT_GT(volume(read->mesh, e), 0);
  const std::vector<int> components = connected_components(read->mesh);
  EXPECT_EQ(*std::max_element(components.begin(), components.end()), 0);
}

}  // namespace
}  // namespace turgor
