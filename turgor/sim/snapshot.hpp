// A world as it looks at one moment: every body's surface with what is known on it, every tool with the force
// on it. Pictures, mesh files, recordings and windows read this and nothing else of a world, so that nothing
// that draws can change what is simulated. Filled again and again, it keeps its memory.
#pragma once

#include <any>
#include <string>
#include <vector>

#include "turgor/contact/tool.hpp"
#include "turgor/core/exec.hpp"
#include "turgor/geometry/box.hpp"
#include "turgor/geometry/tri_mesh.hpp"
#include "turgor/sim/scene/body_id.hpp"

namespace turgor {

struct World;
struct TouchingTool;

/// What a surface looks like where nothing colours it.
enum class Look : std::uint8_t { kFlesh, kSkin, kCloth };

struct BodySnapshot {
  BodyId id;
  std::string name;
  Look look = Look::kFlesh;

  std::vector<Vec3> rest, displacement, x;  // of every vertex; x is where it is [m]
  std::vector<Vec3> normals;                // unit, outward
  std::vector<float> pressure;              // of the contact [Pa]; empty = not known
  std::vector<float> stretch;               // of the skin: area now over area at rest, less 1; empty likewise
  std::vector<Int3> triangles;              // counter-clockwise seen from outside
  std::vector<int> mesh_vertex;             // its number in the body's mesh, -1 = none; empty = as here
  TriMesh patch;                            // of finer functions, superposed (sfem), as it lies now
  TriMesh inside;                           // of what is harder or softer in it (sfem), as it lies now
  std::size_t wall_begin = 0;               // from this triangle on they are walls of wounds
  Box box;                                  // around the body at rest [m]
  double usual_force = 1;                   // that presses a centimetre of it in by about a centimetre [N]
  double seconds = 0;                       // wall time of showing it

  std::any kept;  // what `show` of its model keeps until the next time, and nobody else looks at
};

/// A tool and what it feels.
struct ToolSnapshot {
  std::string name;
  BodyId body;  // that it touches
  contact::Pose pose;
  Vec3d force;         // on the tool [N]
  double opening = 0;  // of its jaws [m]
  double size = 0;     // of the part that touches [m]
  bool has_jaws = false;
  TriMesh mesh;  // about the tool's origin, its jaws as they are
};

struct WorldSnapshot {
  double time = 0;  // [s]
  int frame = 0;
  std::vector<BodySnapshot> bodies;  // all, in the order of for_each_body
  std::vector<ToolSnapshot> tools;   // as in World::tools
  std::vector<TriMesh> obstacles;    // shapes that are no bodies, where cloth lies on them
};

/// What is known of a body without its state.
template <class Body>
void show_name(BodyId id, const Body& body, BodySnapshot& out) {
  out.id = id, out.name = body.name, out.look = look_of(body);
  if constexpr (requires { body.usual_force; }) out.usual_force = body.usual_force;
}

/// Shows all of it. `out` is of this world, or new.
void show(const Exec& exec, const World& world, WorldSnapshot& out);
/// Names, looks, boxes and tools' shapes, for those who fill in the rest from elsewhere.
void show_names(const World& world, WorldSnapshot& out);
/// A tool that lies so, with its jaws open by `opening` [m].
void show_tool(const TouchingTool& tool, const contact::Pose& pose, Vec3d force, double opening,
               ToolSnapshot& out);

BodySnapshot& body_snapshot(WorldSnapshot& snapshot, BodyId id);
const BodySnapshot& body_snapshot(const WorldSnapshot& snapshot, BodyId id);
/// The tools that touch a body, in the order of its tool_indices.
std::vector<ToolSnapshot> tools_on(const WorldSnapshot& snapshot, BodyId id);

/// Places, normals and the box of a surface whose `rest`, `displacement` and `triangles` are there.
void place_vertices(BodySnapshot& body);

}  // namespace turgor
