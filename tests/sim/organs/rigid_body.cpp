// A body so stiff that it moves as a rigid one.
#include <cmath>

#include "organs_scene.hpp"

namespace turgor {
namespace {

using test::advance;
using test::block_text;
using test::organs_world;

constexpr double kBone = 1e9;  // [Pa]

/// Largest distance of a displaced vertex from the plane motion u.x = a + b z, u.z = c - b x that fits best
/// [m]: what a rigid body by small angles about y leaves.
double bent(const SfemBody& body) {
  const std::vector<Vec3d>& x = body.model.body.mesh.vertices;
  const std::vector<Vec3d>& u = body.flight->u;
  Vec3d center, moved;
  for (std::size_t v = 0; v < x.size(); v++)
    center += x[v] / double(x.size()), moved += u[v] / double(x.size());
  double turn = 0, arm = 0;
  for (std::size_t v = 0; v < x.size(); v++) {
    const Vec3d r = x[v] - center, d = u[v] - moved;
    turn += r.z * d.x - r.x * d.z, arm += r.x * r.x + r.z * r.z;
  }
  double most = 0;
  for (std::size_t v = 0; v < x.size(); v++) {
    const Vec3d r = x[v] - center;
    most = std::max(most, norm(u[v] - moved - turn / arm * Vec3d{r.z, 0, -r.x}));
  }
  return most;
}

// A bar hangs by its ends from springs of 150 and 600 N/m. Each bears half the weight, so that the ends sink
// by weight / (2 k), and a bar of bone stays straight. A bar of tissue on the same springs bends.
TEST(Organs, StiffBar_HangsStraight) {
  const Exec exec(1);
  for (const double young : {kBone, 2e4}) {
    World world = organs_world(
        exec, "[world]\ngravity = [0, 0, -9.81]\nduration = 5\n" +
                  block_text("bar", "[0, 0, 0]", "[0.12, 0.01, 0.01]", "[12, 1, 1]", "none", young) +
                  "density = 1800\n"
                  "[attachment.left]\nbetween = [\"bar\", \"ground\"]\nbox = [[-1, -1, -1], [0.0001, 1, 1]]\n"
                  "stiffness = 150\n"
                  "[attachment.right]\nbetween = [\"bar\", \"ground\"]\nbox = [[0.1199, -1, -1], [1, 1, 1]]\n"
                  "stiffness = 600\n");
    advance(exec, world, 400);
    const SfemBody& bar = world.sfem_bodies[0];
    const double weight = test::mass_of(bar) * 9.81;
    double left = 0, right = 0;
    int ends = 0;
    for (std::size_t v = 0; v < bar.flight->u.size(); v++) {
      const double x = bar.model.body.mesh.vertices[v].x, z = bar.flight->u[v].z;
      if (x < 1e-6) left += z, ends++;
      if (x > 0.12 - 1e-6) right += z;
    }
    const double sunk = weight / (2 * 150);
    if (young == kBone) {
      EXPECT_NEAR(left / ends, -sunk, 0.01 * sunk);
      EXPECT_NEAR(right / ends, -sunk / 4, 0.01 * sunk);
      const double bends = 5 * weight / 0.12 * std::pow(0.12, 4) / (384 * kBone * std::pow(0.01, 4) / 12);
      EXPECT_LT(bent(bar), bends) << "the middle of a bar of bone bends by this";
      EXPECT_LT(bends, 0.01 * sunk);
    } else {
      EXPECT_GT(bent(bar), 0.1 * sunk);
    }
  }
}

}  // namespace
}  // namespace turgor
