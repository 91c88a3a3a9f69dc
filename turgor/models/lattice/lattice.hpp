// The lattice model: a CT volume as a body of springs, volumes and tense skin, that can be cut. [STC] Jeon,
// Seo, Kye 2025, with the corrections listed in docs/models/lattice.md. Two solvers run on the same
// constraints: position-based dynamics as in the paper, and vertex block descent (Chen et al. 2024), whose
// answer does not depend on its effort.
//
// Displacements, velocities and forces are along the lattice's own axes (Model::grid.axes turns them into the
// patient frame).
#pragma once

#include <array>
#include <bitset>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "turgor/core/aligned.hpp"
#include "turgor/core/exec.hpp"
#include "turgor/core/result.hpp"
#include "turgor/geometry/lattice.hpp"
#include "turgor/geometry/volume.hpp"
#include "turgor/models/lattice/model/runs.hpp"

namespace turgor::lattice {

enum class Method : std::uint8_t { kPbd, kVbd };
/// The order of a sweep: slab by slab of layers, or colour by colour (colors.hpp).
enum class Ordering : std::uint8_t { kSlabs, kColors };
enum class SkinLaw : std::uint8_t { kArea, kFiber };
/// Springs along the edges, as in the paper, or solid cells that answer alike in every direction.
enum class TissueLaw : std::uint8_t { kSprings, kSolid };
/// What a node is made of. Outside = air around the body; gas = air inside it (lungs, bowel).
enum class Tissue : std::uint8_t { kOutside, kGas, kFat, kMuscle, kBone };

struct SkinParams {
  bool enabled = true;
  SkinLaw law = SkinLaw::kFiber;
  double tension_along = 45;   // pull along Langer's lines; the area law uses the mean of both [N/m]
  double tension_across = 45;  // pull across them [N/m]
  double stiffness = 300;      // of the membrane, in both directions [N/m]
  double shear = 100;          // fibre law only [N/m]
  double amplification = 2;    // how fast skin stiffens when stretched, β of the paper [1]
  Vec3d direction{1, 0, 0};    // Langer's lines, patient frame; need not lie in the skin

  friend bool operator==(const SkinParams&, const SkinParams&) = default;
};

struct TissueParams {
  TissueLaw law = TissueLaw::kSprings;
  double gas = 1e3, fat = 5e3, muscle = 2e4, bone = 1e7;  // Young's modulus [Pa]
  double air_max = -449;                                  // below: air [HU]
  double fat_max = -30;                                   // below: fat [HU]
  double bone_min = 200;                                  // above: bone [HU]
  double volume = 0;  // springs: bulk stiffness added by a volume energy, in multiples of Young's modulus [1]
  double poisson = 0.45;                 // solid: Poisson's ratio, 0 to 0.49 [1]
  std::map<int, double> young_of_label;  // Young's modulus by label of a segmentation [Pa]
};

struct SolverParams {
  Method method = Method::kVbd;
  Ordering ordering = Ordering::kSlabs;
  int sweeps = 5;
  double damping = 1.2;      // velocities lose exp(-damping·t) [1/s]
  double pbd_stiffness = 1;  // pbd only: scales the density-based stiffness in [0, 1] [1]
  bool pbd_volume = false;   // pbd only: project the tetrahedra's volumes too
  bool coarse =
      true;  // solid descent only: the smooth part of what sweeps leave is solved for (coarse_correction.hpp)
  double sleep = 0;  // descent only: rows near which nothing is faster sleep; 0: none does [m/s]
};

struct Params {
  Int3 block{4, 4, 4};  // voxels per lattice step
  bool fix_bone = true;
  bool fix_ends = false;  // the layers nearest to head and feet, where a scan ends
  TissueParams tissue;
  SkinParams skin;
  SolverParams solver;
};

/// Three scalars a slot, each in an array of its own.
struct VecField {
  aligned_vector<Real> x, y, z;

