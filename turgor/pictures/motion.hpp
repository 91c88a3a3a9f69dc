// Motion of a run for the 3D view of its page: simplified surfaces, displacements of their vertices and
// forces at each frame. Frames are added one by one, like the pictures; the size is limited so that a page
// can hold them.
#pragma once

#include <string>
#include <vector>

#include "turgor/sim/snapshot.hpp"

namespace turgor {

/// A simplified surface between two changes of its triangles; empty if no kept frame uses it.
struct MovingSurface {
  std::uint64_t key = 0;        // of the triangles it was made from
  std::vector<int> vertex;      // number of the vertex in the full surface
  std::vector<Vec3> rest;       // [m]
  std::vector<Int3> triangles;  // walls of wounds last
  std::size_t wall_begin = 0;   // the first triangle of a wall
  std::vector<Rgb> colors;      // of the vertices, white on skin; empty: walls have one color
};

/// An object of the view: a body, other material inside it, a tool, or an obstacle under cloth.
struct MovingThing {
  enum class Kind : std::uint8_t { kBody, kInside, kTool, kObstacle } kind = Kind::kBody;
  std::string name;
  Look look = Look::kFlesh;
  double typical_force = 1;  // of a body [N]
  std::vector<MovingSurface> surfaces;
};

/// One frame.
struct MotionFrame {
  double time = 0;                       // [s]
  std::vector<std::size_t> surface;      // by thing: index of its surface
  std::vector<std::vector<Vec3>> moved;  // by thing: displacement of every vertex from rest [m]
  struct Force {
    Vec3d at, force;  // point of application on a tool [m], force [N]
  };
  std::vector<Force> forces;  // by tool
};

struct Motion {
  std::vector<MovingThing> things;
  std::vector<MotionFrame> frames;
  std::size_t numbers = 0;  // in the frames, and in the surfaces that they use
};

/// Size limits.
struct MotionLimits {
  std::size_t triangles = 40'000;    // of a body
  std::size_t numbers = 20'000'000;  // in memory; above it every second frame is dropped
};

/// Adds the current state of the world.
void add_moment(const WorldSnapshot& snapshot, Motion& motion, const MotionLimits& limits = {});
/// JSON of at most `bytes`, with fewer frames if necessary; the first and the last are kept. Empty if even
/// these are too large, or if no frame was added. Blocks of numbers are compressed (motion.cpp).
std::string motion_json(const Motion& motion, std::size_t bytes);

/// True if three.js is installed (Debian: libjs-three).
bool has_motion_view();
/// HTML of the view: a canvas with its controls, the libraries and the data. Empty if three.js is not
/// installed or `json` is empty.
std::string motion_html(const std::string& json);

}  // namespace turgor
