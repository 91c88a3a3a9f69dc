// Collision detection by the device loops against the CCD of the CPU.
#include "tests/models/cloth/meshes.hpp"
#include "tests/models/cloth/on_host.hpp"
#include "turgor/models/cloth/ccd/ccd.hpp"
#include "turgor/models/lattice/lattice.hpp"

namespace turgor::cloth {
namespace {

using Backend = lattice::HostBackend<lattice::ThreadedRun<2>>;
const Exec kOne(1);

/// Two sheets, one above the other.
Model two_layers(Real apart) {
  Params params;
  params.collision.self = true, params.collision.thickness = 0.0003;
  TriMesh mesh = rectangle(Pattern::kDiagonal, 0, 0.1, 0.1, 0.01);
  const TriMesh below = mesh;
  const auto first = int(mesh.vertices.size());
  for (const Vec3 p : below.vertices) mesh.vertices.push_back(p + Vec3{0, 0, apart});
  for (const Int3 t : below.triangles) mesh.triangles.push_back(t + Int3{first, first, first});
  return must_build(mesh, params);
}
/// A step that displaces all vertices, or every n-th one, at random.
State displaced(const Model& model, double displacement, unsigned seed, int every) {
  State state = make_state(model);
  state.system.previous = state.x;
  Vectors displaced = state.x;
  shake(model, displaced, displacement, seed);
  for (auto v = int(seed); v < model.count; v += every)
    state.x.set(std::size_t(v), displaced[std::size_t(v)]);
  state.ccd.steps_until_check = -1;
  return state;
}

/// Number of vertex pairs that CCD examines.
int pairs_of(const Model& model, State& state, const DeviceTriangles<Backend>& triangles) {
  CcdView g{ccd_motion(view(model, state)), view(model.x_rest), model.triangles.data(), triangles.around()};
  int count = 0;
  for (int i = 0; i < model.count; i++)
    for (int j = i + 1; j < model.count; j++) {
      const PairTest pair{g};
      count += pair.come_near(i, j) && !pair.unfold(i, j);
    }
  return count;
}

// The device detects a collision exactly if the CPU does, also if its list of pairs overflows.
TEST(ClothDeviceCcd, DetectionMatchesCpu) {
  int outcomes[2][2] = {};  // counts by overflow of the list of pairs, and by the result
  for (const Real layer : {0.004f, 0.0004f})
    for (const double displacement : {1e-4, 4e-4, 1e-3, 3e-3, 0.01, 0.05})
      for (unsigned seed = 1; seed <= 6; seed++) {
        const Model model = two_layers(layer);
        State state = displaced(model, displacement, seed, seed % 2 == 0 ? 1 : 50), in_impact_zone = state;
        DeviceAllocator<Backend> allocator;
        const DeviceTriangles<Backend> triangles(allocator, model);
        DeviceCcd<Backend> guard(allocator, model);
        const bool detected =
            guard.any_collision(Backend::Run{}, view(model, state), triangles.corners.data(),
                                triangles.around(), model.params.collision.thickness);
        EXPECT_EQ(detected, resolve_ccd(kOne, model, in_impact_zone) > 0)
            << layer << ' ' << displacement << ' ' << seed;
        outcomes[pairs_of(model, state, triangles) > model.count][detected]++;
      }
  for (const auto& [no, yes] : outcomes) {
    EXPECT_GT(no, 0) << "without collision";
    EXPECT_GT(yes, 0) << "with collision";
  }
}

}  // namespace
}  // namespace turgor::cloth
