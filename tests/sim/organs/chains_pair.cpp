// Bodies of chains that touch and hold each other and the ground: Hertz on a plane, conditions of contact,
// and the law of a spring on two half spaces.
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "organs_scene.hpp"
#include "turgor/geometry/ball_mesh.hpp"
#include "turgor/io/mesh/mesh_files.hpp"
#include "turgor/models/rhombus/spread.hpp"
#include "turgor/sim/world_state.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;
using test::advance;

constexpr double kBall = 0.05;  // radius [m]

/// A folder with balls around (0, 0, 0) and (0, 0, 2 radii + 1 mm), whose poles are vertices.
fs::path balls_folder(int halvings) {
  const fs::path folder = test::fresh_folder();
  TriMesh ball = ball_mesh(Real(kBall), halvings);
  EXPECT_TRUE(write_obj(folder / "lower.obj", ball));
  for (Vec3& x : ball.vertices) x.z += Real(2 * kBall + 0.001);
  EXPECT_TRUE(write_obj(folder / "upper.obj", ball));
  return folder;
}
std::string ball_text(const std::string& name) {
  return fmt::format("[body.{}]\nmodel = \"rhombus\"\nsurface = \"{}.obj\"\n", name, name);
}
World balls_world(const Exec& exec, int halvings, const std::string& text) {
  const Result<Scene> scene = parse_scene("[world]\nduration = 20\ngravity = [0, 0, 9.81]\n" + text,
                                          balls_folder(halvings) / "balls.toml");
  EXPECT_TRUE(scene) << scene.error().message;
  Result<World> world = load_world(exec, *scene);
  EXPECT_TRUE(world) << world.error().message;
  return std::move(*world);
}
/// Forceps that pull the upper pole of the lower ball by 6 mm toward the upper ball. They wait before and
/// after they pull [s].
std::string lifted_pole(double hold) {
  return fmt::format(
      "[tool.forceps]\nbody = \"lower\"\nshape = {{ forceps = \"phantom\", opening = 0.012, closing = 0.05 "
      "}}\n"
      "grasp = {{ at_fraction = [0.5, 0.5, 0], depth = 0.003, pull = 0.006, start = 0.05, duration = 0.1, "
      "hold "
      "= {} }}\n",
      hold);
}
/// A weight of 0.1 kg that pulls the cap of the lower ball by springs against the upper ball.
std::string pulled_cap(double friction) {
  return ball_text("lower") + ball_text("upper") +
         fmt::format(
             "[body.weight]\nmodel = \"rigid\"\nshape = {{ sphere = 0.015 }}\nat = [0, 0, 0.05]\nmass = 0.1\n"
             "[contact.balls]\nbetween = [\"lower\", \"upper\"]\nfriction = {}\nsites = 100\n"
             "[attachment.ring]\nbetween = [\"lower\", \"weight\"]\ndistance = 0.003\nstiffness = "
             "1000\npoints = 60\n",
             friction);
}
Vec3d contact_force_on_first(const World& world) { return world.coupling.contacts[0].samples.back().force; }
Vec3d load_on_ball(const World& world, std::size_t body) {
  Vec3d sum;
  for (const CoupledSupport& support : world.coupling.supports)
    if (support.body == BodyId{BodyKind::kRhombus, int(body)})
      for (const contact::VertexForce& f : support.solved) sum += f.force;
  return sum;
}

// The ground is 1 and 2 mm inside a ball of chains: it bears Hertz's force.
TEST(ChainsPair, BallOnGround_MatchesHertz) {
  const Exec exec(2);
  for (const double depth : {0.001, 0.002}) {
    World world =
        balls_world(exec, 5,
                    ball_text("lower") +
                        fmt::format("[contact.floor]\nbetween = [\"lower\", \"ground\"]\nthrough = [0, 0, "
                                    "{}]\nsites = 200\nfriction = 0\n",
                                    -kBall + depth));
    advance(exec, world, 100);
    const double modulus = rhombus::half_space_modulus(world.rhombus_bodies[0].model.chain);
    const double hertz = 4.0 / 3 * modulus * std::sqrt(kBall) * std::pow(depth, 1.5);
    const Vec3d force = contact_force_on_first(world), load = load_on_ball(world, 0);
    std::printf("depth %.1f mm: %.5f N of %.5f N, load %.5f N\n", 1e3 * depth, force.z, hertz, load.z);
    EXPECT_NEAR(force.z, hertz, 0.02 * hertz);
    EXPECT_LT(norm(load - force), 1e-3 * hertz);
  }
}

