// What a person may ask of a world between two frames.
#pragma once

#include <memory>
#include <string>
#include <variant>

#include "turgor/core/exec.hpp"
#include "turgor/core/result.hpp"
#include "turgor/models/lattice/incision.hpp"
#include "turgor/sim/scene/scene.hpp"

namespace turgor {

struct World;

/// A blade, from now on.
struct AskCut {
  lattice::Incision blade;
  int body = 0;  // of World::lattice_bodies
};
struct AskWind {
  int body = 0;    // of World::cloth_bodies
  Vec3d velocity;  // [m/s]
};
/// A key of the scene, at once where that is possible (change_world.hpp), else with the next world.
struct AskChange {
  std::string key, value;
};
using WorldAsk = std::variant<AskCut, AskWind, AskChange>;

/// Does it. Error: a sentence, and nothing was done.
Status grant(const Exec& exec, const AskCut& ask, std::shared_ptr<const Scene>& scene, World& world);
Status grant(const Exec& exec, const AskWind& ask, std::shared_ptr<const Scene>& scene, World& world);
Status grant(const Exec& exec, const AskChange& ask, std::shared_ptr<const Scene>& scene, World& world);

}  // namespace turgor
