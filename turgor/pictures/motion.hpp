// How a run moved, for the 3D view of its page: surfaces made coarse, and where their vertices and the forces
// were at moments. Told moment by moment, like the pictures; kept small, so that a page can hold it.
#pragma once

#include <string>
#include <vector>

#include "turgor/sim/snapshot.hpp"

namespace turgor {

/// A surface between two changes of its triangles, coarser than it was shown; empty when no frame that was
/// kept shows it.
struct MovingSurface {
  std::uint64_t key = 0;        // of the triangles it was made from
  std::vector<int> vertex;      // its number among those shown
  std::vector<Vec3> rest;       // [m]
  std::vector<Int3> triangles;  // walls of wounds last
  std::size_t wall_begin = 0;   // the first triangle of a wall
};

/// Something that is seen: a body, what is of another material in it, a tool, or what cloth lies on.
struct MovingThing {
  enum class Kind : std::uint8_t { kBody, kInside, kTool, kObstacle } kind = Kind::kBody;
  std::string name;
  Look look = Look::kFlesh;
  double usual_force = 1;  // of a body [N]
  std::vector<MovingSurface> surfaces;
};

/// One moment.
struct MotionFrame {
  double time = 0;                       // [s]
  std::vector<std::size_t> surface;      // by thing: which of its surfaces
  std::vector<std::vector<Vec3>> moved;  // by thing: of every vertex, since its rest [m]
  struct Force {
    Vec3d at, force;  // where it acts on a tool [m], and how [N]
  };
  std::vector<Force> forces;  // by tool
};

struct Motion {
  std::vector<MovingThing> things;
  std::vector<MotionFrame> frames;
  std::size_t numbers = 0;  // in the frames, and in the surfaces that they show
};

/// How much of it is kept.
struct MotionLimits {
  std::size_t triangles = 40'000;    // of a body
  std::size_t numbers = 20'000'000;  // in memory; beyond, every other frame goes
};

/// Adds how the world looks now.
void add_moment(const WorldSnapshot& snapshot, Motion& motion, const MotionLimits& limits = {});
/// As JSON in at most `bytes`, with fewer moments if need be; the first and the last stay. Empty when even
/// those are too large, or when nothing was added. Blocks of numbers are compressed: see motion.cpp.
std::string motion_json(const Motion& motion, std::size_t bytes);

/// Is three.js installed (Debian: libjs-three)?
bool has_motion_view();
/// The part of a page that shows it: a canvas with its bar, the libraries and the numbers. Empty where
/// three.js is not installed or `json` is empty.
std::string motion_html(const std::string& json);

}  // namespace turgor