  Vec3 operator[](std::size_t slot) const { return {x[slot], y[slot], z[slot]}; }
  void set(std::size_t slot, Vec3 value) { x[slot] = value.x, y[slot] = value.y, z[slot] = value.z; }
  void resize(std::size_t count) { x.resize(count), y.resize(count), z.resize(count); }
};

/// A triangle of skin. F d = Σ along[q] x[vertex[q]] is the image of the unit vector d along Langer's lines,
/// and likewise across.
struct SkinTriangle {
  Int3 vertex;        // slots, counter-clockwise seen from outside
  Vec3 edge1, edge2;  // rest, from the first corner to the others [m]
  Real area;          // as in the CT [m²]
  Real along[3];      // [1/m]
  Real across[3];     // [1/m]
  Real stiffness;     // pbd only, from the nodes' density, in [0, 1]
};

/// Triangles are worked on so many at a time, each number of them side by side. Lanes behind the last
/// triangle repeat the first.
constexpr int kSkinLanes = 16;

/// pbd: a batch of triangles without a node in common.
struct SkinBatch {
  int vertex[3][kSkinLanes];    // slots
  Real edge[2][3][kSkinLanes];  // SkinTriangle::edge1, edge2 by axis [m]
  Real area[kSkinLanes];        // [m²]
  Real stiffness[kSkinLanes];   // in [0, 1]
};

/// descent: corners of triangles, each seen from its own node.
struct SkinCorners {
  int triangle[kSkinLanes];
  int vertex[3][kSkinLanes];                         // slots, the node itself first
  Real edge[2][3][kSkinLanes];                       // from it to the others, by axis [m]
  Real along[3][kSkinLanes], across[3][kSkinLanes];  // of SkinTriangle, in the order of `vertex` [1/m]
  Real area[kSkinLanes];                             // [m²]
};

/// All skin, sorted by cell layer, and within a layer in batches whose triangles share no node. Batch b is
/// triangles [batch_begin[b], batch_begin[b + 1]); the batches of layer k are [layer_begin[k], layer_begin[k
/// + 1]). Where pbd goes by colours, each layer is four groups, by the parities of i and j of the cells, p =
/// 0 to 3: those of group 4 k + p.
struct Skin {
  std::vector<SkinTriangle> triangles;
  std::vector<Vec3> lines;  // at each triangle, lattice frame; empty: SkinParams::direction everywhere
  std::vector<int> batch_begin, layer_begin;  // empty without skin
  std::vector<SkinBatch> batches;             // pbd
  // The corners of triangles by node: nodes in slot order; row_begin and lanes_begin have one entry per half
  // row of the storage. Corner c of a half row that begins with corner b is lane (c − b) % kSkinLanes of
  // corners[lanes_begin + (c − b) / kSkinLanes].
  std::vector<int> nodes;  // slots
  std::vector<Vec3>
      pull;  // descent: of the skin at each node in the CT; the tissue's own prestress answers it [N]
  std::vector<int> corner_begin;     // nodes.size() + 1
  std::vector<int> row_begin;        // 2 · rows + 1, indices into nodes
  std::vector<SkinCorners> corners;  // descent
  std::vector<int> lanes_begin;      // descent: 2 · rows + 1
};

/// What a group of slots has around it: nothing that moves, whole cells alone, or springs as well.
enum class Around : std::uint8_t { kNothing, kCells, kSprings };

/// Layers [begin, end) of nodes, or of the cells above them.
struct Layers {
  int begin = 0, end = 0;
};

/// What does not change while the body moves.
struct Model {
  Params params;
  Grid grid;                            // of the nodes, in the patient
  Lattice lattice;                      // of the nodes, in memory
  Layers owned;                         // worked on here: all, unless others hold the rest (halo.hpp)
  aligned_vector<Real> inverse_mass;    // by slot; 0 = fixed, or no node [1/kg]
  aligned_vector<Real> root_stiffness;  // by slot; an edge has the product of its two ends [√Pa, pbd: 1]
  aligned_vector<Tissue> tissue;        // by slot
  aligned_vector<std::int16_t> hu;      // by slot, mean of the block [HU]
  std::array<Real, kFamilyCount> rest_length{};   // [m]
  std::array<Real, kFamilyCount> spring_scale{};  // spring stiffness = scale · root · root [m]
  Real rest_volume = 0;                           // of a tetrahedron [m³]
  Real volume_scale = 0;                          // volume stiffness = scale · mean root² [1]
  aligned_vector<Real> cell_young;  // solid: by slot of a cell's lowest node; 0 = no whole cell [Pa]
  std::vector<Around> around;       // solid: by group of slots, in the CT
  Runs moving;                      // slots of nodes that can move
  Runs joining;                     // pbd: slots of nodes whose edges or tetrahedra hold a node that can move
  Skin skin;
  int body_nodes = 0, free_nodes = 0;
};

/// An edge of the fine lattice (fine_lattice.hpp) that a blade went through.
struct CutEdge {
  int slot = 0;  // of the cell's lowest node
  int part = 0;  // the edge's lower end in that cell: x + 8 y + 64 z, in parts of it
  std::uint8_t family = 0;
  std::uint8_t incision = 0;   // which incision of the scene
  std::uint8_t rightward = 0;  // 1 = leads from the blade's left side to its right one
  Real fraction = 0;           // where, from the lower end, in [0, 1]
  Real along = 0;              // where on the blade's path [m]
};

/// Lines through a cell, 8 × 8 along each axis (cut_fraction.hpp), that a blade went through.
struct CutFractionSamples {
  int slot = 0;               // of its lowest node
  std::uint8_t incision = 0;  // of the scene
  std::array<std::uint64_t, 3> lines{};
};

/// Displacement of a copy of a node beside a blade (fragments.hpp), along the lattice's axes [m].
struct VirtualNodeShift {
  Real x = 0, y = 0, z = 0;
};

/// A cell's tissue on one side of a blade. Its corners are slots, or slot_count + number of a copy.
struct CutCellElement {
  std::array<int, 8> corner{};
  Real young = 0;  // of the cell, by the part's share of its volume [Pa]
};
/// A skin triangle on one side of a blade, likewise.
struct CutSkinElement {
  int triangle = 0;
  Int3 corner;     // of its vertices
  Real share = 0;  // of its area
};
/// A node, or a copy of one, that such parts hang on.
struct ElementNode {
  int corner = 0, slot = 0;  // itself; the node that it is or was copied from
  int first = 0, count = 0;  // PartsOfCells::uses
  Vec3 pull;                 // of Skin::pull, more than the node alone has [N]
};
/// Corner `at` of cells[part], or of skin[-1 - part].
struct NodeElement {
  int part = 0, at = 0;
};
/// What cells and skin that blades parted bear (cut_elements.hpp).
struct CutElements {
  std::vector<CutCellElement> cells;
  std::vector<CutSkinElement> skin;
  std::vector<ElementNode> nodes, virtual_nodes;  // slots ascend in both
  std::vector<int> layer_begin;                   // of the copies: size.z + 1 entries
  std::vector<NodeElement> uses;
  std::vector<std::pair<int, std::uint64_t>> places;  // of all copies: by what the next cut knows them again
};

/// Which rows sleep (sleep.hpp). By row of the storage; empty until the first step of a body that can
/// sleep.
struct Sleep {
  std::vector<std::uint8_t> still;  // steps in which nothing near it moved; from kStillSteps on it sleeps
  std::vector<std::uint8_t> awake;  // 1 = is swept in this step
  std::vector<std::uint8_t> moved;  // 1 = a node of it has moved in this step
  std::size_t cuts = 0;             // edges that were cut when it was looked at
  Vec3d gravity;                    // that it has come to rest under [m/s²]
  bool carried = false;             // the coarse space moves all rows in this step
  std::uint8_t coarse_still = 0;    // steps in which all rows slept, as `still`: then the coarse space sleeps
};

/// What solves for the smooth part of a step's motion (coarse_correction.hpp).
struct CoarseSpace;

/// Room for the forces that a step leaves over, along the lattice's axes: of nodes, two layers at a time of
/// every stretch of layers; of copies, all.
struct ResidualWorkspace {
  std::vector<VecField> layers;                 // by stretch [N]
  std::vector<VirtualNodeShift> virtual_nodes;  // [N]
};

constexpr std::uint8_t kIsCut = 1u << kFamilyCount;

/// What changes.
struct State {
  double time = 0;                       // [s]
  VecField u, u_before, v;               // displacement now and a step ago [m], velocity [m/s]
  Real fastest = 0;                      // largest |v| [m/s]
  aligned_vector<std::uint8_t> cut;      // by slot: bit f = the edge of family f that starts here is cut;
                                         // kParted = the cell that starts here is in `parts` instead
  aligned_vector<std::uint8_t> removed;  // by slot: 1 = left the body (the paper's static incision)
  std::vector<std::uint8_t> row_cut;     // by row: is an edge cut that touches this row or one beside it?
  std::vector<std::uint8_t> skin_cut;    // by skin triangle: 1 = holds no tension
  std::vector<CutEdge> cut_edges;        // in the order they were cut
  std::vector<CutFractionSamples> cut_samples;  // by slot and incision
  int cut_sample_count = 0;                     // in them, in all
  std::vector<VirtualNodeShift> virtual_nodes,
      virtual_nodes_before;  // of nodes beside blades, as make_pieces numbers them
  CutElements parts;         // follows from the cuts
  int removed_nodes = 0;     // how many left the body
  Sleep sleep;
  std::shared_ptr<const CoarseSpace> coarse;  // follows from the cuts and the length of steps
  ResidualWorkspace residual_forces;          // room to work in
  std::size_t cuts_before = 0;                // cut_version a step ago
  int steps_since_cut = 0;
  std::bitset<256> blades_on;  // by incision: its blade is on its way
};

/// Where a state is elsewhere (device_state.hpp): brings places and velocities of these nodes, ascending,
/// into it. Null: all are here.
using DownloadNodes = std::function<void(std::span<const int>)>;

/// A force from outside on one node, for the length of a step. Fixed and removed nodes do not feel it.
struct NodeLoad {
  int slot = 0;
  Vec3 force;  // along the lattice's axes [N]
};

/// Something rigid at a node, for the length of a step: the node stays beyond a plane, with Coulomb's
/// friction on it, or goes along with what holds it. Or not the node does, but the place halfway to a
/// neighbour, which has the same contact with it.
struct NodeContact {
  int slot = 0;
  int other = -1;        // slot of that neighbour
  Vec3 normal;           // unit, from the plane at the node, along the lattice's axes
  Vec3 target;           // displacement at which the node lies on the plane and sticks to it [m]
  Real friction = 0;     // Coulomb's μ [1]
  bool is_held = false;  // stays at `target`, pulled if need be
  Vec3 force;            // on the node: a guess before a step, the answer after it [N]
  Real stiffness = 0;    // of the last sweep's penalty [N/m]
};

struct HaloExchange;
struct Inputs {
  Vec3d gravity;                       // patient frame [m/s²]
  bool measure_residual = false;       // descent only; costs about two sweeps
  std::span<const NodeLoad> loads;     // those of one node add up
  std::span<NodeContact> contacts;     // descent only; slots ascend
  const HaloExchange* halo = nullptr;  // who holds the layers of the body that are not the model's own
};

/// How far a step is from the minimum of its energy: forces left over at the free nodes [N].
struct Residual {
  double largest = 0, rms = 0;
  double before = 0;  // rms before the first sweep: rms/before is what the sweeps of one step leave of it [N]
};

struct StepReport {
  bool finite = true;      // false: the step was undone
  Real largest_speed = 0;  // [m/s]
  Residual residual;       // when asked for; pbd minimises nothing and has none
  int rows = 0;            // of the lattice, with something that can move; 0 when none may sleep
  int rows_asleep = 0;     // of these
};

/// What may come beside a CT, on the same patient; null = absent.
struct BodyFields {
  const LabelVolume* labels = nullptr;  // a segmentation, for TissueParams::young_of_label
  const VectorVolume* lines = nullptr;  // Langer's lines, instead of SkinParams::direction
};

/// Body from a CT. Errors: nothing but air, a body without skin where skin is asked for, fields off the CT.
Result<Model> build(const Exec& exec, const CtVolume& ct, const BodyFields& fields, const Params& params);
State make_state(const Model& model);
StepReport step(const Exec& exec, const Model& model, State& state, const Inputs& inputs, double dt);

/// Elastic energy of springs, volumes and skin [J].
double energy(const Exec& exec, const Model& model, const State& state);
/// Memory of a model and its state while it runs.
std::size_t memory_bytes(const Model& model, const State& state);
/// Equal for equal displacements, velocities, cuts and removed nodes, whatever the number of threads.
std::uint64_t state_hash(const Model& model, const State& state);
/// Of the own layers alone, without copies, continued from those below.
std::uint64_t hash_of_layers(const Model& model, const State& state, std::uint64_t hash);

/// Place of a node now, along the lattice axes from its first node [m].
inline Vec3 position(const Model& model, const State& state, Int3 node) {
  return rest_position(model.lattice, node) + state.u[std::size_t(node_slot(model.lattice, node))];
}
/// Is a node tissue now, neither outside nor removed?
inline bool is_solid(const Model& model, const State& state, int slot) {
  return model.tissue[std::size_t(slot)] != Tissue::kOutside && state.removed[std::size_t(slot)] == 0;
}
/// Grows with every cut: what was made of the cuts is to be made anew when it has changed.
inline std::size_t cut_version(const State& state) {
  return state.cut_edges.size() + std::size_t(state.cut_sample_count) + std::size_t(state.removed_nodes);
}
inline bool is_body(Tissue t) { return t != Tissue::kOutside; }

}  // namespace turgor::lattice
