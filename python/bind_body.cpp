// Body of a world in its present state. Arrays are copies.
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>

#include "bindings.hpp"

namespace turgor {

using namespace nb::literals;

BodyId named_body(const PyWorld& world, const std::string& name) {
  std::optional<BodyId> found;
  for_each_body(world.world(), [&](BodyId id, const auto& body) {
    if (body.name == name) found = id;
  });
  if (!found) throw nb::key_error(("the scene has no body " + name).c_str());
  return *found;
}

namespace {

PyBody find_body(nb::object owner, const std::string& name) {
  auto& world = nb::cast<PyWorld&>(owner);
  return {owner, &world, named_body(world, name), name};
}

const BodySnapshot& snapshot_of(const PyBody& body) { return body_snapshot(body.world->snapshot(), body.id); }

/// Samples [k, j, i], spacing [m], origin [m], and directions of i, j, k as columns.
using VolumeFields = std::tuple<Array<std::int16_t>, Array<double>, Array<double>, Array<double>>;
VolumeFields fields_of(CtVolume ct) {
  const Grid& g = ct.grid;
  const Shape kji{std::size_t(g.size.z), std::size_t(g.size.y), std::size_t(g.size.x)};
  std::vector<double> axes;
  for (int row = 0; row < 3; row++)
    for (int column = 0; column < 3; column++) axes.push_back(g.axes.column[column][row]);
  auto spacing = new_array<double>({g.spacing.x, g.spacing.y, g.spacing.z}, 0);
  auto origin = new_array<double>({g.origin.x, g.origin.y, g.origin.z}, 0);
  return {shaped_array(std::move(ct.samples), kji), spacing, origin, new_array(std::move(axes), 3)};
}

const LatticeBody& lattice_of(const PyBody& body) {
  if (body.id.kind != BodyKind::kLattice)
    throw Refused(body.name + ": expected a body with model = \"lattice\", which has a volume, found " +
                  model_name(body.id.kind));
  return body.world->world().lattice_bodies[std::size_t(body.id.index)];
}

VolumeFields deformed_volume(const PyBody& body) {
  const LatticeBody& lattice = lattice_of(body);
  const PyWorld::Entered entered(*body.world);
  CtVolume ct;
  {
    const nb::gil_scoped_release others;
    ct = lattice.state.resample(body.world->exec(), lattice.model, lattice.ct, lattice.ct.grid).ct;
  }
  return fields_of(body.world->as_given(body.name, std::move(ct)));
}

}  // namespace

void bind_body(nb::module_& module) {
  constexpr auto kOwn = nb::rv_policy::automatic;  // arrays own their data
  nb::class_<PyBody>(module, "Body", "A body of a world in its present state. Arrays are copies.")
      .def(
          "__init__",
          [](PyBody* self, nb::object world, const std::string& name) {
            new (self) PyBody(find_body(world, name));
          },
          "world"_a, "name"_a, nb::sig("def __init__(self, world: World, name: str) -> None"))
      .def_ro("name", &PyBody::name)
      .def_prop_ro(
          "world", [](const PyBody& b) { return b.owner; }, "the body's world")
      .def_prop_ro(
          "model", [](const PyBody& b) { return model_name(b.id.kind); },
          "sfem, lattice, rhombus, cloth or rigid")
      .def_prop_ro(
          "rest_points", [](const PyBody& b) { return rows_of(snapshot_of(b).rest); }, kOwn,
          "(n, 3), rest positions of the surface vertices, patient frame [m]")
      .def_prop_ro(
          "points", [](const PyBody& b) { return rows_of(snapshot_of(b).x); }, kOwn,
          "(n, 3), present positions [m]")
      .def_prop_ro(
          "displacement", [](const PyBody& b) { return rows_of(snapshot_of(b).displacement); }, kOwn,
          "(n, 3) [m]")
      .def_prop_ro(
          "normals", [](const PyBody& b) { return rows_of(snapshot_of(b).normals); }, kOwn,
          "(n, 3), unit, outward")
      .def_prop_ro(
          "pressure",
          [](const PyBody& b) { return new_array(std::vector<float>(snapshot_of(b).pressure), 0); }, kOwn,
          "(n,) contact pressure [Pa]; empty if unknown")
      .def_prop_ro(
          "stretch", [](const PyBody& b) { return new_array(std::vector<float>(snapshot_of(b).stretch), 0); },
          kOwn, "(n,) area stretch of the skin: area / rest area - 1; empty if unknown")
      .def_prop_ro(
          "triangles", [](const PyBody& b) { return rows_of(snapshot_of(b).triangles); }, kOwn,
          "(m, 3), counter-clockwise seen from outside; a cut changes them")
      .def_prop_ro(
          "wall_begin", [](const PyBody& b) { return snapshot_of(b).wall_begin; },
          "index of the first wound wall in `triangles`; their number without wounds")
      .def("_volume", [](const PyBody& b) { return fields_of(b.world->as_given(b.name, lattice_of(b).ct)); })
      .def("_deformed_volume", &deformed_volume);
}

}  // namespace turgor
