// Requests that change a world between two frames.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <variant>

#include "turgor/core/exec.hpp"
#include "turgor/core/result.hpp"
#include "turgor/models/lattice/cutting/incision.hpp"
#include "turgor/sim/scene/scene.hpp"

namespace turgor {

struct World;

/// Starts a cut at the present time.
struct CutRequest {
  lattice::Incision blade;
  int body = 0;  // index into World::lattice_bodies
};
struct WindRequest {
  int body = 0;                   // index into World::cloth_bodies
  std::optional<Vec3d> velocity;  // empty: the wind of the scene [m/s]
};
/// Sets a scene key, or without a value removes the override of the key, so that the scene's text counts. The
/// change acts immediately if possible (change_world.hpp), otherwise after the next reset.
struct ChangeRequest {
  std::string key;
  std::optional<std::string> value;
};
/// Takes back the latest cut that was made by a request: its body returns to its state before the cut.
struct UndoCutRequest {};
using WorldRequest = std::variant<CutRequest, WindRequest, ChangeRequest, UndoCutRequest>;

/// Applies a request. On error the world is unchanged.
Status apply_request(const Exec& exec, const CutRequest& request, std::shared_ptr<const Scene>& scene,
                     World& world);
Status apply_request(const Exec& exec, const WindRequest& request, std::shared_ptr<const Scene>& scene,
                     World& world);
Status apply_request(const Exec& exec, const ChangeRequest& request, std::shared_ptr<const Scene>& scene,
                     World& world);
Status apply_request(const Exec& exec, const UndoCutRequest& request, std::shared_ptr<const Scene>& scene,
                     World& world);

}  // namespace turgor