// A cap that is pulled into another ball: both bear the same force, surfaces meet where it acts, and are
// apart elsewhere.
TEST(ChainsPair, PulledCap_TouchesOtherBall) {
  const Exec exec(2);
  World world = balls_world(exec, 4, pulled_cap(0));
  advance(exec, world, 100);
  const BodyContact& contact = world.coupling.contacts[0];
  const Vec3d force = contact_force_on_first(world);
  const double size = norm(force);
  int bearing = 0;
  double nearest = HUGE_VAL, farthest = 0;
  for (const contact::PairSite& site : contact.sites)
    if (site.force != Vec3d{})
      bearing++, farthest = std::max(farthest, std::abs(site.distance));
    else
      nearest = std::min(nearest, site.distance);
  std::printf("%.5f N on %d sites, loads %.5f and %.5f N, distances %.2g and %.2g mm\n", force.z, bearing,
              load_on_ball(world, 0).z, load_on_ball(world, 1).z, 1e3 * farthest, 1e3 * nearest);
  EXPECT_LT(force.z, -0.01);
  EXPECT_GT(bearing, 3);
  const Vec3d pull = world.coupling.attachments[0].samples.back().force;
  EXPECT_LT(norm(pull - Vec3d{0, 0, 0.1 * 9.81}), 1e-3 * size);
  EXPECT_LT(norm(load_on_ball(world, 0) - force - pull), 1e-3 * size);
  EXPECT_LT(norm(load_on_ball(world, 1) + force), 1e-3 * size);
  EXPECT_LT(farthest, 1e-5);
  EXPECT_GT(nearest, -1e-5);
}

/// Displacement of a point at a vertex per force on it: that of a half space under even pressure on the
/// vertex's area.
double compliance_at_vertex(const World& world, std::size_t body, const contact::SurfacePoint& point) {
  const Vec3d w = point.weight;
  const int vertex = w.x > 0.5 ? point.vertex.x : w.y > 0.5 ? point.vertex.y : point.vertex.z;
  const rhombus::Model& model = world.rhombus_bodies[body].model;
  const double radius = std::sqrt(model.area[std::size_t(vertex)] / std::numbers::pi);
  return 16 / (3 * std::numbers::pi * std::numbers::pi * rhombus::half_space_modulus(model.chain) * radius);
}

// A spring between the pulled pole and the ground, or the other ball, has the force of three springs in
// series: its own, and the half spaces of its ends.
TEST(ChainsPair, SpringOnPulledPole_MatchesSeries) {
  const Exec exec(2);
  const std::string balls = ball_text("lower") + ball_text("upper") + lifted_pole(1);
  World alone = balls_world(exec, 4, balls);
  advance(exec, alone, 100);
  for (const bool on_ground : {true, false}) {
    constexpr double kStiffness = 30;
    World world = balls_world(
        exec, 4,
        balls + fmt::format("[attachment.spring]\nbetween = [\"lower\", \"{}\"]\n{}stiffness = {}\n",
                            on_ground ? "ground" : "upper",
                            on_ground ? "box = [[-1e-4, -1e-4, 0.0499], [1e-4, 1e-4, 0.0501]]\n"
                                      : "distance = 0.00101\n",
                            kStiffness));
    const Attachment& spring = world.coupling.attachments[0];
    ASSERT_EQ(spring.ties.size(), 1u);
    const contact::Tie& tie = spring.ties[0];
    double compliance = 1 / kStiffness + compliance_at_vertex(world, 0, tie.a);
    if (!on_ground) compliance += compliance_at_vertex(world, 1, tie.b);
    advance(exec, world, 100);
    const Vec3d moved = alone.rhombus_bodies[0].state.displacement[std::size_t(tie.a.vertex.x)];
    const Vec3d expected = moved / -compliance, force = spring.samples.back().force;
    std::printf("spring %.5f N of %.5f N\n", force.z, expected.z);
    EXPECT_LT(expected.z, -0.01);
    EXPECT_LT(norm(force - expected), 2e-3 * norm(expected));
    EXPECT_LT(norm(load_on_ball(world, 0) - force), 1e-3 * norm(force));
    if (!on_ground) {
      EXPECT_LT(norm(load_on_ball(world, 1) + force), 1e-3 * norm(force));
    }
  }
}

// Balls in contact have the same bits on any number of threads, and after a copy.
TEST(ChainsPair, Balls_SameBits) {
  World world = balls_world(Exec(1), 3, pulled_cap(0.1));
  advance(Exec(1), world, 12);
  World copy = copy_of(world);
  advance(Exec(1), world, 12);
  advance(Exec(8), copy, 12);
  EXPECT_EQ(state_hash(copy), state_hash(world));
  EXPECT_NE(contact_force_on_first(world), Vec3d{});
}

// A fixed rigid plate 2 mm inside a ball of chains bears the force of the ground there.
TEST(ChainsPair, BallOnFixedPlate_BearsAsGround) {
  const Exec exec(2);
  const auto force = [&](const std::string& text) {
    World world = balls_world(exec, 4, ball_text("lower") + text);
    advance(exec, world, 100);
    return contact_force_on_first(world);
  };
  const Vec3d plate = force(
      "[body.plate]\nmodel = \"rigid\"\nshape = { box = [0.1, 0.1, 0.02] }\nat = [0, 0, -0.058]\nmass = "
      "1\nfixed = "
      "true\n[contact.rest]\nbetween = [\"lower\", \"plate\"]\nfriction = 0\nsites = 200\n");
  const Vec3d ground = force(
      "[contact.rest]\nbetween = [\"lower\", \"ground\"]\nthrough = [0, 0, -0.048]\nfriction = 0\nsites = "
      "200\n");
  std::printf("plate %.5f N, ground %.5f N\n", plate.z, ground.z);
  EXPECT_GT(ground.z, 0.01);
  EXPECT_LT(norm(plate - ground), 0.01 * norm(ground));
}

}  // namespace
}  // namespace turgor
