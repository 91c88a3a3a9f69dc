// Contacts of pairs that collide in a step.
#include "tests/models/cloth/sheets.hpp"
#include "turgor/models/cloth/ccd/ccd.hpp"
#include "turgor/models/cloth/contact/contact.hpp"

namespace turgor::cloth {
namespace {

// A sheet falls through another one that lies still, 30 mm below. The contacts have the direction of the
// fall, and their gap is what the sheets may still approach, at any distance.
TEST(ClothCcdContacts, NormalAndGapAreThoseOfTheFall) {
  constexpr double kSheetThickness = 0.004, kDistance = 0.03;
  TriMesh mesh = flat_sheet(4);
  const TriMesh upper = flat_sheet(3);
  const int first = int(mesh.vertices.size());
  for (const Vec3 x : upper.vertices) mesh.vertices.push_back(x + Vec3{0.004f, 0.003f, Real(kDistance)});
  for (const Int3 t : upper.triangles) mesh.triangles.push_back(t + Int3{first, first, first});
  Params params;
  params.collision.thickness = kSheetThickness;
  const Model model = must_build(mesh, params);
  State state = make_state(model);
  const Vectors start = state.x;
  state.system.previous = start;
  std::vector<Contact> found;
  // a fall that ends above the lower sheet, then one that ends below it
  const auto fall = [&](double by) {
    for (std::size_t v = 0; v < std::size_t(model.count); v++)
      state.x.z[v] = start.z[v] - (start.z[v] > 0 ? Real(by) : 0);
    return find_collisions(Exec(1), model, state);
  };
  EXPECT_FALSE(fall(0.9 * kDistance));
  ASSERT_TRUE(fall(2 * kDistance));
  find_collision_contacts(model, state, start, found);
  EXPECT_GE(found.size(), upper.vertices.size());
  for (const Contact& c : found) {
    EXPECT_NEAR(std::abs(c.normal.z), 1, 1e-4);
    EXPECT_NEAR(c.gap, kDistance - kSheetThickness, 1e-5);
    EXPECT_NEAR(c.weight[0] + c.weight[1] + c.weight[2] + c.weight[3], 0, 1e-6);
  }
}

}  // namespace
}  // namespace turgor::cloth
