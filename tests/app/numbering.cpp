// Vertices in the files of a run are numbered as in the user's mesh.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "tests/app/program.hpp"
#include "turgor/io/files/hdf5_file.hpp"
#include "turgor/io/mesh/mesh_files.hpp"
#include "turgor/io/mesh/surface_files.hpp"

namespace turgor {
namespace {

using namespace test;

/// A bent sheet of 9 × 7 vertices in a shuffled order.
TriMesh shuffled_sheet() {
  TriMesh mesh;
  constexpr int kColumns = 9, kRows = 7, kCount = kColumns * kRows;
  const auto number = [](int v) { return v * 37 % kCount; };
  mesh.vertices.resize(kCount);
  for (int v = 0; v < kCount; v++) {
    const float x = 0.03f * float(v % kColumns), y = 0.03f * float(v / kColumns);
    mesh.vertices[std::size_t(number(v))] = {x, y, 1 + 0.5f * x * x - 0.3f * y * y};
  }
  for (int r = 0; r + 1 < kRows; r++)
    for (int c = 0; c + 1 < kColumns; c++) {
      const int v = r * kColumns + c;
      mesh.triangles.push_back({number(v), number(v + 1), number(v + kColumns)});
      mesh.triangles.push_back({number(v + 1), number(v + 1 + kColumns), number(v + kColumns)});
    }
  return mesh;
}

/// A closed ball with shuffled vertices [m].
TriMesh shuffled_ball(float radius) {
  constexpr int kRound = 16, kDown = 11, kCount = kRound * (kDown - 1) + 2;
  const auto number = [](int v) { return v * 71 % kCount; };
  TriMesh ball;
  ball.vertices.resize(kCount);
  const auto at = [&](int ring, int side) {
    return ring == 0 ? 0 : ring == kDown ? kCount - 1 : 1 + (ring - 1) * kRound + side % kRound;
  };
  const float pi = std::acos(-1.0f);
  for (int ring = 0; ring <= kDown; ring++)
    for (int side = 0; side < kRound; side++) {
      const float down = pi * float(ring) / kDown, round = 2 * pi * float(side) / kRound;
      ball.vertices[std::size_t(number(at(ring, side)))] =
          Vec3{std::sin(down) * std::cos(round), std::sin(down) * std::sin(round), std::cos(down)} * radius;
    }
  for (int ring = 0; ring < kDown; ring++)
    for (int side = 0; side < kRound; side++) {
      const int a = number(at(ring, side)), b = number(at(ring + 1, side)),
                c = number(at(ring + 1, side + 1)), d = number(at(ring, side + 1));
      if (ring + 1 < kDown) ball.triangles.push_back({a, b, c});
      if (ring > 0) ball.triangles.push_back({a, c, d});
    }
  return ball;
}

void expect_same_positions(const TriMesh& given, const TriMesh& written, float within) {
  ASSERT_EQ(given.vertices.size(), written.vertices.size());
  for (std::size_t v = 0; v < given.vertices.size(); v++)
    ASSERT_LT(norm(given.vertices[v] - written.vertices[v]), within) << v;
  EXPECT_EQ(given.triangles, written.triangles);
}

/// Array of a VTU file: the data behind the first "offset=" after `where`.
std::vector<float> vtu_floats(const fs::path& file, const std::string& where) {
  const std::string bytes = bytes_of(file);
  const std::size_t offset = std::stoul(bytes.substr(bytes.find("offset=\"", bytes.find(where)) + 8));
  std::size_t begin = bytes.find('_', bytes.find("<AppendedData")) + 1 + offset;
  std::uint64_t size = 0;
  std::memcpy(&size, bytes.data() + begin, sizeof size);
  begin += sizeof size;
  std::vector<float> values(size / sizeof(float));
  if (begin + size <= bytes.size()) std::memcpy(values.data(), bytes.data() + begin, size);
  return values;
}

TriMesh vtu_points(const fs::path& file) {
  const std::vector<float> values = vtu_floats(file, "<Points>");
  TriMesh mesh;
  for (std::size_t i = 0; i + 2 < values.size(); i += 3)
    mesh.vertices.push_back({values[i], values[i + 1], values[i + 2]});
  return mesh;
}

const char* kStill =
    "[world]\nduration = 0.02\nframe_rate = 50\n[output]\nvideo = false\n"
    "snapshots = { every = 0.02, size = [64, 64] }\n";

// Vertex i of a cloth is vertex i of its mesh in every output file. Springs rest in the mesh; a sheet
// unrolls.
TEST(Numbering, ClothKeepsVertexOrder) {
  const fs::path folder = fresh_folder();
  const TriMesh given = shuffled_sheet();
  ASSERT_TRUE(write_obj(folder / "mine.obj", given));
  write(folder / "s.toml", std::string(kStill) +
                               "[body.sheet]\nmodel = \"cloth\"\nmesh = \"mine.obj\"\n"
                               "fabric = { law = \"springs\" }\n");
  const Ended ended = run_program("run s.toml --out out", folder);
  ASSERT_EQ(ended.code, 0) << ended.printed;
  expect_same_positions(given, read_surface(folder / "out" / "sheet.obj")->mesh, 3e-6f);
  const Result<Hdf5File> file = Hdf5File::open(folder / "out" / "recording.h5");
  const auto positions =
      file->read<float>("/snapshots/00000/bodies/sheet/positions", 3 * given.vertices.size());
  ASSERT_TRUE(positions);
  const TriMesh points = vtu_points(folder / "out" / "meshes" / "sheet-0000.vtu");
  ASSERT_EQ(points.vertices.size(), given.vertices.size());
  for (std::size_t v = 0; v < given.vertices.size(); v++) {
    const Vec3 recorded{(*positions)[3 * v], (*positions)[3 * v + 1], (*positions)[3 * v + 2]};
    ASSERT_LT(norm(recorded - given.vertices[v]), 2e-6f) << v;
    ASSERT_LT(norm(points.vertices[v] - given.vertices[v]), 2e-6f) << v;
  }
}

// Welded seams keep the vertices and triangles of the mesh in the output.
TEST(Numbering, WeldedSeamsKeepVertices) {
  const fs::path folder = fresh_folder();
  TriMesh two = shuffled_sheet();  // and its mirror image, welded along x = 0
  const int count = int(two.vertices.size());
  const std::size_t triangles = two.triangles.size();
  for (int v = 0; v < count; v++) {
    const Vec3 x = two.vertices[std::size_t(v)];
    two.vertices.push_back({-x.x - 1e-3f, x.y, x.z});
  }
  for (std::size_t t = 0; t < triangles; t++) {
    const Int3 tri = two.triangles[t];
    two.triangles.push_back({tri.x + count, tri.z + count, tri.y + count});
  }
  ASSERT_TRUE(write_obj(folder / "two.obj", two));
  write(folder / "s.toml",
        std::string(kStill) + "[body.sheet]\nmodel = \"cloth\"\nmesh = \"two.obj\"\nweld = 2e-3\n");
  const Ended ended = run_program("run s.toml --out out", folder);
  ASSERT_EQ(ended.code, 0) << ended.printed;
  EXPECT_NE(ended.printed.find("7 vertices closer than"), std::string::npos) << ended.printed;
  std::ifstream obj(folder / "out" / "sheet.obj");  // the surface reader would join coincident vertices
  std::size_t v = 0, faces = 0;
  for (std::string line; std::getline(obj, line);) {
    faces += line.starts_with("f ");
    if (!line.starts_with("v ")) continue;
    Vec3 x;
    ASSERT_EQ(std::sscanf(line.c_str(), "v %f %f %f", &x.x, &x.y, &x.z), 3);
    ASSERT_LT(v, two.vertices.size());
    ASSERT_LT(norm(x - two.vertices[v++]), 1.1e-3f) << v;
  }
  EXPECT_EQ(v, two.vertices.size());
  EXPECT_EQ(faces, two.triangles.size());
}

// Vertex i of a rhombus body is vertex i of its surface in every output file.
TEST(Numbering, RhombusKeepsVertexOrder) {
  const fs::path folder = fresh_folder();
  const TriMesh given = shuffled_ball(0.05f);
  ASSERT_TRUE(write_obj(folder / "ball.obj", given));
  write(folder / "s.toml", std::string(kStill) +
                               "[body.ball]\nmodel = \"rhombus\"\nsurface = \"ball.obj\"\n[tool.tip]\n"
                               "body = \"ball\"\nshape = { sphere = 0.004 }\npress = { at_fraction = [0.5, "
                               "0.5, 1], depth = 0.001, start = 0, duration = 0.01 }\n");
  const Ended ended = run_program("run s.toml --out out", folder);
  ASSERT_EQ(ended.code, 0) << ended.printed;
  expect_same_positions(given, read_surface(folder / "out" / "ball.obj")->mesh, 1.1e-3f);
  const TriMesh points = vtu_points(folder / "out" / "meshes" / "ball-0000.vtu");
  ASSERT_EQ(points.vertices.size(), given.vertices.size());
  for (std::size_t v = 0; v < given.vertices.size(); v++)
    ASSERT_LT(norm(points.vertices[v] - given.vertices[v]), 2e-6f) << v;
}

/// A block of hexahedra whose vertices are in a shuffled order.
std::string shuffled_block(int n, float size, std::vector<Vec3>& vertices) {
  const int side = n + 1, count = side * side * side;
  const auto number = [count](int v) { return v * 101 % count; };
  const auto at = [&](int i, int j, int k) { return number((k * side + j) * side + i); };
  vertices.resize(std::size_t(count));
  std::string elements;
  int hexahedra = 0;
  for (int k = 0; k <= n; k++)
    for (int j = 0; j <= n; j++)
      for (int i = 0; i <= n; i++) {
        vertices[std::size_t(at(i, j, k))] = Vec3{float(i), float(j), float(k)} * (size / float(n));
        if (i == n || j == n || k == n) continue;
        hexahedra++;
        for (const auto& [a, b, c] :
             {std::tuple(0, 0, 0), std::tuple(1, 0, 0), std::tuple(1, 1, 0), std::tuple(0, 1, 0),
              std::tuple(0, 0, 1), std::tuple(1, 0, 1), std::tuple(1, 1, 1), std::tuple(0, 1, 1)})
          elements += std::to_string(at(i + a, j + b, k + c) + 1) + " ";
        elements += "0\n";
      }
  std::string text = "MeshVersionFormatted 2\nDimension 3\nVertices\n" + std::to_string(count) + "\n";
  for (const Vec3 x : vertices)
    text += std::to_string(x.x) + " " + std::to_string(x.y) + " " + std::to_string(x.z) + " 0\n";
  return text + "Hexahedra\n" + std::to_string(hexahedra) + "\n" + elements + "End\n";
}

// Surface vertices of an SFEM body store their vertex of the mesh, equal in all snapshots; patch vertices
// store -1.
TEST(Numbering, SfemVerticesMapToMesh) {
  const fs::path folder = fresh_folder();
  std::vector<Vec3> given;
  write(folder / "block.mesh", shuffled_block(4, 0.05f, given));
  write(
      folder / "s.toml",
      "[world]\nduration = 0.3\n[body.pad]\nmodel = \"sfem\"\nmesh = \"block.mesh\"\nfixed = \"bottom\"\n"
      "cache = false\n[tool.tip]\nbody = \"pad\"\nshape = { sphere = 0.006 }\npress = { at_fraction = [0.3, "
      "0.5, 1], to_fraction = [0.7, 0.4, 1], depth = 0.002, start = 0, duration = 0.05, slide = 0.1 }\n"
      "[output]\nvideo = false\nsnapshots = { every = 0.1, size = [64, 64] }\n");
  const Ended ended = run_program("run s.toml --out out", folder);
  ASSERT_EQ(ended.code, 0) << ended.printed;
  const Result<Hdf5File> file = Hdf5File::open(folder / "out" / "recording.h5");
  ASSERT_TRUE(file);
  constexpr std::size_t kOutside = 98;  // of 125 vertices
  std::vector<std::int32_t> first;
  for (const char* snapshot : {"00000", "00001", "00002", "00003"}) {
    const std::string group = std::string("/snapshots/") + snapshot + "/surfaces/pad/";
    const std::size_t count = *file->count(group + "mesh_vertex", 100000);
    const auto numbers = *file->read<std::int32_t>(group + "mesh_vertex", count);
    const auto rest = *file->read<float>(group + "rest", 3 * count);
    ASSERT_GT(count, kOutside) << "the body has a patch";
    for (std::size_t v = 0; v < kOutside; v++) {
      const Vec3 x{rest[3 * v], rest[3 * v + 1], rest[3 * v + 2]};
      ASSERT_LT(norm(x - given[std::size_t(numbers[v])]), 1e-6f) << v;
    }
    for (std::size_t v = kOutside; v < count; v++) ASSERT_EQ(numbers[v], -1);
    const std::vector<std::int32_t> own(numbers.begin(), numbers.begin() + kOutside);
    EXPECT_TRUE(std::is_sorted(own.begin(), own.end()));
    if (first.empty()) first = own;
    EXPECT_EQ(own, first) << snapshot;
  }
  const std::vector<float> in_mesh_file =
      vtu_floats(folder / "out" / "meshes" / "pad-0018.vtu", "Name=\"mesh vertex\"");
  ASSERT_GE(in_mesh_file.size(), kOutside);
  for (std::size_t v = 0; v < kOutside; v++) EXPECT_EQ(in_mesh_file[v], float(first[v])) << v;
}

}  // namespace
}  // namespace turgor
