// Zero-copy views of a body's memory. A view keeps its world alive and shows later changes. Only arrays that
// never move in memory have views.
#include <nanobind/stl/string.h>

#include "bindings.hpp"

namespace turgor {

using namespace nb::literals;

namespace {

struct LiveBody {
  PyBody body;
};
/// Vectors with one array per component.
struct LiveVectors {
  nb::object owner;
  float* axis[3] = {};
  std::vector<std::size_t> shape;
  std::vector<std::int64_t> strides;
};

template <class Vectors>
LiveVectors live_vectors(const PyBody& body, Vectors& values, std::size_t first,
                         std::vector<std::size_t> shape, std::vector<std::int64_t> strides) {
  body.world->expect_writers();
  return {body.owner,
          {values.x.data() + first, values.y.data() + first, values.z.data() + first},
          std::move(shape),
          std::move(strides)};
}

LatticeBody& lattice_of(const LiveBody& live, const char* name) {
  if (live.body.id.kind != BodyKind::kLattice)
    throw nb::attribute_error(
        (live.body.name + ": " + name + " needs a body with model = \"lattice\"").c_str());
  return live.body.world->world().lattice_bodies[std::size_t(live.body.id.index)];
}
ClothBody& cloth_of(const LiveBody& live, const char* name) {
  if (live.body.id.kind != BodyKind::kCloth)
    throw nb::attribute_error(
        (live.body.name + ": " + name + " needs a body with model = \"cloth\"").c_str());
  return live.body.world->world().cloth_bodies[std::size_t(live.body.id.index)];
}

/// Node array indexed [k, j, parity, i // 2].
template <class Values>
LiveVectors of_nodes(const PyBody& body, const Lattice& l, Values& values) {
  return live_vectors(body, values, std::size_t(row_slot(l, 0, 0)),
                      {std::size_t(l.size.z), std::size_t(l.size.y), 2, std::size_t(half_count(l, 0))},
                      {layer_stride(l), row_stride(l), l.half, 1});
}

nb::ndarray<nb::numpy, const double> rest_vertices(const LiveBody& live) {
  const World& world = live.body.world->world();
  const auto index = std::size_t(live.body.id.index);
  const std::vector<Vec3d>* points = nullptr;
  if (live.body.id.kind == BodyKind::kSfem) points = &world.sfem_bodies[index].model.body.mesh.vertices;
  if (live.body.id.kind == BodyKind::kRhombus) points = &world.rhombus_bodies[index].model.surface.vertices;
  if (!points)
    throw nb::attribute_error(
        (live.body.name + ": rest_vertices needs a body with model = \"sfem\" or \"rhombus\"").c_str());
  static_assert(sizeof(Vec3d) == 3 * sizeof(double));
  return {&points->data()->x, {points->size(), 3}, live.body.owner};
}

}  // namespace

void bind_live(nb::module_& module) {
  constexpr auto kView = nb::rv_policy::reference;
  const auto axis = [](int a) {
    return [a](const LiveVectors& v) {
      return nb::ndarray<nb::numpy, float>(v.axis[a], v.shape.size(), v.shape.data(), v.owner,
                                           v.strides.data());
    };
  };
  nb::class_<LiveVectors>(
      module, "LiveVectors",
      "Vectors with one array per component x, y and z. Writable views, which keep their world alive.")
      .def_prop_ro("x", axis(0), kView)
      .def_prop_ro("y", axis(1), kView)
      .def_prop_ro("z", axis(2), kView);
  nb::class_<LiveBody>(module, "LiveBody",
                       "Views of a body's memory. The next step starts from values written into them.")
      .def_prop_ro("rest_vertices", &rest_vertices, kView,
                   "(n, 3) vertices of the model's mesh at rest [m], sfem and rhombus; read-only")
      .def_prop_ro(
          "u",
          [](const LiveBody& l) {
            LatticeBody& body = lattice_of(l, "u");
            return of_nodes(l.body, body.model.anatomy.lattice, body.state.watch().motion.u);
          },
          "lattice: displacements [k, j, parity, i // 2] along the lattice's axes [m]; in rows with an odd "
          "number of nodes the last odd entry is unused")
      .def_prop_ro(
          "v",
          [](const LiveBody& l) {
            LatticeBody& body = lattice_of(l, "v");
            return of_nodes(l.body, body.model.anatomy.lattice, body.state.watch().motion.v);
          },
          "lattice: velocities, in the same layout [m/s]")
      .def_prop_ro(
          "x",
          [](const LiveBody& l) {
            ClothBody& body = cloth_of(l, "x");
            return live_vectors(l.body, body.state.watch().x, 0, {std::size_t(body.model.count)}, {1});
          },
          "cloth: positions (n,) in the model's vertex order [m]")
      .def_prop_ro(
          "original",
          [](const LiveBody& l) {
            const ClothBody& body = cloth_of(l, "original");
            return nb::ndarray<nb::numpy, const int>(body.model.original.data(), {body.model.original.size()},
                                                     l.body.owner);
          },
          kView, "cloth: (n,) mesh vertex of each model vertex; read-only");
  module.def(
      "live_of", [](const PyBody& body) { return LiveBody{body}; }, "body"_a);
}

}  // namespace turgor
