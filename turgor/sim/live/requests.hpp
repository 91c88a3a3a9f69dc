// What a person may ask of a world between two frames.
#pragma once

#include <memory>
#include <string>
#include <variant>

#include "turgor/core/exec.hpp"
#include "turgor/core/result.hpp"
#include "turgor/models/lattice/cutting/incision.hpp"
#include "turgor/sim/scene/scene.hpp"

namespace turgor {

struct World;

/// A blade, from now on.
struct CutRequest {
  lattice::Incision blade;
  int body = 0;  // of World::lattice_bodies
};
struct WindRequest {
  int body = 0;    // of World::cloth_bodies
  Vec3d velocity;  // [m/s]
};
/// A key of the scene, at once where that is possible (change_world.hpp), else with the next world.
struct ChangeRequest {
  std::string key, value;
};
using WorldRequest = std::variant<CutRequest, WindRequest, ChangeRequest>;

/// Does it. Error: a sentence, and nothing was done.
Status apply_request(const Exec& exec, const CutRequest& request, std::shared_ptr<const Scene>& scene,
                     World& world);
Status apply_request(const Exec& exec, const WindRequest& request, std::shared_ptr<const Scene>& scene,
                     World& world);
Status apply_request(const Exec& exec, const ChangeRequest& request, std::shared_ptr<const Scene>& scene,
                     World& world);

}  // namespace turgor
