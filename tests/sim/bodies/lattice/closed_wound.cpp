// Geometry of closed wounds, measured on the drawn surface: walls that do not overlap, and sutures in an
// order.
#include <algorithm>
#include <optional>

#include "tests/sim/block_scene.hpp"
#include "turgor/sim/report/report.hpp"
#include "turgor/sim/run.hpp"

namespace turgor {
namespace {

/// The block of block_scene.hpp, whose cut at x = 2 mm has sutures.
Scene closed_scene(const std::filesystem::path& folder, const std::string& sutures, double duration,
                   bool has_partial) {
  EXPECT_TRUE(write_ct(folder / "block.nii", test::block_ct()));
  Result<Scene> scene =
      parse_scene(test::block_scene_text("block.nii") + sutures, folder / "block.toml",
                  {"world.duration=" + std::to_string(duration),
                   std::string("body.block.tissue.partial_cells=") + (has_partial ? "true" : "false")});
  EXPECT_TRUE(scene) << scene.error().message;
  return *scene;
}

/// A single stitch across the cut at a height, with more keys.
std::string single_stitch(const char* name, const char* z, const char* start, const std::string& keys = "") {
  return std::string("[suture.") + name + "]\nwound = \"cut\"\nthrough = [[-0.010, -0.019, " + z +
         "], [-0.010, -0.015, " + z + "], [0.014, -0.015, " + z + "], [0.014, -0.019, " + z +
         "]]\nduration = 0.2\nstart = " + start + "\n" + keys;
}

/// x of a triangle where the line along x through a point meets it [m].
std::optional<double> meet_along_x(const std::array<Vec3d, 3>& t, Vec3d p) {
  const auto area = [](Vec3d a, Vec3d b, Vec3d c) {
    return (b.y - a.y) * (c.z - a.z) - (b.z - a.z) * (c.y - a.y);
  };
  const double whole = area(t[0], t[1], t[2]);
  if (!(std::abs(whole) > 1e-12)) return std::nullopt;
  const double a = area(p, t[1], t[2]) / whole, b = area(t[0], p, t[2]) / whole, c = 1 - a - b;
  if (a < 0 || b < 0 || c < 0) return std::nullopt;
  return a * t[0].x + b * t[1].x + c * t[2].x;
}

/// Distances between the drawn walls of the cut, along its normal x; negative where they overlap.
struct WallDistances {
  int count = 0;
  double least = 1, most = -1;  // [m]

