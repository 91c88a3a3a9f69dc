// Snapshot of a world for drawing: every body's surface with its quantities, every tool with its force.
// Pictures, mesh files, recordings and windows read only this, so that drawing cannot change the simulation.
// A reused snapshot keeps its memory.
#pragma once

#include <algorithm>
#include <any>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "turgor/contact/tool.hpp"
#include "turgor/core/exec.hpp"
#include "turgor/geometry/box.hpp"
#include "turgor/geometry/tri_mesh.hpp"
#include "turgor/geometry/volume.hpp"
#include "turgor/io/files/image.hpp"
#include "turgor/sim/scene/body_id.hpp"
#include "turgor/sim/scene/look_scene.hpp"

namespace turgor {

struct World;
struct TouchingTool;

/// Appearance of a surface without color map.
enum class Look : std::uint8_t { kFlesh, kSkin, kCloth };

/// Smooth surface of an organ for pictures (loop_subdivision.hpp), which the coarse vertices carry.
struct SmoothSnapshot {
  std::vector<Vec3> x, displacement, normals;  // per vertex; x is the present position [m]
  std::vector<float> pressure;                 // [Pa]; empty = unknown
  std::vector<Int3> triangles;                 // empty = the body is drawn as it is
  std::vector<Int3> coarse;                    // triangles of the body's mesh, of vertices of the snapshot
};

/// Color of a layer of tissue.
struct LayerLook {
  std::string name;
  std::optional<Rgb> color;  // none = that of walls
};

/// Layers of tissue on the walls of wounds: triangles that cover the walls, finer than those of the body.
struct WallLayers {
  std::vector<Int3> corner;         // of each vertex: vertices of the snapshot between which it lies
  std::vector<Vec3> weight;         // of these, with the sum 1
  std::vector<std::uint8_t> layer;  // of each vertex: index of its look; kNoLayer = none
  std::vector<Int3> triangles;      // empty: no layer has a color, or the body has no wound
  std::vector<LayerLook> looks;
  static constexpr std::uint8_t kNoLayer = 255;
};

struct BodySnapshot {
  BodyId id;
  std::string name;
  Look look = Look::kFlesh;

  std::vector<Vec3> rest, displacement, x;  // per vertex; x is the present position [m]
  std::vector<Vec3> normals;                // unit, outward
  std::vector<float> pressure;              // contact pressure [Pa]; empty = unknown
  std::vector<float> stretch;    // area stretch of the skin, area / rest area − 1; empty = unknown
  std::vector<Int3> triangles;   // counter-clockwise seen from outside
  std::vector<int> mesh_vertex;  // vertex index in the body's mesh, -1 = none; empty = identity
  TriMesh patch;                 // superposed fine patch (sfem) in its present shape
  TriMesh inside;                // inclusions (sfem) in their present shape
  std::vector<std::string> inside_names;
  SmoothSnapshot smooth;
  std::vector<CtVolume> sections;  // of a CT body by the planes of its cut-away, one sample thick
  std::size_t wall_begin = 0;      // first triangle of wound walls
  std::size_t cap_count = 0;       // triangles before it that close the body where its CT ends
  WallLayers wall_layers;
  Box box;                   // around the body at rest [m]
  double typical_force = 1;  // force of an indentation of about a centimeter [N]
  double seconds = 0;        // wall time of filling it

  std::any cache;  // cache of the model's `show`
};

/// A tool and its force.
struct ToolSnapshot {
  std::string name;
  BodyId body;  // touched body
  contact::Pose pose;
  Vec3d force;         // on the tool [N]
  double opening = 0;  // of the jaws [m]
  double size = 0;     // of the contacting end [m]
  bool has_jaws = false, is_needle = false;
  TriMesh mesh;  // about the tool's origin, with the present jaws
};

/// Sum of the forces of an attachment, or of a contact between bodies.
struct OrganForce {
  std::string name;
  BodyId body;  // on which the force acts, the first of `between`
  Vec3d at;     // mean of the points, weighted by the size of their forces [m]
  Vec3d force;  // [N]
};

struct WorldSnapshot {
  double time = 0;  // [s]
  int frame = 0;
  std::vector<BodySnapshot> bodies;      // all, in the order of for_each_body
  std::vector<ToolSnapshot> tools;       // indexed as World::tools
  std::vector<TriMesh> obstacles;        // cloth obstacles that are not bodies
  std::vector<TriMesh> threads;          // of sutures; empty where none bears
  std::vector<OrganForce> organ_forces;  // attachments, then contacts; without those that bear no force
  std::optional<CutawayScene> cutaway;   // set by the caller: whose planes have sections of a CT
};

/// Triangles of the body's outside, the first ones: without caps and walls of wounds.
inline std::span<const Int3> outer_triangles(const BodySnapshot& body) {
  const std::size_t walls = std::min(body.wall_begin, body.triangles.size());
  return std::span(body.triangles).first(walls - std::min(body.cap_count, walls));
}

/// Sets the fields that do not depend on the state.
template <class Body>
void show_name(BodyId id, const Body& body, BodySnapshot& out) {
  out.id = id, out.name = body.name, out.look = look_of(body);
  if constexpr (requires { body.typical_force; }) out.typical_force = body.typical_force;
  out.inside_names.clear();
  if constexpr (requires { body.inside; })
    for (const auto& region : body.inside) out.inside_names.push_back(region.name);
}

/// Sets the threads of the sutures.
void show_threads(const World& world, WorldSnapshot& out);
/// Sets the forces between bodies. Requires the points of the bodies.
void show_organ_forces(const World& world, WorldSnapshot& out);
/// Sets the section of the deformed CT in each plane of the cut-away.
void show_sections(const Exec& exec, const World& world, WorldSnapshot& out);
/// Fills the whole snapshot. `out` is new or of this world.
void show(const Exec& exec, const World& world, WorldSnapshot& out);
/// Sets names, looks, boxes and tool shapes; the caller fills in the rest.
void show_names(const World& world, WorldSnapshot& out);
/// Sets a tool at a pose, with its jaws open by `opening` [m].
void show_tool(const TouchingTool& tool, const contact::Pose& pose, Vec3d force, double opening,
               ToolSnapshot& out);

BodySnapshot& body_snapshot(WorldSnapshot& snapshot, BodyId id);
const BodySnapshot& body_snapshot(const WorldSnapshot& snapshot, BodyId id);
/// Tools that touch a body, in the order of its tool_indices.
std::vector<ToolSnapshot> tools_on(const WorldSnapshot& snapshot, BodyId id);

/// Computes positions, normals and the box from `rest`, `displacement` and `triangles`.
void update_vertices(BodySnapshot& body);

}  // namespace turgor
