#include "turgor/geometry/organ_mesh.hpp"

#include <numbers>

#include <gtest/gtest.h>

#include "tests/geometry/mesh_checks.hpp"
#include "tests/geometry/shapes.hpp"
#include "tests/refused.hpp"
#include "turgor/geometry/label_measures.hpp"
#include "turgor/geometry/mesh_quality.hpp"
#include "turgor/geometry/phantom.hpp"
#include "turgor/geometry/stuffing.hpp"

namespace turgor {
namespace {

constexpr int kLiver = 5;

LabelVolume torso_labels() {
  PhantomParams params = default_phantom(PhantomKind::kTorso);
  const Int3 size{128, 128, 75};
  for (int axis = 0; axis < 3; axis++) params.spacing[axis] *= double(params.size[axis]) / size[axis];
  params.size = size;
  LabelVolume labels;
  make_phantom(Exec(2), params, &labels);
  return labels;
}

void expect_quality(const SolidMesh& mesh) {
  const MeshQuality quality = measure_quality(mesh);
  EXPECT_GE(quality.min_dihedral, kLeastStuffedDihedral);
  EXPECT_LE(quality.max_dihedral, kLargestStuffedDihedral);
  test::expect_sound(mesh);
  for (const int component : connected_components(mesh)) ASSERT_EQ(component, 0);
}

// A coarse ball keeps the volume of its surface within 2 %.
TEST(OrganMesh, CoarseBallKeepsVolume) {
  const TriMesh ball = test::sphere_surface({0.1, 0, 0}, 0.04, 4);
  for (const double size : {0.03, 0.02, 0.008}) {
    const auto organ = mesh_of_surface(Exec(2), ball, size);
    ASSERT_TRUE(organ) << organ.error().message;
    EXPECT_NEAR(organ->input_volume, 4 * std::numbers::pi / 3 * 6.4e-5, 4e-6);
    EXPECT_NEAR(volume(organ->mesh), organ->input_volume, 0.02 * organ->input_volume) << size;
    EXPECT_TRUE(organ->notes.empty()) << organ->notes[0];
    expect_quality(organ->mesh);
  }
}

// The phantom's liver keeps its volume within 2 %, and its nodule becomes a region.
TEST(OrganMesh, PhantomLiverKeepsVolumeAndNodule) {
  const LabelVolume labels = torso_labels();
  const int wanted[] = {kLiver, kNoduleLabel};
  const auto organ = mesh_of_labels(Exec(2), labels, wanted, 0.012);
  ASSERT_TRUE(organ) << organ.error().message;
  EXPECT_NEAR(volume(organ->mesh), organ->input_volume, 0.02 * organ->input_volume);
  expect_quality(organ->mesh);
  double nodule = 0, known = 0;
  for (std::size_t e = 0; e < element_count(organ->mesh); e++)
    if (region(organ->mesh, e) == kNoduleLabel) nodule += volume(organ->mesh, e);
  for (const LabelMeasure& m : measure_labels(labels, nullptr))
    if (m.label == kNoduleLabel) known = m.volume;
  EXPECT_GT(known, 0);
  EXPECT_NEAR(nodule, known, 0.3 * known);
  for (const std::string& note : organ->notes) EXPECT_EQ(note.find("cavities"), std::string::npos) << note;
  RecordProperty("elements", int(element_count(organ->mesh)));
}

// A liver is solid where it encloses its nodule, and a note names the label. On request it is hollow there.
TEST(OrganMesh, CavityIsFilledAndNoted) {
  const int liver[] = {kLiver}, both[] = {kLiver, kNoduleLabel};
  const auto solid = mesh_of_labels(Exec(2), torso_labels(), liver, 0.018);
  ASSERT_TRUE(solid) << solid.error().message;
  ASSERT_FALSE(solid->notes.empty());
  EXPECT_NE(solid->notes.back().find("its own tissue where it encloses other labels (200, "),
            std::string::npos)
      << solid->notes.back();
  const auto named = mesh_of_labels(Exec(2), torso_labels(), both, 0.018);
  ASSERT_TRUE(named) << named.error().message;
  EXPECT_EQ(solid->mesh.vertices.size(), named->mesh.vertices.size());
  EXPECT_EQ(solid->input_volume, named->input_volume);
  EXPECT_EQ(std::count(solid->mesh.regions.begin(), solid->mesh.regions.end(), kLiver),
            std::ptrdiff_t(element_count(solid->mesh)));
  // cavities are kept on request, and where another body is
  for (const Cavities& cavities : {Cavities{.are_filled = false, .kept_out = {}},
                                   Cavities{.are_filled = true, .kept_out = {kNoduleLabel}}}) {
    const auto hollow = mesh_of_labels(Exec(2), torso_labels(), liver, 0.018, {}, Sides::kFlat, {}, cavities);
    ASSERT_TRUE(hollow) << hollow.error().message;
    EXPECT_LT(hollow->input_volume, solid->input_volume - 5e-6);
    if (!cavities.are_filled) {
      EXPECT_NE(hollow->notes.back().find("the body is hollow where it encloses other labels (200, "),
                std::string::npos)
          << hollow->notes.back();
    }
  }
}

// The error for a body too small for the lattice suggests a spacing that works.
TEST(OrganMesh, TooSmallBody_SuggestsSpacing) {
  const TriMesh ball = test::sphere_surface({}, 0.005, 3);
  const auto coarse = mesh_of_surface(Exec(1), ball, 0.012);
  ASSERT_FALSE(coarse);
  EXPECT_EQ(
      coarse.error().message,
      "the body has 0.519 mL (10 mm x 10 mm x 10 mm): too small for a lattice of 12 mm; 1 mm would suffice");
  EXPECT_TRUE(mesh_of_surface(Exec(1), ball, 0.001));
}

// A body that is small for the size gets a smaller one, and keeps its volume.
TEST(OrganMesh, SmallBody_GetsEnoughEdges) {
  const TriMesh ball = test::sphere_surface({}, 0.02, 3);
  const MeshBound bound{.edges = 5, .begin = {}};
  const auto organ = mesh_of_surface(Exec(1), ball, 0.02, {}, Sides::kFlat, bound);
  ASSERT_TRUE(organ) << organ.error().message;
  ASSERT_EQ(organ->notes.size(), 1u);
  EXPECT_NE(organ->notes[0].find("edges of 6.4 mm"), std::string::npos) << organ->notes[0];
  EXPECT_NEAR(volume(organ->mesh), organ->input_volume, 0.02 * organ->input_volume);
  const auto given = mesh_of_surface(Exec(1), ball, 0.006, {}, Sides::kFlat, bound);
  ASSERT_TRUE(given) << given.error().message;
  EXPECT_TRUE(given->notes.empty());
}

// A small fold of the surface is noted; the mesh is sound.
TEST(OrganMesh, SmallFoldIsNotedAndRepaired) {
  TriMesh ball = test::sphere_surface({}, 0.04, 4);
  std::swap(ball.vertices[std::size_t(ball.triangles[500].x)],
            ball.vertices[std::size_t(ball.triangles[500].y)]);
  const auto organ = mesh_of_surface(Exec(2), ball, 0.012);
  ASSERT_TRUE(organ) << organ.error().message;
  ASSERT_EQ(organ->notes.size(), 1u);
  EXPECT_NE(organ->notes[0].find("crosses itself"), std::string::npos) << organ->notes[0];
  EXPECT_NEAR(volume(organ->mesh), 4 * std::numbers::pi / 3 * 6.4e-5, 6e-6);
  expect_quality(organ->mesh);
}

// A surface that encloses a large volume twice is rejected.
TEST(OrganMesh, RejectsDoublyEnclosedSurface) {
  const auto meshed = mesh_of_surface(Exec(2), test::coil_surface(0.05, 0.005, 0.02), 0.01);
  ASSERT_FALSE(meshed);
  EXPECT_NE(meshed.error().message.find("expected a surface with a single interior"), std::string::npos)
      << meshed.error().message;
}

// A plate much thinner than the lattice is rejected.
TEST(OrganMesh, RejectsPlateThinnerThanLattice) {
  const TriMesh plate = test::box_surface({0.2, 0.2, 0.002});
  const auto meshed = mesh_of_surface(Exec(1), plate, 0.02);
  ASSERT_FALSE(meshed);
  EXPECT_NE(meshed.error().message.find("too coarse for this shape"), std::string::npos)
      << meshed.error().message;
}

// A surface in millimeters is rejected before memory is allocated.
TEST(OrganMesh, RejectsMillimeters) {
  const auto meshed = mesh_of_surface(Exec(1), test::box_surface({200, 150, 100}), 0.008);
  ASSERT_FALSE(meshed);
  EXPECT_NE(meshed.error().message.find("Are the coordinates in meters"), std::string::npos)
      << meshed.error().message;
}

// The forecast comes before the work and is close to the number of elements.
TEST(OrganMesh, ForecastPredictsElements) {
  MeshForecast expected;
  double done = -1, done_at_forecast = 1;
  const Progress progress = [&](double fraction) { done = std::max(done, fraction); };
  const MeshBound bound{
      .begin = [&](const MeshForecast& forecast) { expected = forecast, done_at_forecast = done; }};
  const auto organ = mesh_of_surface(Exec(1), test::sphere_surface({0.1, 0, 0}, 0.04, 4), 0.004, progress,
                                     Sides::kFlat, bound);
  ASSERT_TRUE(organ) << organ.error().message;
  EXPECT_EQ(done_at_forecast, -1) << "before the work";
  EXPECT_GE(done, 0.5);
  EXPECT_NEAR(expected.elements / double(element_count(organ->mesh)), 1, 0.15);
  EXPECT_GT(expected.seconds, 0);
}

// A mesh with more elements than its bound is refused before its distances are computed.
TEST(OrganMesh, RefusesMoreThanBound) {
  const MeshBound bound{.elements = 1000, .begin = [](const MeshForecast&) { ADD_FAILURE() << "it began"; }};
  EXPECT_REFUSED(
      mesh_of_surface(Exec(1), test::sphere_surface({0.1, 0, 0}, 0.04, 4), 0.004, {}, Sides::kFlat, bound),
      "gives about", "tetrahedra; expected at most 1000, as ", " would suffice");
}

}  // namespace
}  // namespace turgor
