// The default law and solver of a cloth: stretch, sag and bending agree with theory at any cell size.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "tests/sim/bodies/cloth/cloth_scenes.hpp"
#include "turgor/models/cloth/cloth.hpp"

namespace turgor {
namespace {

using test::must_load;

constexpr double kCells[] = {0.01, 0.005, 0.0025};  // [m]

/// A strip along x with cells of a size, whose first column is held. Fabric and solver are the defaults.
std::string strip(double gravity, double from, double length, double width, double cell) {
  return fmt::format(
      "[world]\ngravity = [0, 0, {}]\n[body.strip]\nmodel = \"cloth\"\nsheet = {{ corner = [{}, 0, 0], side "
      "= "
      "[{}, 0, 0], up = [0, {}, 0], columns = {}, rows = {} }}\ncollision = {{ self = false }}\nwind = {{ "
      "density = 0 }}\ndamping = {{ motion = 4 }}\n",
      -gravity, from, length, width, std::lround(length / cell), std::lround(width / cell));
}

double lowest(const World& world) {
  const cloth::State& state = *world.cloth_bodies[0].state;
  double low = 0;
  for (int v = 0; v < world.cloth_bodies[0].model.count; v++)
    low = std::min(low, double(state.x[std::size_t(v)].z));
  return low;
}

// A strip of the default fabric pulled by 1 % has the force of 1000 N/m at any cell size.
TEST(ClothDefaults, StretchIsThatOfTheFabric) {
  for (const double cell : kCells) {
    World world = must_load(strip(0, 0, 0.1, 0.05, cell) +
                            "hold.left = { box = [[-1, -1, -1], [1e-4, 1, 1]] }\nhold.right = { box = "
                            "[[0.0999, -1, -1], [1, 1, 1]], path = [[0, 0, 0, 0], [0.1, 0.001, 0, 0]] }\n");
    test::run(world, 20);
    const double force = test::mean_of_last(world.cloth_bodies[0].holds[1].force, 5).x;
    EXPECT_NEAR(force, 1000 * 0.05 * 0.01, 0.01 * 0.5) << "N, cells of " << cell << " m";
  }
}

/// Sag of a rope of a length between supports at a distance, a (cosh(d/2a) − 1) with 2a sinh(d/2a) = length.
double catenary_sag(double length, double distance) {
  double low = distance / 100, high = 100 * distance;
  for (int n = 0; n < 100; n++) {
    const double a = (low + high) / 2;
    (2 * a * std::sinh(distance / 2 / a) > length ? low : high) = a;
  }
  return low * (std::cosh(distance / 2 / low) - 1);
}

// A strip of the default fabric that hangs between two edges has the sag of a catenary at any cell size.
TEST(ClothDefaults, SagIsThatOfACatenary) {
  const double sag = catenary_sag(0.3, 0.24);
  for (const double cell : kCells) {
    World world = must_load(strip(9.81, 0, 0.3, 0.03, cell) +
                            "hold.left = { box = [[-1, -1, -1], [1e-4, 1, 1]], path = [[0, 0, 0, 0], [0.4, "
                            "0.03, 0, 0]] }\nhold.right = { box = [[0.2999, -1, -1], [1, 1, 1]], path = [[0, "
                            "0, 0, 0], [0.4, -0.03, 0, 0]] }\n");
    test::run(world, 90);
    EXPECT_NEAR(-lowest(world) / sag, 1, 0.01) << "cells of " << cell << " m";
  }
}

/// Drop of the end of a clamped strip under its weight: B θ″ = −w (l − s) cos θ with θ(0) = 0, θ′(l) = 0.
double elastica_drop(double length, double rigidity, double weight) {
  double low = 0, high = 1000, drop = 0;  // curvature at the clamp [1/m]
  for (int n = 0; n < 60; n++) {
    constexpr int kSteps = 2000;
    const double h = length / kSteps;
    double angle = 0, curvature = (low + high) / 2;
    drop = 0;
    for (int i = 0; i < kSteps; i++) {
      curvature -= h * weight / rigidity * (length - (i + 0.5) * h) * std::cos(angle);
      angle += h * curvature, drop += h * std::sin(angle);
    }
    (curvature > 0 ? high : low) = (low + high) / 2;
  }
  return drop;
}

// A strip of the default fabric that stands over an edge droops as the elastica at any cell size.
TEST(ClothDefaults, OverhangDroopsAsElastica) {
  for (const double cell : kCells) {
    World world = must_load(strip(9.81, -0.02, 0.06, 0.03, cell) +
                            "hold.table = { box = [[-1, -1, -1], [1e-4, 1, 1]] }\n");
    test::run(world, 90);
    // the fold at the last held column is shared by the cells on both sides of it
    const double drop = elastica_drop(0.04 + cell / 2, 1e-5, 0.2 * 9.81);
    EXPECT_NEAR(-lowest(world) / drop, 1, 0.03) << "cells of " << cell << " m";
  }
}

/// Sentences of a world about a cloth.
bool mentions(const World& world, const std::string& words) {
  const std::vector<std::string> notes = notes_of(world);
  return std::any_of(notes.begin(), notes.end(),
                     [&](const std::string& note) { return note.find(words) != std::string::npos; });
}

// The springs and the sweeps of the paper are a choice, and a note says what they are; the default has none.
TEST(ClothDefaults, ChoicesOfThePaperAreNoted) {
  const std::string text = strip(9.81, 0, 0.1, 0.1, 0.01);
  const World plain = must_load(text);
  const cloth::Params& params = plain.cloth_bodies[0].model.params;
  EXPECT_EQ(params.fabric.law, cloth::Law::kSheet);
  EXPECT_EQ(params.solver.method, cloth::Method::kTwoLevel);
  EXPECT_EQ(params.solver.sweeps, 200);
  EXPECT_FALSE(mentions(plain, "depends on the mesh") || mentions(plain, "residual"));
  // `bend` is a key of the springs, so older scenes with it keep their law
  EXPECT_EQ(must_load(text, {"body.strip.fabric.bend=2"}).cloth_bodies[0].model.params.fabric.law,
            cloth::Law::kSprings);
  for (const char* method : {"sweeps", "chebyshev", "jacobi"}) {
    const World paper = must_load(text, {"body.strip.fabric.law=springs", "body.strip.fabric.bend=2",
                                         std::string("body.strip.solver.method=") + method});
    EXPECT_EQ(paper.cloth_bodies[0].model.params.fabric.law, cloth::Law::kSprings);
    EXPECT_EQ(paper.cloth_bodies[0].model.params.solver.sweeps, 16);
    EXPECT_TRUE(mentions(paper, "its stiffness depends on the mesh")) << method;
    EXPECT_TRUE(mentions(paper, "16 sweeps a frame do not check the residual")) << method;
  }
}

}  // namespace
}  // namespace turgor
