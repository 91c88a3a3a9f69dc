// `turgor mesh` on the phantom and on real data.
#include <algorithm>
#include <cmath>

#include "tests/app/program.hpp"
#include "turgor/core/vec.hpp"
#include "turgor/geometry/mesh_quality.hpp"
#include "turgor/geometry/stuffing.hpp"
#include "turgor/io/mesh/solid_files.hpp"

namespace turgor::test {
namespace {

const fs::path kData = fs::path(TURGOR_SOURCE_DIR) / ".." / "shared" / "data";

#define SKIP_WITHOUT(path) \
  if (!fs::exists(path)) GTEST_SKIP() << (path).string() << " is absent: real data is not part of the project"

/// Reads a written mesh and checks that every angle is within the guarantee.
SolidMesh read_good_mesh(const fs::path& path) {
  Result<ReadSolid> read = read_solid(path);
  EXPECT_TRUE(read) << read.error().message;
  if (!read) return {};
  EXPECT_EQ(read->inverted, 0u);
  const MeshQuality quality = measure_quality(read->mesh);
  EXPECT_GE(quality.min_dihedral, kLeastStuffedDihedral - 0.01);  // files round coordinates
  EXPECT_LE(quality.max_dihedral, kLargestStuffedDihedral + 0.01);
  return std::move(read->mesh);
}

// The phantom's liver and its nodule become two regions of one mesh.
TEST(MeshCommand, PhantomLabelsBecomeRegions) {
  const fs::path folder = fresh_folder();
  ASSERT_EQ(run_program("phantom torso --size 96 96 60 --labels l.nii.gz -o ct.nii.gz", folder).code, 0);
  for (const char* name : {"liver.vtu", "liver.msh"}) {
    const Ended ended =
        run_program(std::string("mesh l.nii.gz --label 5 200 --size 0.012 -o ") + name, folder);
    ASSERT_EQ(ended.code, 0) << ended.printed;
    EXPECT_NE(ended.printed.find("dihedral angles"), std::string::npos) << ended.printed;
    EXPECT_NE(ended.printed.find("region 200"), std::string::npos) << ended.printed;
    const SolidMesh mesh = read_good_mesh(folder / name);
    EXPECT_EQ(std::set<int>(mesh.regions.begin(), mesh.regions.end()), (std::set<int>{5, 200}));
  }
}

// A real liver of 1043 mL keeps its volume within two percent at three resolutions.
TEST(MeshCommand, RealLiverKeepsVolume) {
  SKIP_WITHOUT(kData / "ct" / "abdomen-slab-labels.nii.gz");
  const fs::path folder = fresh_folder(), labels = fs::absolute(kData / "ct" / "abdomen-slab-labels.nii.gz");
  for (const char* size : {"0.02", "0.012", "0.008"}) {
    const Ended ended =
        run_program("mesh '" + labels.string() + "' --label 5 -o liver.vtu --size " + size, folder);
    ASSERT_EQ(ended.code, 0) << ended.printed;
    EXPECT_NEAR(volume(read_good_mesh(folder / "liver.vtu")) * 1e6, 1043.118, 0.02 * 1043.118) << size;
    EXPECT_NE(ended.printed.find("it may be truncated"), std::string::npos) << "the slab ends in the liver";
  }
}

// A real surface that crosses itself becomes a mesh and adds a note.
TEST(MeshCommand, FoldedSurfaceIsNoted) {
  SKIP_WITHOUT(kData / "mesh" / "liver-smooth.obj");
  const fs::path folder = fresh_folder(), surface = fs::absolute(kData / "mesh" / "liver-smooth.obj");
  const Ended ended =
      run_program("mesh '" + surface.string() + "' --scale 0.01 --size 0.005 -o liver.msh", folder);
  ASSERT_EQ(ended.code, 0) << ended.printed;
  EXPECT_NE(ended.printed.find("crosses itself: 7 pairs"), std::string::npos) << ended.printed;
  EXPECT_NEAR(volume(read_good_mesh(folder / "liver.msh")) * 1e6, 39.27, 0.02 * 39.27);
}

/// A binary STL of a regular dodecahedron of this width [m]: 20 vertices, 36 triangles.
std::string dodecahedron_stl(double width) {
  const double golden = 0.5 * (1 + std::sqrt(5.0));
  std::vector<Vec3d> vertices, normals;  // of faces, up to their length
  for (int n = 0; n < 8; n++) vertices.push_back({n & 1 ? 1.0 : -1, n & 2 ? 1.0 : -1, n & 4 ? 1.0 : -1});
  for (int n = 0; n < 4; n++) {
    const double a = n & 1 ? 1 : -1, b = n & 2 ? 1 : -1, s = a / golden, l = b * golden;
    for (const Vec3d x : {Vec3d{0, s, l}, {s, l, 0}, {l, 0, s}}) vertices.push_back(x);
    for (const Vec3d x : {Vec3d{0, l, a}, {l, a, 0}, {a, 0, l}}) normals.push_back(x);
  }
  std::string bytes(80, ' ');
  const auto put = [&bytes](const auto& value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
  };
  put(std::uint32_t(36));
  for (const Vec3d normal : normals) {
    // the five vertices farthest along the normal, by their angle
    const Vec3d u = normalized(cross(normal, {0.3, 0.5, 0.7})), v = cross(normalized(normal), u);
    std::sort(vertices.begin(), vertices.end(),
              [&](Vec3d a, Vec3d b) { return dot(a, normal) > dot(b, normal); });
    std::sort(vertices.begin(), vertices.begin() + 5, [&](Vec3d a, Vec3d b) {
      return std::atan2(dot(a, v), dot(a, u)) < std::atan2(dot(b, v), dot(b, u));
    });
    for (int t = 1; t < 4; t++) {
      for (int axis = 0; axis < 3; axis++) put(0.0f);
      for (const int corner : {0, t, t + 1})
        for (int axis = 0; axis < 3; axis++)
          put(float(vertices[std::size_t(corner)][axis] * width / (2 * golden)));
      put(std::uint16_t(0));
    }
  }
  return bytes;
}

// Bodies of 18.7 m are refused at once with a forecast, and so is a file of the kernel that never ends.
TEST(MeshCommand, EndlessWorkIsRefused) {
  const fs::path folder = fresh_folder();
  std::string box;
  for (const char* corner : {"0 0 0", "0 0 18.7", "0 18.7 0", "0 18.7 18.7", "18.7 0 0", "18.7 0 18.7",
                             "18.7 18.7 0", "18.7 18.7 18.7"})
    box += std::string("v ") + corner + "\n";
  for (const char* face : {"1 2 4 3", "5 7 8 6", "1 5 6 2", "3 4 8 7", "1 3 7 5", "2 6 8 4"})
    box += std::string("f ") + face + "\n";
  write(folder / "box.obj", box);
  write(folder / "ball.stl", dodecahedron_stl(18.7));
  const struct {
    const char* arguments;
    const char* words;
  } cases[] = {
      {"mesh box.obj --size 0.1 -o a.msh", "gives about 7.85e+07 tetrahedra; expected at most 1e+07, as "},
      {"mesh ball.stl -o a.msh",
       "a lattice of 8 mm over 18700 mm x 18700 mm x 18700 mm has 2.57e+10 points; expected at most"},
      {"mesh box.obj --size 1 --most 1000 -o a.msh", "expected at most 1000, as "},
      {"mesh /proc/kmsg -o a.msh", "/proc/kmsg: is a file of the kernel"},
      {"info /proc/kmsg", "/proc/kmsg: is a file of the kernel"}};
  for (const auto& c : cases) {
    const Ended ended = run_shell(std::string("timeout 20 '" TURGOR_PROGRAM "' ") + c.arguments, folder);
    EXPECT_EQ(ended.code, 2) << c.arguments << ": " << ended.printed;
    EXPECT_NE(ended.printed.find(c.words), std::string::npos) << c.arguments << ": " << ended.printed;
  }
  EXPECT_EQ(names_in(folder), (std::set<std::string>{"ball.stl", "box.obj"}));
}

// Inputs that cannot be meshed end with a message and leave no files.
TEST(MeshCommand, ErrorsLeaveNoFiles) {
  const fs::path folder = fresh_folder();
  ASSERT_EQ(run_program("phantom torso --size 48 48 40 --labels l.nii.gz -o ct.nii.gz", folder).code, 0);
  write(folder / "open.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\n");
  const struct {
    const char* command;
    const char* words;
  } cases[] = {{"mesh l.nii.gz -o a.vtu", "no label was chosen from the segmentation; it has 1 ("},
               {"mesh l.nii.gz --label 250 -o a.vtu", "label 250 is not in the segmentation; it has 1 ("},
               {"mesh l.nii.gz --label 5 --size 0.2 -o a.vtu", "too small for a lattice of 200 mm"},
               {"mesh l.nii.gz --label 5 --size 0.00001 -o a.vtu", "Are the coordinates in meters?"},
               {"mesh l.nii.gz --label 5 -o a.stl", "a.stl: expected a name that ends in .vtu or .msh"},
               {"mesh l.nii.gz --label 5 --scale 0.001 -o a.vtu", "--scale applies to surfaces"},
               {"mesh open.obj -o a.vtu", "open.obj: the surface is open: 3 edges are of one triangle only"},
               {"mesh open.obj --label 5 -o a.vtu", "--label applies to segmentations"},
               {"mesh nothing.nii.gz --label 5 -o a.vtu", "nothing.nii.gz"},
               {"mesh l.nii.gz --label 5 --size -1 -o a.vtu", "--size"}};
  for (const auto& c : cases) {
    const Ended ended = run_program(c.command, folder);
    EXPECT_EQ(ended.code, 2) << c.command << ": " << ended.printed;
    EXPECT_NE(ended.printed.find(c.words), std::string::npos) << c.command << ": " << ended.printed;
  }
  EXPECT_EQ(names_in(folder), (std::set<std::string>{"ct.nii.gz", "l.nii.gz", "open.obj"}));
}

}  // namespace
}  // namespace turgor::test
