// Laws that change after a body was built: the model is that of a body built with them.
#include "turgor/models/lattice/build/change_tissue.hpp"

#include <algorithm>
#include <functional>

#include <gtest/gtest.h>

#include "tests/models/lattice/ct_body.hpp"
#include "tests/models/lattice/wounded_block.hpp"
#include "turgor/models/lattice/build/scale_stiffness.hpp"
#include "turgor/models/lattice/lattice.hpp"
#include "turgor/models/lattice/mechanics/solid_laws.hpp"

namespace turgor::lattice {
namespace {

const Exec kTwo(2);

/// Layers by depth and label in an exponential body with fibers, relaxation and a label's modulus.
TissueParams rich_tissue() {
  TissueParams tissue;
  tissue.law = TissueLaw::kSolid;
  tissue.energy = SolidEnergy::kExponential;
  tissue.stiffening = 3;
  tissue.fiber = {2e3, 2, {0, 1, 0}};
  tissue.layers = {{.name = "upper", .thickness = 0.004, .young = 9e3, .poisson = 0.3, .stiffening = 1},
                   {.name = "organ", .young = 5e3, .poisson = 0.4, .stiffening = 6}};
  tissue.layers[1].label = 1;
  tissue.layers[1].prony = one_pair(0.7, 0.3);
  tissue.prony = one_pair(0.4, 0.1);
  tissue.young_of_label = {{2, 3e3}};
  return tissue;
}

/// A cylinder with two labels, held at its ends.
Model cylinder_model(const TissueParams& tissue) {
  const CtVolume ct = make_ct({24, 24, 36}, [](Vec3d p) { return norm(Vec3d{p.x - 12, p.y - 12, 0}) < 10; });
  LabelVolume labels;
  labels.grid = ct.grid, labels.samples.assign(ct.samples.size(), 0);
  for_voxels(ct.grid, [&](Int3 p) { labels.at(p.x, p.y, p.z) = p.x < 11 ? 1 : p.y < 9 ? 2 : 0; });
  Params params;
  params.block = {3, 3, 3};
  params.fix_ends = true;
  params.skin.enabled = false;
  params.tissue = tissue;
  params.solver.sweeps = 6;
  return build(kTwo, ct, {.labels = &labels}, params).value();
}

void expect_equal_models(const Model& a, const Model& b, const std::string& what) {
  EXPECT_EQ(a.params.tissue, b.params.tissue) << what;
  EXPECT_EQ(a.anatomy.cell_young, b.anatomy.cell_young) << what;
  EXPECT_EQ(a.anatomy.cell_center, b.anatomy.cell_center) << what;
  EXPECT_EQ(a.springs.root_stiffness, b.springs.root_stiffness) << what;
  EXPECT_EQ(a.springs.scale, b.springs.scale) << what;
  EXPECT_EQ(a.vbd.incident_elements, b.vbd.incident_elements) << what;
  const CellLaws &of = a.anatomy.cell_laws, &other = b.anatomy.cell_laws;
  EXPECT_EQ(of.shear, other.shear) << what;
  EXPECT_EQ(of.bulk, other.bulk) << what;
  EXPECT_EQ(of.stiffening, other.stiffening) << what;
  EXPECT_EQ(of.fiber, other.fiber) << what;
  EXPECT_EQ(of.fiber_stiffening, other.fiber_stiffening) << what;
  EXPECT_EQ(of.fiber_y, other.fiber_y) << what;
  EXPECT_EQ(of.relaxation, other.relaxation) << what;
}

// Every parameter of a law changes the model to the bits of a body that was built with the new value.
TEST(LatticeChangeTissue, ChangedModelEqualsBuiltModel) {
  using Change = std::pair<const char*, std::function<void(TissueParams&)>>;
  const Change changes[] = {
      {"fat", [](TissueParams& t) { t.fat = 900; }},
      {"muscle", [](TissueParams& t) { t.muscle = 3e4; }},
      {"poisson", [](TissueParams& t) { t.poisson = 0.2; }},
      {"stiffening", [](TissueParams& t) { t.stiffening = 11; }},
      {"fiber",
       [](TissueParams& t) {
         t.fiber = {5e3, 1, {1, 0, 0}};
       }},
      {"no fiber", [](TissueParams& t) { t.fiber.stiffness = 0; }},
      {"label", [](TissueParams& t) { t.young_of_label[2] = 7e3; }},
      {"thickness", [](TissueParams& t) { t.layers[0].thickness = 0.007; }},
      {"slide", [](TissueParams& t) { t.layers[0].slide = 0.1; }},
      {"organ", [](TissueParams& t) { t.layers[1].young = 1e4, t.layers[1].stiffening = 2; }},
      {"pairs", [](TissueParams& t) { t.prony = one_pair(1, 0.2), t.layers[1].prony.reset(); }},
      {"elastic", [](TissueParams& t) { t.prony = {}, t.layers[1].prony = Prony{}; }},
  };
  for (const auto& [what, change] : changes) {
    TissueParams wanted = rich_tissue();
    change(wanted);
    Model model = cylinder_model(rich_tissue());
    State state = make_state(model);
    EXPECT_EQ(reachable_tissue(wanted, model), wanted) << what;
    change_tissue(kTwo, wanted, 1.5, model, state);
    Model built = cylinder_model(wanted);
    scale_moduli(1.5, built);
    expect_equal_models(model, built, what);
  }
  // springs
  TissueParams springs;
  Model model = cylinder_model(springs);
  State state = make_state(model);
  springs.volume = 2, springs.muscle = 5e3;
  change_tissue(kTwo, springs, 1, model, state);
  expect_equal_models(model, cylinder_model(springs), "springs");
}

// Partial cells keep their filled fractions. They do not get laws by cell, which need whole cells.
TEST(LatticeChangeTissue, PartialCellsKeepFractions) {
  TissueParams tissue;
  tissue.law = TissueLaw::kSolid;
  tissue.partial_cells = true;
  tissue.young_of_label = {{2, 3e3}};
  Model model = cylinder_model(tissue);
  State state = make_state(model);
  tissue.muscle = 3e4, tissue.poisson = 0.2, tissue.young_of_label[2] = 7e3;
  EXPECT_EQ(reachable_tissue(tissue, model), tissue);
  change_tissue(kTwo, tissue, 1.5, model, state);
  Model built = cylinder_model(tissue);
  scale_moduli(1.5, built);
  expect_equal_models(model, built, "partial cells");
  tissue.muscle = 2e4;
  change_tissue(kTwo, tissue, 0.7, model, state);
  built = cylinder_model(tissue);
  scale_moduli(0.7, built);
  expect_equal_models(model, built, "changed again, from scaled moduli");
  const auto& center = model.anatomy.cell_center;
  EXPECT_TRUE(std::any_of(center.begin(), center.end(), [](std::uint32_t bits) { return bits != 0; }));
  TissueParams relaxing = tissue;
  relaxing.prony = one_pair(0.4, 0.1);
  EXPECT_EQ(reachable_tissue(relaxing, model), tissue);
}

// A body that gets other laws while it moves reaches the rest of a body that was built with them. Relaxation
// delays that rest and does not move it.
TEST(LatticeChangeTissue, BodySettlesLikeBuiltBody) {
  TissueParams wanted = rich_tissue();
  wanted.stiffening = 9, wanted.muscle = 1e4, wanted.layers[1].young = 2500;
  const auto settle = [](const Model& model, State& state, int frames) {
    for (int n = 0; n < frames; n++) step(kTwo, model, state, {.gravity = {0, -9.81, 0}}, 1.0 / 60);
  };
  Model model = cylinder_model(rich_tissue());
  State state = make_state(model);
  settle(model, state, 20);
  change_tissue(kTwo, wanted, 1, model, state);
  settle(model, state, 90);
  const Model built = cylinder_model(wanted);
  State other = make_state(built);
  settle(built, other, 90);
  // largest displacement, and the largest difference of both
  double largest = 0, apart = 0;
  for (std::size_t n = 0; n < built.anatomy.inverse_mass.size(); n++) {
    largest = std::max(largest, norm(Vec3d(other.motion.u[n])));
    apart = std::max(apart, norm(Vec3d(other.motion.u[n] - state.motion.u[n])));
  }
  EXPECT_GT(largest, 1e-4);
  EXPECT_LT(apart, 2e-3 * largest);
}

// Elements of cut cells follow their cell, so that the force on a body with a wound is that of stiffer
// tissue.
TEST(LatticeChangeTissue, CutCellsFollowTheirCell) {
  Params params = solid_params(10, 4, 45);
  params.tissue.muscle = 5e3;
  Wounded body(0.3, 0.2, 20, params);
  const std::vector<CutCellElement> before = body.state.cut_elements.cells;
  ASSERT_GT(before.size(), 20u);
  TissueParams stiffer = params.tissue;
  stiffer.muscle = 1.5e4;
  change_tissue(kTwo, stiffer, 1, body.model, body.state);
  for (std::size_t n = 0; n < before.size(); n++)
    EXPECT_NEAR(double(body.state.cut_elements.cells[n].young), 3 * double(before[n].young),
                1e-4 * double(before[n].young));
}

// Values that need another body stay: limits of CT values, the kind of law, another number of layers.
TEST(LatticeChangeTissue, OtherBodiesAreOutOfReach) {
  const Model model = cylinder_model(rich_tissue());
  const TissueParams own = rich_tissue();
  TissueParams wanted = own;
  wanted.fat_max = 20, wanted.muscle = 123;
  TissueParams expected = own;
  expected.muscle = 123;
  EXPECT_EQ(reachable_tissue(wanted, model), expected);
  wanted = own, wanted.layers.pop_back();
  EXPECT_EQ(reachable_tissue(wanted, model), own);
  wanted = own, wanted.energy = SolidEnergy::kOgden;
  EXPECT_EQ(reachable_tissue(wanted, model), own);
  wanted = own, wanted.layers[1].label = 2;
  EXPECT_EQ(reachable_tissue(wanted, model), own);
}

}  // namespace
}  // namespace turgor::lattice
