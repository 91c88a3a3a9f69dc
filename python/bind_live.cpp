// Views of a body's own memory: nothing is copied, a view keeps its world, and what a step changes is seen in
// it. Only arrays that stay where they are in memory as long as their world are shown so.
#include <nanobind/stl/string.h>

#include "bindings.hpp"

namespace turgor {

using namespace nb::literals;

namespace {

struct LiveBody {
  PyBody body;
};
/// Three scalars a node, each in an array of its own.
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
        (live.body.name + ": " + name + " is of bodies with model = \"lattice\"").c_str());
  return live.body.world->world().lattice_bodies[std::size_t(live.body.id.index)];
}
ClothBody& cloth_of(const LiveBody& live, const char* name) {
  if (live.body.id.kind != BodyKind::kCloth)
    throw nb::attribute_error(
        (live.body.name + ": " + name + " is of bodies with model = \"cloth\"").c_str());
  return live.body.world->world().cloth_bodies[std::size_t(live.body.id.index)];
}

/// [k, j, parity, i // 2]
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
        (live.body.name + ": rest_vertices is of bodies with model = \"sfem\" or \"rhombus\"").c_str());
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
      "Vectors as the engine has them: the parts along x, y and z, each an array of its own. Views "
      "that may be written; they keep their world.")
      .def_prop_ro("x", axis(0), kView)
      .def_prop_ro("y", axis(1), kView)
      .def_prop_ro("z", axis(2), kView);
  nb::class_<LiveBody>(
      module, "LiveBody",
      "Views of a body's own memory. What is written into them is what the next step begins with.")
      .def_prop_ro("rest_vertices", &rest_vertices, kView,
                   "(n, 3) vertices of the model's mesh at rest [m], sfem and rhombus; read-only")
      .def_prop_ro(
          "u",
          [](const LiveBody& l) {
            LatticeBody& body = lattice_of(l, "u");
            return of_nodes(l.body, body.model.lattice, body.state.watch().u);
          },
          "lattice: displacements [k, j, parity, i // 2] along the lattice's own axes [m]; of a row with an "
          "odd number "
          "of nodes the last odd one is no node")
      .def_prop_ro(
          "v",
          [](const LiveBody& l) {
            LatticeBody& body = lattice_of(l, "v");
            return of_nodes(l.body, body.model.lattice, body.state.watch().v);
          },
          "lattice: velocities, likewise [m/s]")
      .def_prop_ro(
          "x",
          [](const LiveBody& l) {
            ClothBody& body = cloth_of(l, "x");
            return live_vectors(l.body, body.state.watch().x, 0, {std::size_t(body.model.count)}, {1});
          },
          "cloth: places (n,) in the model's numbering [m]")
      .def_prop_ro(
          "original",
          [](const LiveBody& l) {
            const ClothBody& body = cloth_of(l, "original");
            return nb::ndarray<nb::numpy, const int>(body.model.original.data(), {body.model.original.size()},
                                                     l.body.owner);
          },
          kView, "cloth: (n,) vertex of the mesh of each vertex of the model; read-only");
  module.def(
      "live_of", [](const PyBody& body) { return LiveBody{body}; }, "body"_a);
}

}  // namespace turgor
