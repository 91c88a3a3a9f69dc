// Whether anything of a sheet would meet, by the loops that a GPU runs, against what the CPU catches.
#include "tests/models/cloth/meshes.hpp"
#include "tests/models/cloth/on_host.hpp"

namespace turgor::cloth {
namespace {

using Side = lattice::HostSide<lattice::ThreadedRun<2>>;
const Exec kOne(1);

/// Two sheets of which one lies above the other.
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
/// A step throws its vertices about, all or one of so many.
State thrown(const Model& model, double way, unsigned seed, int every) {
  State state = make_state(model);
  state.system.before = state.x;
  Vectors thrown = state.x;
  shake(model, thrown, way, seed);
  for (auto v = int(seed); v < model.count; v += every) state.x.set(std::size_t(v), thrown[std::size_t(v)]);
  state.ccd.steps_to_look = -1;
  return state;
}

/// Pairs of vertices that the guard looks at.
int pairs_of(const Model& model, State& state, const DeviceTriangles<Side>& triangles) {
  CcdView g{view(model, state), model.triangles.data(), triangles.around()};
  int count = 0;
  for (int i = 0; i < model.count; i++)
    for (int j = i + 1; j < model.count; j++) {
      const PairLook pair{g};
      count += pair.come_near(i, j) && !pair.unfold(i, j);
    }
  return count;
}

TEST(cloth_guard_on, says_what_the_cpu_catches_of_few_pairs_and_of_more_than_it_has_room_for) {
  int told[2][2] = {};  // by whether the list was too short, and by what is said
  for (const Real layer : {0.004f, 0.0004f})
    for (const double way : {1e-4, 4e-4, 1e-3, 3e-3, 0.01, 0.05})
      for (unsigned seed = 1; seed <= 6; seed++) {
        const Model model = two_layers(layer);
        State state = thrown(model, way, seed, seed % 2 == 0 ? 1 : 50), in_impact_zone = state;
        DeviceAllocator<Side> rooms;
        const DeviceTriangles<Side> triangles(rooms, model);
        DeviceCcd<Side> guard(rooms, model);
        const bool says = guard.would_meet(Side::Run{}, view(model, state), triangles.corners.data(),
                                           triangles.around(), model.params.collision.thickness);
        EXPECT_EQ(says, resolve_ccd(kOne, model, in_impact_zone) > 0) << layer << ' ' << way << ' ' << seed;
        told[pairs_of(model, state, triangles) > model.count][says]++;
      }
  for (const auto& [no, yes] : told) {
    EXPECT_GT(no, 0) << "quiet ones";
    EXPECT_GT(yes, 0) << "ones that meet";
  }
}

}  // namespace
}  // namespace turgor::cloth
