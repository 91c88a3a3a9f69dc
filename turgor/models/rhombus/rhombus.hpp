// The rhombus model: an organ's surface that deforms under probes and forceps like chains of rhombi. [RC]
// Zhang, Song, Sun, Zou 2010, with the corrections listed in docs/models/rhombus.md. It has no volume mesh
// and no precomputation. A touch is a chain at the touched point, and the surrounding surface follows by its
// geodesic distance.
//
//   build             checks the surface                                      (build.cpp)
//   solve_touches     a haptic tick: contact and forces of tools              (touch.cpp)
//   step              a frame: geodesic distances, displacement of vertices   (step.cpp)
//   displacements_of  distributed loads such as cloth                         (spread.hpp)
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/core/result.hpp"
#include "turgor/geometry/triangle_tree.hpp"
#include "turgor/models/prony.hpp"
#include "turgor/models/rhombus/chain.hpp"
#include "turgor/models/rhombus/foot_point.hpp"
#include "turgor/models/rhombus/geodesic.hpp"
#include "turgor/models/rhombus/surface.hpp"
#include "turgor/models/rhombus/tip.hpp"

namespace turgor::rhombus {

struct Params {
  ChainParams chain;
  double bulge = 0;  // fraction of the pressed-in volume that rises around the press, in [0, 1]
  // All units relax alike, and so does the chain: a fast press meets (1 + total_ratio) times the long-term
  // force.
  Prony viscosity;
  // Largest force [N]. Beyond it held tissue slips out of the tool, and pressed tissue yields. Chains have no
  // limit of their own: their stiffness grows by growth_bound a newton.
  double tear = 30;
};

/// Input of a model.
struct Body {
  std::vector<Vec3d> vertices;    // [m]
  std::vector<Int3> triangles;    // counter-clockwise seen from outside
  std::vector<double> stiffness;  // of each vertex, relative to the chain's; empty = 1 everywhere
};

/// Constant data of an organ.
struct Model {
  Params params;
  Chain chain;
  Surface surface;
  TriangleTree tree;
  std::vector<double> area;               // of each vertex: a third of its triangles [m²]
  std::vector<double> stiffness;          // of each vertex; empty = 1 everywhere
  std::vector<Vec3d> stiffness_gradient;  // along the surface, of each vertex; empty likewise [1/m]
};

/// Builds a model. Error: an invalid chain or surface (chain.hpp, surface.hpp), a stiffness that is not
/// positive or not one a vertex, a bulge outside [0, 1], a relaxation time of zero.
Result<Model> build(Body body, const Params& params);

/// A tool in a tick: a ball, or the tip between two jaws that hold tissue when they close.
struct TouchInput {
  Vec3d position;     // of the tip's center [m]
  Mat3d axes;         // jaws open along the first one
  double radius = 0;  // of the tip [m]
  double grip =
      0;  // 0: open, the tip only presses; 1: closed on the tissue touched when grip became positive
  double opening = 0;  // between the jaws [m]
};

/// Force on a tool.
struct TouchForce {
  Vec3d force;         // [N]
  double depth = 0;    // of the touched point below rest; negative when pulled [m]
  double squeeze = 0;  // of the jaws on the fold between them [N]
  int units = 0;       // of the chain, moving
  bool touching = false;
  bool holding = false;
  bool slipped = false;  // lost what it held in this tick, because the force would have exceeded Params::tear
  bool yielding = false;       // presses more than the tissue bears: the force is limited to Params::tear
  bool too_deep = false;       // presses deeper than kDeepestPress radii, where the model is not valid
  bool invalid_input = false;  // a value is not finite: no force in this tick
};

/// State of one tool between ticks.
struct ToolTouch {
  bool touching = false;  // it bore force in the last tick
  bool holding = false;
  bool lagging = false;       // the tool leaves faster than the surface recovers
  bool closed_empty = false;  // closed without touching, or slipped: holds nothing until it has opened
  FootPoint foot;             // of the touched point; kept while holding
  Tip tip;                    // likewise
  Vec3d demand;               // displacement of the touched point required by the tool [m]
  Vec3d moved;                // displacement by this tool's own chains, without that of its neighbors [m]
  Vec3d elastic;              // force on the tool without viscosity [N]
  std::array<Vec3d, kMostPronyPairs> remembered{};  // viscous force of each pair [N]
  double depth_force = 0, drag_force = 0;  // of the two chains, before sharing and scaling (tip.hpp) [N]
  double depth_fraction = 0, drag_fraction = 0;  // fractions that this tool bears, in [0, 1]
  double depth_whole = 0;                        // depth of the tip by all tools [m]
  double stiffness_scale = 1;                    // of the body, relative to its model [1]

  Vec3d held_point;         // in the tool's frame [m]
  Mat3d held_axes;          // of the tool when it closed
  double held_opening = 0;  // of the jaws when it closed [m]
  double closing = 0;       // closing of the jaws since then, 0 to 1
  Vec3d fold_axis;          // across the fold, along the surface
  Mat3d turn;               // of the tool since it closed
};

constexpr int kMaxTouches = 8;

/// State of an organ.
struct State {
  std::vector<ToolTouch> touches;
  std::vector<Vec3d> displacement;       // of every vertex, after `step` [m]
  std::vector<int> moved;                // vertices with a displacement
  std::vector<GeodesicField> distances;  // from each touch
  std::vector<Vec3d> carried;            // by loads (spread.hpp), of every vertex; empty = none [m]

  std::vector<double> ring;          // valid within a step only
  std::vector<std::uint8_t> listed;  // likewise: 1 for vertices in `moved`
};

/// State at rest. At most kMaxTouches tools.
State make_state(const Model& model, std::size_t tool_count);

/// Solves one tick of `dt` seconds: inputs and forces one a tool. Allocates nothing and changes only the
/// touches of a state, so that a haptic thread may own them. `viscosity` replaces that of the model; it may
/// change between ticks: a pair that comes into use begins relaxed.
void solve_touches(const Model& model, const Prony& viscosity, std::span<ToolTouch> touches,
                   std::span<const TouchInput> inputs, double dt, std::span<TouchForce> forces);
inline void solve_touches(const Model& model, State& state, std::span<const TouchInput> inputs, double dt,
                          std::span<TouchForce> forces) {
  solve_touches(model, model.params.viscosity, std::span(state.touches), inputs, dt, forces);
}

struct StepReport {
  bool finite = true;
  double largest_displacement = 0;  // [m]
  double pressed_volume = 0;        // lost by the organ before it bulged; negative when pulled [m³]
};
/// Displaces the vertices by the touches of the last tick and by loads.
StepReport step(const Exec& exec, const Model& model, State& state);

/// Elastic energy of all touches [J]. Exact for one tool; for several tools the shared part is taken as
/// linear.
double energy(const Model& model, const State& state);

/// Memory of a model and its state [bytes].
std::size_t memory_bytes(const Model& model, const State& state);
/// Hash of the displacements.
std::uint64_t state_hash(const State& state);

/// Stiffness at a point of the surface, relative to the chain's.
double stiffness_at(const Model& model, const TrianglePoint& at);
/// Stiffness that a touch meets, relative to the chain's: at its foot point, times the scale of the body.
inline double stiffness_of(const Model& model, const ToolTouch& t) {
  return t.stiffness_scale * stiffness_at(model, t.foot.at);
}

}  // namespace turgor::rhombus
