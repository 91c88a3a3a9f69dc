// Agreement of all outputs about one wound: report, picture, mesh file and deformed CT state the same gape.
#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include "tests/sim/block_scene.hpp"
#include "turgor/io/mesh/mesh_files.hpp"
#include "turgor/io/mesh/surface_files.hpp"
#include "turgor/models/lattice/resample/resample.hpp"
#include "turgor/pictures/picture_items.hpp"
#include "turgor/sim/run.hpp"
#include "turgor/view/mesh_view.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;

constexpr double kAgree = 0.3e-3;  // [m]

/// Frame at the middle of the cut, patient frame.
struct Station {
  Vec3d point, line, across, into;
};
Station middle_of(const LatticeBody& body, const lattice::BladePath& path) {
  const Grid& grid = body.model.anatomy.grid;
  const std::size_t n = path.points.size() / 2;
  return {grid.origin + grid.axes * path.points[n], grid.axes * tangent_at(path, n),
          grid.axes * across_at(path, n), grid.axes * path.inward[n]};
}

/// Lateral positions of the two lips, and their depths below the station's point [m].
struct Lips {
  double left = 0, right = 0, left_depth = 0, right_depth = 0;

  double gape() const { return right - left; }
};

/// Lips of a surface in a file: the edges between skin and wound walls.
Lips lips_of_mesh(const fs::path& file, std::size_t wall_begin, const Station& at) {
  const TriMesh mesh = read_surface(file).value().mesh;
  std::map<std::pair<int, int>, int> sides;
  for (std::size_t t = 0; t < mesh.triangles.size(); t++)
    for (int n = 0; n < 3; n++) {
      const int a = mesh.triangles[t][n], b = mesh.triangles[t][(n + 1) % 3];
      sides[std::minmax(a, b)] |= t < wall_begin ? 1 : 2;
    }
  Lips lips{.left = 1, .right = -1};
  for (const auto& [edge, side] : sides) {
    if (side != 3) continue;
    const Vec3d a = Vec3d(mesh.vertices[std::size_t(edge.first)]) - at.point,
                b = Vec3d(mesh.vertices[std::size_t(edge.second)]) - at.point;
    const double sa = dot(a, at.line), sb = dot(b, at.line);
    if ((sa >= 0) == (sb >= 0) || norm(a) > 0.04) continue;
    const Vec3d x = a + (b - a) * (sa / (sa - sb));
    const double across = dot(x, at.across), depth = dot(x, at.into);
    if (across < lips.left) lips.left = across, lips.left_depth = depth;
    if (across > lips.right) lips.right = across, lips.right_depth = depth;
  }
  return lips;
}

/// Lips of the deformed CT: the walls half a millimeter and one below the lips, extrapolated linearly to the
/// lips.
Lips lips_of_ct(const LatticeBody& body, const Station& at, const Lips& near) {
  constexpr double kSample = 0.1e-3, kSide = 0.06;
  Grid grid;
  grid.size = {int(kSide / kSample), 41, 1};
  grid.spacing = {kSample, kSample, kSample};
  grid.axes = {{at.across, at.into, cross(at.across, at.into)}};
  const double top = std::max(near.left_depth, near.right_depth);
  grid.origin = at.point - at.across * (kSide / 2) + at.into * top;
  const CtVolume now = lattice::resample_ct(Exec(2), body.model, body.state, body.ct, grid).ct;
  const auto is_tissue = [&](int i, int row) { return now.at(i, row, 0) >= -449; };
  // End of the tissue, searched from below the lip in both directions: the floor may rise in the middle of
  // the wound.
  const auto wall = [&](int row, int direction) {
    int i = int((kSide / 2 + (direction < 0 ? near.left : near.right)) / kSample);
    while (i > 0 && i + 1 < grid.size.x && is_tissue(i, row)) i -= direction;
    while (i > 0 && i + 1 < grid.size.x && !is_tissue(i, row)) i += direction;
    return (i - direction * 0.5) * kSample - kSide / 2;
  };
  const auto at_lip = [&](int direction, double depth) {
    const double half = wall(5, direction), one = wall(10, direction), below = top + 5 * kSample;
    return half + (one - half) * (depth - below) / (5 * kSample);
  };
  return {.left = at_lip(-1, near.left_depth), .right = at_lip(1, near.right_depth)};
}

