// The rhombus model: an organ's skin that gives under probes and forceps like chains of rhombi. [RC] Zhang,
// Song, Sun, Zou 2010, with the corrections listed in docs/models/rhombus.md. There is no volume mesh and
// nothing to precompute: a touch is a chain under the touched point, and what surrounds it follows by its
// distance along the surface.
//
//   build        checks the surface                                          (build.cpp)
//   touch        a haptic tick: where tools touch, their forces              (touch.cpp)
//   step         a picture: distances along the surface, every vertex's move (step.cpp)
//   displacements_of  what lies on it, such as cloth                         (spread.hpp)
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/core/result.hpp"
#include "turgor/geometry/triangle_tree.hpp"
#include "turgor/models/rhombus/chain.hpp"
#include "turgor/models/rhombus/foot.hpp"
#include "turgor/models/rhombus/geodesic.hpp"
#include "turgor/models/rhombus/surface.hpp"
#include "turgor/models/rhombus/tip.hpp"

namespace turgor::rhombus {

/// All units relax alike, so the chain does: a fast press feels (1 + stiffening) times the force that is left
/// when it is held for long.
struct Viscosity {
  double stiffening = 0;  // 0 = elastic [1]
  double time = 0.1;      // of relaxation [s]
};

struct Params {
  ChainParams chain;
  double bulge = 0;  // of the volume that is pressed in, so much rises around the press, in [0, 1]
  Viscosity viscosity;
  // No force is larger: what a tool holds slips out of it then, and what it presses gives way. Chains alone
  // have no such end: their stiffness grows with the force, by growth_bound a newton [N].
  double tear = 30;
};

/// What a model is built from.
struct Body {
  std::vector<Vec3d> vertices;    // [m]
  std::vector<Int3> triangles;    // counter-clockwise seen from outside
  std::vector<double> stiffness;  // at each vertex, in multiples of the chain's; empty = 1 everywhere
};

/// What does not change while the organ is touched.
struct Model {
  Params params;
  Chain chain;
  Surface surface;
  TriangleTree tree;
  std::vector<double> area;               // of each vertex: a third of its triangles [m²]
  std::vector<double> stiffness;          // of each vertex; empty = 1 everywhere
  std::vector<Vec3d> stiffness_gradient;  // along the surface, of each vertex; empty likewise [1/m]
};

/// Error: a chain or a surface that is none (chain.hpp, surface.hpp), a stiffness that is not positive or not
/// one a vertex, a bulge outside [0, 1], a relaxation that takes no time.
Result<Model> build(Body body, const Params& params);

/// A tool in a tick: a ball, or the tip between two jaws that hold what they closed on.
struct TouchInput {
  Vec3d position;      // of the tip's centre [m]
  Mat3d axes;          // jaws open along the first one
  double radius = 0;   // of the tip [m]
  double grip = 0;     // 0: open, the tip only presses; 1: closed on what it touched when grip left 0
  double opening = 0;  // between the jaws [m]
};

/// On a tool.
struct TouchForce {
  Vec3d force;         // [N]
  double depth = 0;    // that the touched point is pressed in; negative when pulled out [m]
  double squeeze = 0;  // of the jaws on the fold between them [N]
  int units = 0;       // of the chain that move
  bool touching = false;
  bool holding = false;
  bool slipped = false;   // out of what it held, in this tick: that would have borne more than Params::tear
  bool yielding = false;  // it presses harder than the tissue bears: the force stays at Params::tear
  bool invalid_input = false;  // a number that is none: no force in this tick
};

/// One tool between ticks.
struct Touching {
  bool touching = false;  // it bore force in the last tick
  bool holding = false;
  bool lagging = false;       // the tool left faster than the surface comes back
  bool closed_empty = false;  // it closed without touching, or slipped: holds nothing until it has opened
  Foot foot;                  // of the touched point; kept while holding
  Tip tip;                    // likewise
  Vec3d demand;               // where the tool wants the touched point, from rest [m]
  Vec3d moved;                // what this tool's own chains make of it, less what its neighbours do [m]
  Vec3d elastic;              // force on the tool without viscosity [N]
  Vec3d remembered;           // by the material, on top of that [N]
  double depth_force = 0, drag_force = 0;  // of the two chains, whole and unscaled (tip.hpp) [N]
  double depth_part = 0, drag_part = 0;    // of them that this tool bears, in [0, 1]

  Vec3d held_point;         // of the tool, in its frame [m]
  Mat3d held_axes;          // of the tool when it closed
  double held_opening = 0;  // of the jaws then [m]
  double closing = 0;       // how far they closed since, 0 to 1
  Vec3d fold_axis;          // across the fold, along the surface
  Mat3d turn;               // of the tool since it closed
};

constexpr int kMaxTouches = 8;

/// What changes.
struct State {
  std::vector<Touching> touches;
  std::vector<Vec3d> displacement;       // of every vertex, after `step` [m]
  std::vector<int> moved;                // vertices whose displacement is not zero
  std::vector<GeodesicField> distances;  // from each touch
  std::vector<Vec3d> carried;            // by loads (spread.hpp), of every vertex; empty = none [m]

  std::vector<double> ring;          // of use within a step only
  std::vector<std::uint8_t> listed;  // likewise: 1 for those in `moved`
};

/// At rest. At most kMaxTouches tools.
State make_state(const Model& model, std::size_t tool_count);

/// One tick of `dt` seconds: inputs and forces one a tool. Allocates nothing, and changes of a state its
/// touches alone: a haptic thread may have those to itself.
void touch(const Model& model, std::span<Touching> touches, std::span<const TouchInput> inputs, double dt,
           std::span<TouchForce> forces);
inline void touch(const Model& model, State& state, std::span<const TouchInput> inputs, double dt,
                  std::span<TouchForce> forces) {
  touch(model, std::span(state.touches), inputs, dt, forces);
}

struct StepReport {
  bool finite = true;
  double largest_displacement = 0;  // [m]
  double pressed_volume = 0;        // that the organ lost before it bulged; negative when pulled [m³]
};
/// Moves the vertices to what the last tick and what they carry made of them.
StepReport step(const Exec& exec, const Model& model, State& state);

/// Elastic energy of what tools hold and press [J]. Exact for one tool; for several it takes what they share
/// as linear.
double energy(const Model& model, const State& state);

/// Memory of a model and its state while it runs.
std::size_t memory_bytes(const Model& model, const State& state);
/// Equal for equal displacements.
std::uint64_t state_hash(const State& state);

/// Of the organ at a point of its surface, in multiples of the chain's.
double stiffness_at(const Model& model, const TrianglePoint& at);

}  // namespace turgor::rhombus
