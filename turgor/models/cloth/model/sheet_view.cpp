#include "turgor/models/cloth/model/sheet_view.hpp"

#include "turgor/core/assert.hpp"
#include "turgor/models/cloth/model/state.hpp"

namespace turgor::cloth {

SheetView view(const Model& model, State& state) {
  TURGOR_CHECK(state.x.size() == model.mass.size() && state.v.size() == state.x.size(),
               "positions are on the host");
  TURGOR_CHECK(state.free_mass.size() == model.mass.size(), "every vertex has a mass");
  // pointers into model and state, without copies
  System& system = state.system;
  return {.size = state.x.size(),
          .rows = view(model.rows),
          .far = view(model.far_rows),
          .extra_diagonal = model.extra_diagonal.empty() ? nullptr : model.extra_diagonal.data(),
          .x_rest = view(model.x_rest),
          .x = view(state.x),
          .v = view(state.v),
          .free_mass = state.free_mass.data(),
          .along = system.along.data(),
          .across = system.across.data(),
          .force = view(system.force),
          .inverse = {view(system.inverse[0]), view(system.inverse[1])},
          .change = view(system.change),
          .previous = view(system.previous),
          .air = {view(system.air[0]), view(system.air[1])},
          .stiffness_factor = system.stiffness_factor};
}

}  // namespace turgor::cloth