/// Gape in a picture from straight above: the width of the walls, found by painting them in two colors. Empty
/// without OpenGL.
std::optional<double> gape_of_picture(const BodySnapshot& body, const Station& at, const Lips& near) {
  constexpr int kPixels = 800;
  constexpr double kSide = 0.06, kAway = 3;
  const TriMesh whole = shown_mesh(body);
  TriMesh skin = whole, walls = whole;
  skin.scalars.clear(), walls.scalars.clear();
  skin.triangles.resize(body.wall_begin);
  walls.triangles.erase(walls.triangles.begin(), walls.triangles.begin() + std::ptrdiff_t(body.wall_begin));
  const Vec3d look = at.point + at.across * ((near.left + near.right) / 2) +
                     at.into * ((near.left_depth + near.right_depth) / 2);
  const Camera camera{.eye = look - at.into * kAway,
                      .target = look,
                      .up = at.line,
                      .field_of_view = 2 * std::atan(kSide / 2 / kAway) * 180 / 3.14159265358979};
  const auto draw = [&](Rgb color) {
    return draw_meshes({{.mesh = &skin}, {.mesh = &walls, .color = color}}, camera, kPixels, kPixels);
  };
  const Result<Image> dark = draw({0, 0, 0}), light = draw({255, 255, 255});
  if (!dark || !light) return {};
  int changed = 0;
  for (int x = 0; x < kPixels; x++) {
    const Rgb a = dark->at(x, kPixels / 2), b = light->at(x, kPixels / 2);
    changed += std::abs(int(a.r) - int(b.r)) + std::abs(int(a.g) - int(b.g)) > 60;
  }
  return changed * kSide / kPixels;
}

double gape_of_report(const lattice::Wound& wound, double along) {
  const auto& profile = wound.profile;
  for (std::size_t n = 1; n < profile.size(); n++)
    if (along <= profile[n].along) {
      const auto &a = profile[n - 1], &b = profile[n];
      return a.gape + (b.gape - a.gape) * (along - a.along) / (b.along - a.along);
    }
  return 0;
}

void expect_one_wound(const Scene& scene, const fs::path& folder) {
  const Exec exec(2);
  Result<World> world = load_world(exec, scene);
  ASSERT_TRUE(world) << world.error().message;
  const Result<Simulated> done = simulate(exec, scene, *world);
  ASSERT_TRUE(done) << done.error().message;
  const LatticeBody& body = world->lattice_bodies[0];
  const lattice::BladePath& path = *world->cuts[0].path;
  const Station at = middle_of(body, path);
  WorldSnapshot seen;
  show(exec, *world, seen);
  const BodySnapshot& snapshot = seen.bodies[0];
  const std::size_t n = path.points.size() / 2;
  double along = 0;
  for (std::size_t m = 0; m < n; m++) along += norm(path.points[m + 1] - path.points[m]);
  const double report = gape_of_report(done->measures.cuts[0].wound, along);
  ASSERT_TRUE(write_obj(folder / "body.obj", shown_mesh(snapshot)));
  const Lips mesh = lips_of_mesh(folder / "body.obj", snapshot.wall_begin, at),
             ct = lips_of_ct(body, at, mesh);
  const std::optional<double> picture = gape_of_picture(snapshot, at, mesh);
  std::printf("  report %.2f mm, mesh %.2f, deformed CT %.2f, picture %.2f\n", report * 1e3,
              mesh.gape() * 1e3, ct.gape() * 1e3, picture.value_or(0) * 1e3);
  EXPECT_GT(report, 0.004) << "m: an open wound";
  EXPECT_NEAR(mesh.gape(), report, kAgree);
  EXPECT_NEAR(ct.gape(), report, kAgree);
  if (picture) {
    EXPECT_NEAR(*picture, report, kAgree);
  }
}

/// Distance of a position in the CT from the curve of the blade, seen along the blade [m].
double distance_to_curve(const lattice::BladePath& path, Vec3d x) {
  std::size_t nearest = 0;
  const auto aside = [&](std::size_t n) { return norm(cross(x - path.points[n], path.inward[n])); };
  for (std::size_t n = 0; n < path.points.size(); n++)
    if (aside(n) < aside(nearest)) nearest = n;
  return std::abs(dot(x - path.points[nearest], across_at(path, nearest)));
}

const char* kCurveS = "[[0.5, 0, 0.6], [0.55, 0, 0.53], [0.45, 0, 0.43], [0.5, 0, 0.36]]";

