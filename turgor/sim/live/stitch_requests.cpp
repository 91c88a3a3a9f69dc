// Stitches by requests: single stitches through a wound of the running world, laid and pulled by the code of
// a scene's sutures (sim/bodies/lattice/suture.hpp).
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "turgor/core/assert.hpp"
#include "turgor/sim/live/requests.hpp"
#include "turgor/sim/scene/scene_suture.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

namespace {

constexpr std::size_t kMostPoints = 64;  // of a stitch, as in scenes

/// Largest tension and longest pull, as in scenes.
bool is_pull(const std::optional<double>& tension, double duration) {
  const bool is_tension = !tension || (*tension > 0 && *tension <= 1e4);
  return is_tension && duration > 0 && duration <= 3600;
}

/// Pull that starts at the end of the next frame.
lattice::Pull pull_of(const World& world, const std::optional<double>& tension, double duration) {
  return {.until_closed = !tension,
          .tension = tension.value_or(0),
          .start = time_of(world) + world.dt,
          .duration = duration};
}

Status check_points(const std::vector<Vec3d>& points) {
  bool is_valid = points.size() >= 2 && points.size() <= kMostPoints;
  for (std::size_t n = 0; is_valid && n < points.size(); n++)
    is_valid = std::isfinite(norm(points[n])) && !(points[n] == points[(n + 1) % points.size()]);
  if (is_valid) return Done{};
  return Error{"no stitch: expected two to 64 points, consecutive ones distinct"};
}

/// Reason why no stitch can be made on a body; null if it can.
const char* why_unstitched(const LatticeBody& body) {
  if (body.model.params.solver.method != lattice::Method::kVbd)
    return "no stitch: stitches need solver.method = \"vbd\", found \"pbd\"";
  if (body.state.has_device()) return "no stitch: stitches need world.device = \"cpu\", found \"gpu\"";
  return nullptr;
}

/// True if a cut is complete and can be stitched.
bool is_wound(const Cut& cut, int body) {
  return cut.body == body && cut.path && cut.done >= 1 && !(cut.blade.width > 0);
}

/// Nearest wound that a stitch crosses.
Result<int> crossed_wound(const World& world, const SutureScene& scene) {
  const LatticeBody& body = world.lattice_bodies[std::size_t(scene.body)];
  double least = HUGE_VAL;
  std::optional<int> nearest;
  for (std::size_t c = 0; c < world.cuts.size(); c++) {
    if (!is_wound(world.cuts[c], scene.body)) continue;
    const std::optional<double> distance = distance_of_stitch(scene, body.model, *world.cuts[c].path);
    if (distance && *distance <= least) least = *distance, nearest = int(c);
  }
  if (!nearest)
    return Error{"no stitch: expected points on both sides of a complete cut, found none near them"};
  return *nearest;
}

/// The suture of a scene that a request describes, with its wound.
Result<SutureScene> suture_scene(const StitchRequest& request, const World& world) {
  SutureScene scene;
  scene.name = fmt::format("hand-{}", world.sutures.size() + 1);
  scene.source_location = "stitch by hand";
  scene.body = request.body, scene.through = request.through;
  if (!set_thread(request.thread, scene))
    return Error{fmt::format("no stitch: unknown thread {}, such as nylon 3-0", request.thread)};
  scene.pull = pull_of(world, request.tension, request.duration);
  if (!request.wound) {
    const Result<int> wound = crossed_wound(world, scene);
    if (!wound) return wound.error();
    scene.incision = *wound;
    return scene;
  }
  scene.incision = *request.wound;
  if (scene.incision < 0 || std::size_t(scene.incision) >= world.cuts.size() ||
      !is_wound(world.cuts[std::size_t(scene.incision)], scene.body))
    return Error{"no stitch: expected a complete cut of the body as wound"};
  return scene;
}

}  // namespace

Status apply_request(const Exec&, const StitchRequest& request, std::shared_ptr<const Scene>&, World& world) {
  // body, points and pull
  if (request.body < 0 || std::size_t(request.body) >= world.lattice_bodies.size())
    return Error{"no stitch: unknown lattice body"};
  const LatticeBody& body = world.lattice_bodies[std::size_t(request.body)];
  if (const char* why = why_unstitched(body)) return Error{why};
  if (const Status sound = check_points(request.through); !sound) return sound.error();
  if (!is_pull(request.tension, request.duration))
    return Error{"no stitch: expected a tension up to 10 000 N and a duration up to 3600 s, both above 0"};
  // suture of the wound
  const Result<SutureScene> scene = suture_scene(request, world);
  if (!scene) return scene.error();
  Result<Suture> suture = suture_of_wound(*scene, body, world.cuts[std::size_t(scene->incision)]);
  if (!suture) return suture.error();
  world.sutures.push_back(std::move(*suture));
  return Done{};
}

Status apply_request(const Exec&, const TightenRequest& request, std::shared_ptr<const Scene>& scene,
                     World& world) {
  TURGOR_ASSERT(scene != nullptr, "stitches by requests follow those of a scene");
  if (request.suture < int(scene->sutures.size()) || request.suture >= int(world.sutures.size()))
    return Error{"no pull: expected a stitch by hand"};
  if (!is_pull(request.tension, request.duration))
    return Error{"no pull: expected a tension up to 10 000 N and a duration up to 3600 s, both above 0"};
  Suture& suture = world.sutures[std::size_t(request.suture)];
  lattice::Pull pull = pull_of(world, request.tension, request.duration);
  if (suture.closure) {
    const lattice::Stitch& stitch = suture.closure->stitches.front();
    if (stitch.phase == lattice::StitchPhase::kBroken || stitch.phase == lattice::StitchPhase::kPulledOut)
      return Error{"no pull: the stitch tore"};
    pull.from = stitch.tension;
    untie_stitches(world.lattice_bodies[std::size_t(suture.scene.body)].state->motion, *suture.closure);
  }
  suture.scene.pull = pull;
  return Done{};
}

Status apply_request(const Exec&, const UndoStitchRequest&, std::shared_ptr<const Scene>& scene,
                     World& world) {
  TURGOR_ASSERT(scene != nullptr, "stitches by requests follow those of a scene");
  if (world.sutures.size() <= scene->sutures.size()) return Error{"no undo: there is no stitch by hand"};
  LatticeBody& body = world.lattice_bodies[std::size_t(world.sutures.back().scene.body)];
  remove_suture(body, world.sutures.size() - 1, world.sutures);
  body.state.wake();
  return Done{};
}

}  // namespace turgor