  explicit WallDistances(const BodySnapshot& body) {
    const std::span<const Int3> walls = std::span(body.triangles).subspan(body.wall_begin);
    const auto corners = [](const std::vector<Vec3>& x, Int3 t) {
      return std::array{Vec3d(x[std::size_t(t.x)]), Vec3d(x[std::size_t(t.y)]), Vec3d(x[std::size_t(t.z)])};
    };
    const auto facing = [&](Int3 t) {
      const auto r = corners(body.rest, t);
      return normalized(cross(r[1] - r[0], r[2] - r[0])).x;
    };
    for (const Int3 left : walls) {
      if (!(facing(left) > 0.9)) continue;
      const auto t = corners(body.x, left);
      const Vec3d middle = (t[0] + t[1] + t[2]) / 3;
      for (const Int3 right : walls)
        if (facing(right) < -0.9)
          if (const auto x = meet_along_x(corners(body.x, right), middle))
            count++, least = std::min(least, *x - middle.x), most = std::max(most, *x - middle.x);
    }
  }
};

// The drawn walls of a closed wound meet. They press on each other at points one cell of 8 mm apart, and
// overlap by less than a tenth of a cell between them.
TEST(ClosedWound, WallsOverlapByLessThanTenthOfCell) {
  constexpr double kCell = 0.008;  // [m]
  for (const bool has_partial : {false, true}) {
    const Scene scene = closed_scene(test::fresh_folder(),
                                     "[suture.row]\nwound = \"cut\"\nbite = 0.012\ndepth = 0.004\nspacing = "
                                     "0.015\nstart = 0.3\nduration = "
                                     "0.3\n",
                                     1.6, has_partial);
    World world = test::block_world(Exec(1), scene);
    const auto distances_now = [&] {
      WorldSnapshot snapshot;
      show(Exec(1), world, snapshot);
      return WallDistances(snapshot.bodies[0]);
    };
    while (time_of(world) < 0.28) ASSERT_TRUE(step(Exec(1), world));
    const WallDistances open = distances_now();
    while (time_of(world) < scene.duration - 1e-6) ASSERT_TRUE(step(Exec(1), world));
    const WallDistances closed = distances_now();
    std::printf("partial cells %d: open %.2f to %.2f mm at %d points, closed %.3f to %.3f mm at %d points\n",
                has_partial, 1e3 * open.least, 1e3 * open.most, open.count, 1e3 * closed.least,
                1e3 * closed.most, closed.count);
    EXPECT_GT(open.most, 3e-3) << "m";
    EXPECT_GT(closed.count, 100);
    EXPECT_GT(closed.least, -0.1 * kCell) << "m";
    EXPECT_LT(closed.most, 0.1 * kCell) << "m";
  }
}

// Sutures with different starts close a wound in their order: the first stitch is knotted before the second
// is pulled, and both bear at the end.
TEST(ClosedWound, SuturesAreTiedInTheirOrder) {
  const Scene scene = closed_scene(
      test::fresh_folder(), single_stitch("upper", "0.012", "0.3") + single_stitch("lower", "-0.012", "0.9"),
      1.6, true);
  World world = test::block_world(Exec(1), scene);
  const auto phase = [&](std::size_t suture) { return world.sutures[suture].closure->stitches[0].phase; };
  while (time_of(world) < 0.88) ASSERT_TRUE(step(Exec(1), world));
  ASSERT_TRUE(world.sutures[0].closure);
  EXPECT_EQ(phase(0), lattice::StitchPhase::kKnotted);
  EXPECT_TRUE(!world.sutures[1].closure || phase(1) == lattice::StitchPhase::kWaiting);
  const double alone = world.sutures[0].closure->stitches[0].tension;
  while (time_of(world) < scene.duration - 1e-6) ASSERT_TRUE(step(Exec(1), world));
  EXPECT_EQ(phase(0), lattice::StitchPhase::kKnotted);
  EXPECT_EQ(phase(1), lattice::StitchPhase::kKnotted);
  // the second stitch takes a part of the load over
  const double both = world.sutures[0].closure->stitches[0].tension,
               second = world.sutures[1].closure->stitches[0].tension;
  std::printf("first stitch %.3f N alone, %.3f N beside the second with %.3f N\n", alone, both, second);
  EXPECT_LT(both, alone) << "N";
  EXPECT_GT(second, 0.2 * both) << "N";
}

// On skin that curves, too, the rim of a stitch ends at the lip whose gape it closes. A rim that ended beside
// it let the thread reach its shortest length while the lips were still open.
TEST(ClosedWound, RimsEndAtLips) {
  const Scene scene = parse_scene(
                          "[world]\nduration = 0.2\nframe_rate = 50\n[body.torso]\nmodel = \"lattice\"\n"
                          "ct = { phantom = \"torso\", size = [64, 48, 40], spacing_mm = [6.5, 6.5, 6.5] }\n"
                          "fixed = [\"bone\", \"ends\"]\n[excision.mole]\nbody = \"torso\"\n"
                          "center_fraction = [0.35, 0, 0.45]\nlength = 0.08\nwidth = 0.04\ndepth = 0.016\n"
                          "start = 0.02\n[suture.row]\nwound = \"mole\"\nbite = 0.008\nstart = 0.06\n",
                          "torso.toml")
                          .value();
  World world = test::block_world(Exec(1), scene);
  for (int frame = 0; frame < 6; frame++) ASSERT_TRUE(step(Exec(1), world));
  ASSERT_TRUE(world.sutures[0].closure);
  const lattice::WoundClosure& closure = *world.sutures[0].closure;
  const lattice::Motion& motion = world.lattice_bodies[0].state->motion;
  int rims = 0;
  for (const lattice::WallPair& pair : closure.walls) {
    if (pair.stitch < 0 || !pair.at.parted) continue;
    const lattice::Stitch& stitch = closure.stitches[std::size_t(pair.stitch)];
    const bool is_left = stitch.side[std::size_t(pair.point)] < 0;
    const Vec3d end(displacement(is_left ? pair.at.right : pair.at.left, motion)),
        lip(displacement(is_left ? stitch.lips.left : stitch.lips.right, motion));
    EXPECT_GT(norm(lip), 1e-4) << "m";
    EXPECT_LT(norm(end - lip), 1e-3 * norm(lip)) << "stitch " << pair.stitch;
    rims++;
  }
  EXPECT_GE(rims, 6);
}

/// Distances between the walls of a cut under one stitch, and the force between them.
struct WallsUnderStitch {
  WallDistances distances;
  double force = 0;  // [N]
};
WallsUnderStitch walls_now(const World& world) {
  WorldSnapshot snapshot;
  show(Exec(1), world, snapshot);
  WallsUnderStitch walls{WallDistances(snapshot.bodies[0])};
  for (const Suture& suture : world.sutures)
    if (suture.closure) walls.force += wall_force(*suture.closure);
  return walls;
}

// The walls of a wound press on each other as long as a suture of it bears, whichever that is: one whose
// thread breaks at once or later, and one that starts after another one of the file.
TEST(ClosedWound, WallsOutliveFirstSuture) {
  constexpr double kCell = 0.008;  // [m]
  struct Case {
    const char *start, *keys;  // of the first one
    double breaks;             // time at which the strength of its thread falls; 0 = never [s]
  };
  for (const Case c : {Case{"0.3", "tension = 3\n", 0.0},  // for comparison
                       {"0.3", "tension = 3\nthread_strength = 0.01\n", 0.0},
                       {"0.3", "tension = 3\n", 1.0},
                       {"5", "tension = 3\n", 0.0}}) {
    const Scene scene = closed_scene(test::fresh_folder(),
                                     single_stitch("upper", "0.012", c.start, c.keys) +
                                         single_stitch("lower", "-0.012", "0.3", "tension = 3\n"),
                                     6, false);
    World world = test::block_world(Exec(1), scene);
    double before = 0;
    while (time_of(world) < 1.6 - 1e-6) {
      if (c.breaks > 0 && std::abs(time_of(world) - c.breaks) < 1e-6) {
        before = walls_now(world).force;
        world.sutures[0].closure->thread.strength = 0.01;
      }
      ASSERT_TRUE(step(Exec(1), world));
    }
    const WallsUnderStitch walls = walls_now(world);
    const double pull = thread_force(*world.sutures[1].closure, world.lattice_bodies[0].state->motion);
    std::printf("first from %s s, %s: walls bear %.3f N (%.3f before) of %.3f N, overlap %.3f mm\n", c.start,
                world.sutures[0].closure && bears(*world.sutures[0].closure) ? "bears" : "bears nothing",
                walls.force, before, pull, -1e3 * walls.distances.least);
    EXPECT_GT(walls.force, 0.02 * pull) << "N";
    EXPECT_GT(walls.distances.least, -0.05 * kCell) << "m";
    // one closure has the walls
    int owners = 0;
    for (const Suture& suture : world.sutures) owners += suture.closure && !suture.closure->walls.empty();
    EXPECT_EQ(owners, 1);
  }
}

// Two stitches with the same tension at the same distance from the middle of a wound close it with the same
// force. Together they have the force of their threads less the pressure of the walls.
TEST(ClosedWound, SuturesShareThePressureOfWalls) {
  const Scene scene = closed_scene(test::fresh_folder(),
                                   single_stitch("upper", "0.012", "0.3", "tension = 3\n") +
                                       single_stitch("lower", "-0.012", "0.3", "tension = 3\n"),
                                   1.6, false);
  World world = test::block_world(Exec(1), scene);
  const Result<Simulated> run = simulate(Exec(1), scene, world);
  ASSERT_TRUE(run) << run.error().message;
  double closing[2], threads = 0, pressure = 0;
  for (const std::size_t n : {0, 1}) {
    closing[n] = run->measures.sutures[n].series.back().closing_force;
    threads += thread_force(*world.sutures[n].closure, world.lattice_bodies[0].state->motion);
    pressure += wall_force(*world.sutures[n].closure);
  }
  std::printf("closing forces %.4f and %.4f N, threads %.4f N, walls %.4f N\n", closing[0], closing[1],
              threads, pressure);
  EXPECT_GT(pressure, 0.1 * threads) << "N";
  EXPECT_NEAR(closing[0] + closing[1], threads - pressure, 1e-6 * threads);
  EXPECT_NEAR(closing[0], closing[1], 0.1 * closing[1]) << "N";
}

}  // namespace
}  // namespace turgor
