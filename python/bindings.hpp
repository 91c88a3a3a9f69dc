// Binding functions of the module, one per source file.
#pragma once

#include "world.hpp"

namespace turgor {

/// A body of a world. It keeps the world alive.
struct PyBody {
  nb::object owner;  // the Python World
  PyWorld* world = nullptr;
  BodyId id;
  std::string name;
};

/// Body of that name. Throws KeyError for an unknown one.
BodyId named_body(const PyWorld& world, const std::string& name);

void bind_body(nb::module_& module);
void bind_by_hand(nb::class_<PyWorld>& world);
void bind_live(nb::module_& module);
void bind_world(nb::module_& module);
void bind_identify(nb::module_& module);
void bind_run(nb::module_& module);
void bind_recording(nb::module_& module);

}  // namespace turgor
