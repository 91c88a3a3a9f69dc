#include "turgor/pictures/animated_surfaces.hpp"

#include <algorithm>

#include <gtest/gtest.h>

namespace turgor {
namespace {

// A body and a tool of the same name have surfaces of their own, with one sample a time each.
TEST(AnimatedSurfaces, ToolMayHaveNameOfBody) {
  WorldSnapshot snapshot;
  BodySnapshot body;
  body.name = "pad";
  body.x = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, body.triangles = {{0, 1, 2}}, body.wall_begin = 1;
  ToolSnapshot tool;
  tool.name = "pad";
  tool.mesh = {body.x, body.triangles, {}, {}};
  snapshot.bodies.push_back(body), snapshot.tools.push_back(tool);
  SurfaceAnimation animation;
  for (const double time : {0.0, 0.1}) snapshot.time = time, add_surfaces(snapshot, animation);
  std::vector<std::string> names;
  for (const AnimatedSurface& surface : animation.surfaces) {
    names.push_back(surface.name);
    EXPECT_EQ(surface.samples.size(), 2u) << surface.name;
  }
  EXPECT_EQ(std::count(names.begin(), names.end(), "pad"), 1);
  EXPECT_EQ(std::count(names.begin(), names.end(), "pad tool"), 1);
}

}  // namespace
}  // namespace turgor
