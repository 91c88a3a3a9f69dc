// The parts of the module, each in a source of its own.
#pragma once

#include "world.hpp"

namespace turgor {

/// A body of a world, by its name. Python keeps the world as long as this.
struct PyBody {
  nb::object owner;  // the World, as Python has it
  PyWorld* world = nullptr;
  BodyId id;
  std::string name;
};

void bind_body(nb::module_& module);
void bind_live(nb::module_& module);
void bind_world(nb::module_& module);
void bind_run(nb::module_& module);

}  // namespace turgor
