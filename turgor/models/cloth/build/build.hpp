// Construction of a cloth from a triangle mesh: checks, springs or sheet, masses, numbering, tables.
#pragma once

#include "turgor/models/cloth/model/state.hpp"

namespace turgor::cloth {

/// Builds the model. Error, with the ids of the culprits: no triangle; a vertex without finite coordinates or
/// without a triangle (it has no mass); a triangle without area; material parameters that are not positive; a
/// thickness above the median edge length.
Result<Model> build(const Exec& exec, const TriMesh& mesh, const Params& params);
/// Initial state: the rest positions, at rest.
State make_state(const Model& model);

}  // namespace turgor::cloth
