// The actual search of a step, which tests the pairs of the predicted one, against a search of its own.
#include <algorithm>

#include "tests/models/cloth/meshes.hpp"
#include "tests/models/cloth/sheets.hpp"
#include "turgor/models/cloth/contact/contact.hpp"

namespace turgor::cloth {
namespace {

constexpr double kLayer = 0.004;  // thickness [m]

/// Two random sheets, one above the other, with a fold in the upper one.
TriMesh two_layers() {
  TriMesh mesh = rectangle(Pattern::kRandom, 0, 0.1, 0.1, 0.01);
  const int lower = int(mesh.vertices.size());
  const TriMesh upper = rectangle(Pattern::kEquilateral, 0.003, 0.093, 0.09, 0.009);
  for (const Vec3 x : upper.vertices) mesh.vertices.push_back(x + Vec3{0, 0, 0.05f});
  for (const Int3 t : upper.triangles) mesh.triangles.push_back(t + Int3{lower, lower, lower});
  return mesh;
}

/// Vertices of the contacts of an actual search, sorted.
std::vector<std::array<int, 4>> actual_contacts(const Model& model, State& state, int threads) {
  std::vector<std::vector<Contact>> found;
  find_step_contacts(Exec(threads), model, state, {}, ContactPhase::kActual, kFrame, found);
  std::vector<std::array<int, 4>> vertices;
  for (const auto& chunk : found)
    for (const Contact& c : chunk) vertices.push_back(c.vertex);
  std::sort(vertices.begin(), vertices.end());
  return vertices;
}

// With slow layers the pairs of the predicted search are enough; with fast ones the search is made again.
TEST(ClothContactFind, ActualSearchMayTestPredictedPairs) {
  Params params{.fabric = {.law = Law::kSheet}, .solver = {.method = Method::kTwoLevel}};
  params.collision.thickness = kLayer;
  const TriMesh mesh = two_layers();
  const Model model = must_build(mesh, params);
  for (const double speed : {0.0, 0.03, 0.1}) {
    State state = make_state(model);
    for (std::size_t v = 0; v < mesh.vertices.size(); v++) {
      Real& z = state.x.z[std::size_t(model.model_vertex[v])];
      if (z > 0) z = Real(0.9 * kLayer + 0.01 * std::abs(double(mesh.vertices[v].x) - 0.05));
    }
    shake(model, state.x, 3e-4);
    std::vector<std::vector<Contact>> predicted;
    find_step_contacts(Exec(1), model, state, {}, ContactPhase::kPredicted, kFrame, predicted);
    // velocities of the solution
    shake(model, state.v, speed, 2);
    state.largest_speed = Real(1.8 * speed);
    State other = state;
    other.contacts.near_reach = 0;  // searches itself
    const auto wanted = actual_contacts(model, other, 1);
    EXPECT_GT(wanted.size(), 50u);
    EXPECT_EQ(actual_contacts(model, state, 2), wanted) << speed << " m/s";
    EXPECT_EQ(state.contacts.near_reach, 0) << "the pairs are those of one step";
  }
}

}  // namespace
}  // namespace turgor::cloth
