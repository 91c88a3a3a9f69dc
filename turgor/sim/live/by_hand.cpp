#include "turgor/sim/live/by_hand.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "turgor/sim/live/requests.hpp"
#include "turgor/sim/scene/name.hpp"
#include "turgor/sim/scene/nearest_name.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

namespace {

Status check_lattice(const char* refused, BodyId body) {
  if (body.kind == BodyKind::kLattice) return Done{};
  return Error{fmt::format("{}: expected a body with model = \"lattice\", found one with model = \"{}\"",
                           refused, model_name(body.kind))};
}

std::vector<std::string> wound_names(const World& world) {
  std::vector<std::string> names;
  for (const Cut& cut : world.cuts) names.push_back(cut.blade.name);
  return names;
}

/// Name of a new wound: the given one, or the first of hand-1, hand-2, … that is free.
Result<std::string> new_wound_name(const std::string& given, const World& world) {
  const std::vector<std::string> taken = wound_names(world);
  const auto is_taken = [&](const std::string& name) {
    return std::find(taken.begin(), taken.end(), name) != taken.end();
  };
  if (given.empty()) {
    std::string name;
    for (int n = 1; n == 1 || is_taken(name); n++) name = fmt::format("hand-{}", n);
    return name;
  }
  if (!is_name(given))
    return Error{
        fmt::format("no cut: expected a name of up to 64 letters, digits, _ and -, found {}", given)};
  if (is_taken(given))
    return Error{fmt::format("no cut: expected a name of its own, found that of another wound, {}", given)};
  return given;
}

/// Limits of [incision.NAME] (scene_incision.cpp).
Status check_cut(const CutByHand& cut) {
  constexpr double kFarthest = 100, kSteepest = 75, kLongest = 3600;
  const auto refuse = [](const char* expected, double found) {
    return Error{fmt::format("no cut: expected {}, found {}", expected, found)};
  };
  if (!(cut.depth > 0 && cut.depth < 1)) return refuse("a depth above 0 and below 1 m", cut.depth);
  if (!(std::abs(cut.tilt) <= kSteepest)) return refuse("a tilt from -75 to 75 degrees", cut.tilt);
  if (!(cut.duration >= 0 && cut.duration <= kLongest))
    return refuse("a duration from 0 to 3600 s", cut.duration);
  bool is_valid = cut.points.size() >= 2;
  for (std::size_t n = 0; is_valid && n < cut.points.size(); n++) {
    const Vec3d p = cut.points[n];
    is_valid = is_finite(p) && std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) <= kFarthest &&
               (n == 0 || !(p == cut.points[n - 1]));
  }
  if (is_valid) return Done{};
  return Error{"no cut: expected at least two points [x, y, z] within 100 m, consecutive ones distinct"};
}

/// Index into World::cuts.
Result<int> wound_number(const std::string& name, const World& world) {
  const std::vector<std::string> names = wound_names(world);
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end())
    return Error{fmt::format("no stitch: the world has no wound {}{}", name, suggestion(name, names))};
  return int(found - names.begin());
}

}  // namespace

Result<std::string> cut_by_hand(const Exec& exec, const CutByHand& cut, std::shared_ptr<const Scene>& scene,
                                World& world) {
  if (const Status lattice = check_lattice("no cut", cut.body); !lattice) return lattice.error();
  if (const Status sound = check_cut(cut); !sound) return sound.error();
  const Result<std::string> name = new_wound_name(cut.name, world);
  if (!name) return name.error();
  CutRequest request{.blade = {.name = *name,
                               .from = cut.points.front(),
                               .to = cut.points.back(),
                               .depth = cut.depth,
                               .tilt = cut.tilt,
                               .duration = cut.duration},
                     .body = cut.body.index};
  if (cut.points.size() > 2) request.blade.path = cut.points;
  if (const Status started = apply_request(exec, request, scene, world); !started) return started.error();
  world.cuts.back().before.reset();  // copies of a world take a cut back
  return *name;
}

Result<std::string> stitch_by_hand(const Exec& exec, const StitchByHand& stitch,
                                   std::shared_ptr<const Scene>& scene, World& world) {
  if (const Status lattice = check_lattice("no stitch", stitch.body); !lattice) return lattice.error();
  StitchRequest request{.body = stitch.body.index,
                        .wound = {},
                        .through = stitch.points,
                        .thread = stitch.thread,
                        .tension = stitch.tension,
                        .duration = stitch.duration};
  if (!stitch.wound.empty()) {
    const Result<int> wound = wound_number(stitch.wound, world);
    if (!wound) return wound.error();
    request.wound = *wound;
  }
  if (const Status laid = apply_request(exec, request, scene, world); !laid) return laid.error();
  return world.sutures.back().scene.name;
}

Status tighten_by_hand(const Exec& exec, const std::string& stitch, std::optional<double> tension,
                       double duration, std::shared_ptr<const Scene>& scene, World& world) {
  std::vector<std::string> names;
  for (std::size_t s = scene->sutures.size(); s < world.sutures.size(); s++)
    names.push_back(world.sutures[s].scene.name);
  const auto found = std::find(names.begin(), names.end(), stitch);
  if (found == names.end())
    return Error{
        fmt::format("no pull: the world has no stitch by hand {}{}", stitch, suggestion(stitch, names))};
  const int suture = int(scene->sutures.size()) + int(found - names.begin());
  return apply_request(exec, TightenRequest{.suture = suture, .tension = tension, .duration = duration},
                       scene, world);
}

}  // namespace turgor