void expect_lips_on_curve(const std::string& ct, const std::string& steps = "spacing = 0.009",
                          const std::string& curve = kCurveS) {
  const Result<Scene> scene = parse_scene(
      "[world]\nduration = 0.1\n[body.torso]\nmodel = \"lattice\"\nct = " + ct + "\n" + steps +
          "\nfixed = [\"bone\", \"ends\"]\n[incision.s]\nbody = \"torso\"\npath_fraction = " + curve + "\n",
      "lips.toml");
  ASSERT_TRUE(scene) << scene.error().message;
  const Exec exec(2);
  Result<World> world = load_world(exec, *scene);
  ASSERT_TRUE(world) << world.error().message;
  ASSERT_TRUE(step(exec, *world));
  const LatticeBody& body = world->lattice_bodies[0];
  const lattice::BladePath& path = *world->cuts[0].path;
  const lattice::BodySurface surface = lattice::build_surface(body.model, body.state.cuts(), &body.ct);
  const Vec3d voxel = body.ct.grid.spacing;
  double farthest = 0, sum = 0;
  for (const lattice::Lip& lip : surface.lips) {
    const double away = distance_to_curve(path, Vec3d(surface.rest[std::size_t(lip.left)]));
    farthest = std::max(farthest, away), sum += away;
  }
  ASSERT_GT(surface.lips.size(), 50u);
  const double least = std::min({voxel.x, voxel.y, voxel.z});
  std::printf("  %zu lip points: distance to the curve at most %.3f voxels, %.3f on average\n",
              surface.lips.size(), farthest / least, sum / double(surface.lips.size()) / least);
  EXPECT_LT(farthest, 0.2 * least);
}

// The lips of a wound in the phantom lie on the curve of the blade within 0.2 voxels.
TEST(OneWound, PhantomLipsFollowBladeCurve) {
  expect_lips_on_curve("{ phantom = \"torso\", size = [128, 96, 75], spacing_mm = [3.1, 3.1, 4] }");
}

// The lips follow a curve that passes through nodes of the lattice and along its edges.
TEST(OneWound, LipsFollowCurveThroughNodes) {
  // The middle and the upper end of this S are nodes, to a thousandth of a spacing.
  expect_lips_on_curve("{ phantom = \"torso\", size = [80, 64, 50], spacing_mm = [5.2, 5.2, 6] }",
                       "block = 1",
                       "[[0.5, 0, 0.6], [0.54, 0, 0.55], [0.5, 0, 0.5], [0.46, 0, 0.45], [0.5, 0, 0.4]]");
}

// The lips of a wound in a real CT lie on the curve of the blade within 0.2 voxels.
TEST(OneWound, PatientLipsFollowBladeCurve) {
  const fs::path file = fs::path(TURGOR_SOURCE_DIR) / "../shared/data/ct/torso-3mm.nii.gz";
  if (!fs::exists(file)) GTEST_SKIP() << file << " is absent";
  expect_lips_on_curve("\"" + file.string() + "\"");
}

// Report, picture, mesh and deformed CT agree on the gape of a wound in the phantom.
TEST(OneWound, OutputsAgreeOnPhantom) {
  const std::string text =
      "[world]\nduration = 0.6\n[body.torso]\nmodel = \"lattice\"\n"
      "ct = { phantom = \"torso\", size = [128, 96, 75], spacing_mm = [3.1, 3.1, 4] }\nspacing = 0.008\n"
      "fixed = [\"bone\", \"ends\"]\n"
      "[incision.midline]\nbody = \"torso\"\nfrom_fraction = [0.5, 0, 0.62]\nto_fraction = [0.5, 0, 0.22]\n";
  for (const char* law :
       {"body.torso.tissue={ law = \"solid\" }", "body.torso.tissue={ law = \"springs\", volume = 2 }"}) {
    const Result<Scene> scene = parse_scene(text, "phantom.toml", {law});
    ASSERT_TRUE(scene) << scene.error().message;
    expect_one_wound(*scene, test::fresh_folder());
  }
}

// Report, picture, mesh and deformed CT agree for an oblique cut in a rotated body.
TEST(OneWound, OutputsAgreeOnRotatedBody) {
  const fs::path folder = test::fresh_folder();
  CtVolume ct = test::block_ct();
  const double c = std::cos(0.5), s = std::sin(0.5);
  const Mat3d turn{{{c, s, 0}, {-s, c, 0}, {0, 0, 1}}};
  ct.grid.origin = turn * ct.grid.origin, ct.grid.axes = turn;
  ASSERT_TRUE(write_ct(folder / "turned.nii", ct));
  const Vec3d from = turn * Vec3d{-0.033, -0.02, -0.011}, to = turn * Vec3d{0.035, -0.02, 0.017};
  const Result<Scene> scene = parse_scene(
      fmt::format(
          "[world]\nduration = 1\n[body.block]\nmodel = \"lattice\"\nct = \"turned.nii\"\nblock = 1\n"
          "fixed = \"bone\"\n[incision.cut]\nbody = \"block\"\nfrom = [{}, {}, {}]\nto = [{}, {}, {}]\n"
          "depth = 0.015\n",
          from.x, from.y, from.z, to.x, to.y, to.z),
      folder / "turned.toml");
  ASSERT_TRUE(scene) << scene.error().message;
  expect_one_wound(*scene, folder);
}

}  // namespace
}  // namespace turgor
